"""From one local East-North-Up frame into another, both with their zero in WGS-84: a rotation and a shift.

With the rows of E being the ECEF components of east, north and up at an origin o, a point p has the ECEF position
o + E^T p, so a point of frame 1 lies in frame 2 at

    p2 = A p1 + t,    A = E2 E1^T,    t = E2 (o1 - o2).

Directions and velocities turn with A. "North" of frame 1 points `turn` clockwise from the north of frame 2 (the
convergence of the meridians); seen from 100 km away at 55 degrees latitude that is more than a degree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.site import Origin

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class FrameChange:
    """What takes points of one frame into another.

    Attributes
    ----------
    rotation : (3, 3) float
    shift_m : (3,) float, m, where the zero of the old frame lies in the new one
    """

    rotation: Floats
    shift_m: Floats

    def points(self, points_m: Floats) -> Floats:
        """(..., 3) m in the old frame -> (..., 3) m in the new one; NaN stays NaN."""
        moved: Floats = np.asarray(points_m, float) @ self.rotation.T + self.shift_m
        return moved

    def vectors(self, vectors: Floats) -> Floats:
        """(..., 3) velocities or directions, turned."""
        turned: Floats = np.asarray(vectors, float) @ self.rotation.T
        return turned

    @property
    def turn_rad(self) -> float:
        """Azimuth of the old frame's north in the new frame, rad clockwise from its north."""
        return float(np.arctan2(self.rotation[0, 1], self.rotation[1, 1]))


def frame_change(old: Origin, new: Origin) -> FrameChange:
    """Return what takes points of the frame at `old` into that at `new`."""
    axes = _axes(new)
    difference = np.subtract(_ecef(old), _ecef(new))
    return FrameChange(axes @ _axes(old).T, axes @ difference)


def _ecef(origin: Origin) -> Floats:
    return np.array(pymap3d.geodetic2ecef(origin.latitude_deg, origin.longitude_deg, origin.height_m), float)


def _axes(origin: Origin) -> Floats:
    """Rows: ECEF components of east, north, up."""
    lat, lon = np.radians(origin.latitude_deg), np.radians(origin.longitude_deg)
    return np.array(
        [
            [-np.sin(lon), np.cos(lon), 0.0],
            [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)],
            [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
        ]
    )
