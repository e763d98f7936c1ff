"""Where the stations stand: one validated description of a site, its JSON and its numbers.

A `Site` is read from JSON (or made by a reader from a sensor table), and every station's position is known in
one local East-North-Up frame. Positions given as latitude, longitude and height are converted with the site's
origin; without an origin the centre of the stations (height 0) becomes the origin.
"""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
import pymap3d
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, model_validator

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e9, le=1e9)]
Positive = Annotated[float, Field(allow_inf_nan=False, gt=0, le=1e9)]
Latitude = Annotated[float, Field(allow_inf_nan=False, ge=-90, le=90)]
Longitude = Annotated[float, Field(allow_inf_nan=False, ge=-180, le=360)]
Name = Annotated[str, Field(min_length=1, max_length=80)]

# Stations closer than this are one station given twice: their difference carries no geometry.
SAME_PLACE_M = 0.01


class _Model(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)


class Origin(_Model):
    """WGS-84 position of the local frame's zero."""

    latitude_deg: Latitude
    longitude_deg: Longitude
    height_m: Finite = 0.0


class _Place(_Model):
    """A named position, given in the local frame or in WGS-84 (exactly one of the two)."""

    name: Name
    east_m: Finite | None = None
    north_m: Finite | None = None
    up_m: Finite | None = None
    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    height_m: Finite | None = None

    @model_validator(mode="after")
    def _one_position(self) -> Self:
        local = (self.east_m, self.north_m)
        geodetic = (self.latitude_deg, self.longitude_deg)
        if None not in local and geodetic == (None, None):
            return self
        if None not in geodetic and local == (None, None) and self.up_m is None:
            return self
        raise ValueError(
            "give either east_m, north_m, up_m or latitude_deg, longitude_deg, height_m (one of the two, complete)"
        )

    @property
    def is_geodetic(self) -> bool:
        """Whether the position was given in WGS-84."""
        return self.latitude_deg is not None


class Station(_Place):
    """A passive receiver of a multilateration site."""

    sigma_toa_ns: Positive | None = None
    """Standard deviation of this station's times of arrival, ns."""
    clock_offset_ns: Finite = 0.0
    """Known clock error, ns, subtracted from this station's times of arrival."""


class Radar(_Place):
    """A radar or an antenna with its accuracies."""

    sigma_range_m: Positive | None = None
    sigma_azimuth_deg: Positive | None = None
    sigma_elevation_deg: Positive | None = None
    sigma_east_m: Positive | None = None
    sigma_north_m: Positive | None = None
    period_s: Positive | None = None
    range_kind: Annotated[str, Field(pattern="^(slant|ground)$")] | None = None
    azimuth_deg: Finite | None = None
    """Direction in which an antenna looks, degrees clockwise from north."""
    elevation_deg: Finite | None = None
    sigma_bicone_elevation_deg: Positive | None = None
    sigma_bicone_azimuth_deg: Positive | None = None


class Terminal(_Place):
    """A transmitter or a receiver of a forward-scatter site."""


class Site(_Model):
    """Stations, radars or terminals in one local frame."""

    origin: Origin | None = None
    stations: tuple[Station, ...] = ()
    radars: tuple[Radar, ...] = ()
    transmitters: tuple[Terminal, ...] = ()
    receivers: tuple[Terminal, ...] = ()
    wavelength_m: Positive | None = None
    sigma_doppler_hz: Positive | None = None
    sigma_toa_ns: Positive | None = None
    """Default standard deviation of the times of arrival of all stations, ns."""
    gate_length_s: Positive | None = None
    sigma_altitude_m: Positive | None = None
    """Default standard deviation of the altitude observation, m."""

    @model_validator(mode="after")
    def _sound(self) -> Self:
        for field in ("stations", "radars", "transmitters", "receivers"):
            places: tuple[_Place, ...] = getattr(self, field)
            names = [p.name for p in places]
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise ValueError(f"{field}[{i}] repeats the name {name!r}; names must be unique")
            if self.origin is None and any(p.is_geodetic for p in places) and not all(p.is_geodetic for p in places):
                raise ValueError(f"{field} mix local and WGS-84 positions; an origin is needed to join them")
        if self.stations:
            if len(self.stations) < 2:
                raise ValueError("stations: at least two are needed to measure a time difference")
            p = self.station_positions()
            for i in range(len(p)):
                near = np.flatnonzero(np.linalg.norm(p[:i] - p[i], axis=1) < SAME_PLACE_M)
                if near.size:
                    raise ValueError(
                        f"stations[{i}] ({self.stations[i].name}) stands at the same place as "
                        f"stations[{near[0]}] ({self.stations[near[0]].name}); remove one of them"
                    )
        return self

    def frame_origin(self) -> Origin | None:
        """Origin of the local frame: the given one, else the median of the WGS-84 positions at height 0, else None.

        The median, because one receiver entered a thousand kilometres away must not tilt everybody's frame.
        """
        if self.origin is not None:
            return self.origin
        places = [p for p in (*self.stations, *self.radars, *self.transmitters, *self.receivers) if p.is_geodetic]
        if not places:
            return None
        lat = np.array([p.latitude_deg for p in places], float)
        lon = np.array([p.longitude_deg for p in places], float)
        # Unit vectors have no seam at the date line.
        x, y, z = (
            np.median(v)
            for v in (
                np.cos(np.radians(lat)) * np.cos(np.radians(lon)),
                np.cos(np.radians(lat)) * np.sin(np.radians(lon)),
                np.sin(np.radians(lat)),
            )
        )
        return Origin(
            latitude_deg=round(float(np.degrees(np.arctan2(z, np.hypot(x, y)))), 6),
            longitude_deg=round(float(np.degrees(np.arctan2(y, x))), 6),
        )

    def _positions(self, places: tuple[_Place, ...]) -> NDArray[np.float64]:
        origin = self.frame_origin()
        out = np.empty((len(places), 3))
        for i, p in enumerate(places):
            if p.is_geodetic:
                assert origin is not None
                out[i] = pymap3d.geodetic2enu(
                    p.latitude_deg,
                    p.longitude_deg,
                    p.height_m or 0.0,
                    origin.latitude_deg,
                    origin.longitude_deg,
                    origin.height_m,
                )
            else:
                out[i] = (p.east_m, p.north_m, p.up_m or 0.0)
        return out

    def station_positions(self) -> NDArray[np.float64]:
        """(station, 3) float, m: stations in the local ENU frame."""
        return self._positions(self.stations)

    def radar_positions(self) -> NDArray[np.float64]:
        """(radar, 3) float, m: radars in the local ENU frame."""
        return self._positions(self.radars)

    def terminal_positions(self) -> NDArray[np.float64]:
        """(terminal, 3) float, m: transmitters, then receivers, in the local ENU frame."""
        return self._positions((*self.transmitters, *self.receivers))

    def to_json(self) -> dict[str, Any]:
        """As JSON, without what was not given."""
        return self.model_dump(mode="json", exclude_none=True, exclude_defaults=True)
