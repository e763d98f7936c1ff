"""Plots of one radar as the trackers take them: cleaned, cut into scans, trials side by side.

What cannot be a plot, or repeats one, is left out and counted by cause; nothing is repaired.

References
----------
Specification 6 (step 0), 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import PolarPlots
from algorithms.toolbox.motion.curvature import wrapped

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FARTHEST_M = 1_000e3
# Two plots this near to each other in everything are one that was written twice.
SAME_TIME_S, SAME_RANGE_M, SAME_AZIMUTH_RAD = 1e-3, 1e-2, 1e-8
NOT_MEASURED, TAKEN, NO_NUMBER, OUT_OF_RANGE, REPEATED, LATE = range(6)
FATES = (
    "",
    "taken",
    "range or azimuth is not a number",
    "range is not between 0 and 1,000 km",
    "repeats another plot",
    "its scan is no later than the one before",
)


@dataclass(frozen=True)
class Scan:
    """Plots of all trials in one turn of the antenna, in the order of trial, range, azimuth.

    Attributes
    ----------
    time_s : of the scan, the latest of its plots
    lane, position : (P,) trial, and position of the plot's row in the recording
    t, rho, theta : (P,) s, m, rad
    """

    time_s: float
    lane: Ints
    position: Ints
    t: Floats
    rho: Floats
    theta: Floats


@dataclass(frozen=True)
class Plots:
    """All scans of one radar, and what became of each row (M, L): a code of `FATES`."""

    scans: tuple[Scan, ...]
    fate: Ints
    lanes: int

    @property
    def period_s(self) -> float:
        """Median time between scans, s; 1 where there is but one."""
        steps = np.diff([scan.time_s for scan in self.scans])
        return float(np.median(steps)) if steps.size else 1.0


def plots_of(recording: PolarPlots, rows: Ints) -> Plots:
    """Clean and cut the rows of one radar.

    A row's scan is its number where it has one; rows without belong to the scan of their time.
    """
    rho, theta = recording.range_m[rows], recording.azimuth_rad[rows]
    east, north = recording.east_m[rows], recording.north_m[rows]
    cartesian = np.isfinite(east) & np.isfinite(north)
    rho = np.where(cartesian, np.hypot(east, north), rho)
    theta = wrapped(np.where(cartesian, np.arctan2(east, north), theta))
    fate = np.full(rho.shape, TAKEN)
    fate[np.isnan(rho) & np.isnan(theta)] = NOT_MEASURED
    fate[(fate == TAKEN) & ~(np.isfinite(rho) & np.isfinite(theta))] = NO_NUMBER
    with np.errstate(invalid="ignore"):
        fate[(fate == TAKEN) & ~((rho > 0) & (rho <= FARTHEST_M))] = OUT_OF_RANGE
    time = recording.time_s[rows]
    scans: list[Scan] = []
    for inside in _cut(time, recording.scan[rows]):
        scan, fate[inside] = _scan(time[inside], rho[inside], theta[inside], fate[inside], rows[inside])
        if scan.position.size and scans and scan.time_s <= scans[-1].time_s + SAME_TIME_S:
            # Between two scans of one instant nothing can have moved, and no velocity follows.
            late = fate[inside]
            late[late == TAKEN] = LATE
            fate[inside] = late
        elif scan.position.size:
            scans.append(scan)
    return Plots(tuple(scans), fate, rho.shape[1])


def _cut(time: Floats, scan: Ints) -> list[Ints]:
    """Positions of the rows of each scan, in the order of time."""
    if not time.size:
        return []
    numbered = scan >= 0
    key = np.where(numbered, scan.astype(float), time)
    kind = np.where(numbered, 0, 1)
    _, group = np.unique(np.stack([kind, key]), axis=1, return_inverse=True)
    group = group.ravel()
    parts = np.split(np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))[:-1])
    return sorted(parts, key=lambda part: float(time[part].max()))


def _scan(time: Floats, rho: Floats, theta: Floats, fate: Ints, rows: Ints) -> tuple[Scan, Ints]:
    """The plots of one scan, and the fates of its rows with what repeats marked."""
    row, lane = np.nonzero(fate == TAKEN)
    order = np.lexsort((theta[row, lane], rho[row, lane], lane))
    row, lane = row[order], lane[order]
    r, a, t = rho[row, lane], theta[row, lane], time[row]
    same = np.zeros(row.size, bool)
    if row.size > 1:
        same[1:] = (
            (lane[1:] == lane[:-1])
            & (np.abs(np.diff(t)) <= SAME_TIME_S)
            & (np.diff(r) <= SAME_RANGE_M)
            & (np.abs(np.diff(a)) <= SAME_AZIMUTH_RAD)
        )
        fate = fate.copy()
        fate[row[same], lane[same]] = REPEATED
    kept = ~same
    return Scan(float(time.max()), lane[kept], rows[row[kept]], t[kept], r[kept], a[kept]), fate
