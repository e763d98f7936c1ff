"""From a recording to what the filter takes: coordinates, their accuracies, converted positions, groups of plots.

Antenna plots need the site's antenna (place, azimuth, elevation). Polar plots have range and azimuth, and elevation
where the radar measures it; without one the height is the decoded altitude or an assumed one, and range is brought to
the ground with it. Plots given as east and north are positions already.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import RecordingError
from algorithms.multiple_model.parameters import (
    SIGMA_ANGLE_DEG,
    SIGMA_AZIMUTH_DEG,
    SIGMA_PLAN_M,
    SIGMA_RANGE_M,
    MeasurementParameters,
)
from algorithms.multiple_model.states import Marks
from algorithms.recording import AntennaPlots, PolarPlots
from algorithms.result import Note, Setting
from algorithms.site import Radar
from algorithms.toolbox.frames.bicone import (
    antenna_axes,
    conversion_index,
    position_from_bicone,
    within_domain,
)
from algorithms.toolbox.sensors.position_rows import BICONE, CARTESIAN, PLAN, POLAR

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Plots = AntennaPlots | PolarPlots
Item = TypeVar("Item", bound=np.generic)

BAD_CONVERSION = 0.5
"""Above this r s^2 / sigma_r a converted mark is biased by as much as half its range error."""


@dataclass
class Prepared:
    """Measurements of a whole recording, before they are cut into targets and lanes; see `Marks`."""

    kind: Ints
    sensor: Ints
    axes: Floats
    origin: Floats
    sd: Floats
    z: Floats
    y: Floats
    valid: Ints
    dof: Ints
    settings: dict[str, Setting] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)

    def marks(self, recording: Plots, rows: Ints, part: slice, group: Ints, boost: Floats | None = None) -> Marks:
        """Rows of one target and a block of lanes; `boost` (M, L) of the whole recording, see `Marks`."""

        def cut(array: NDArray[Item]) -> NDArray[Item]:
            chosen = array if rows.size == len(array) else array[rows]
            return np.ascontiguousarray(chosen[..., part])

        return Marks(
            time=recording.time_s[rows],
            group=group,
            kind=self.kind[rows],
            sensor=self.sensor[rows],
            axes=self.axes,
            origin=self.origin[rows],
            sd=self.sd[rows],
            z=cut(self.z),
            y=cut(self.y),
            valid=cut(self.valid),
            dof=self.dof[rows],
            boost=np.empty((0, 0)) if boost is None else cut(boost),
        )


def prepare(recording: Plots, parameters: MeasurementParameters) -> Prepared:
    """Resolve accuracies (the run's, the site's, the program's) and convert every measurement.

    Raises
    ------
    RecordingError
        No site, or an antenna without a direction.
    """
    if isinstance(recording, AntennaPlots):
        return _antenna(recording, parameters)
    return _polar(recording, parameters)


def _sites_radars(recording: Plots) -> tuple[Radar, ...]:
    site = recording.site
    if site is None or not site.radars:
        raise RecordingError(
            "the recording has no site, so nobody knows where its radar stands",
            pointer="/site",
            remedy="read the recording again with a site whose `radars` hold it",
            code="site_missing",
        )
    return site.radars


def antenna_of(recording: AntennaPlots) -> Radar:
    """Return the antenna: the site's first radar, which must say where it looks."""
    antenna = _sites_radars(recording)[0]
    if antenna.azimuth_deg is None or antenna.elevation_deg is None:
        raise RecordingError(
            f"the site does not say where the antenna {antenna.name} looks",
            pointer="/site/radars/0",
            remedy="give it `azimuth_deg` (clockwise from north) and `elevation_deg`",
            code="antenna_direction",
        )
    return antenna


def _resolver(
    parameters: MeasurementParameters, settings: dict[str, Setting]
) -> Callable[[str, Radar | None, float], float]:
    def resolve(name: str, radar: Radar | None, fallback: float) -> float:
        given = getattr(parameters, name)
        own = getattr(radar, name, None) if radar is not None else None
        value, source = (given, "run") if given is not None else (own, "site") if own else (fallback, "default")
        known = settings.get(name)
        if known is not None and known.value != value:
            settings[name] = Setting([*np.atleast_1d(known.value).tolist(), value], known.source)
        elif known is None:
            settings[name] = Setting(float(value), source)
        return float(value)

    return resolve


def _antenna(recording: AntennaPlots, parameters: MeasurementParameters) -> Prepared:
    antenna = antenna_of(recording)
    settings: dict[str, Setting] = {}
    resolve = _resolver(parameters, settings)
    sd = (
        resolve("sigma_range_m", antenna, SIGMA_RANGE_M),
        np.radians(resolve("sigma_bicone_elevation_deg", antenna, SIGMA_ANGLE_DEG)),
        np.radians(resolve("sigma_bicone_azimuth_deg", antenna, SIGMA_ANGLE_DEG)),
    )
    assert recording.site is not None
    centre = recording.site.radar_positions()[0]
    axes = antenna_axes(np.radians(antenna.azimuth_deg or 0.0), np.radians(antenna.elevation_deg or 0.0))
    z = np.stack([recording.range_m, recording.bicone_elevation_rad, recording.bicone_azimuth_rad], axis=1)
    inside = within_domain(z[:, 0], z[:, 1], z[:, 2])
    safe = np.where(inside[:, None], z, np.array([1.0, 0.0, 0.0])[:, None])
    y = np.moveaxis(position_from_bicone(safe[:, 0], safe[:, 1], safe[:, 2], axes, centre), -1, 1)
    m = len(inside)
    out = Prepared(
        kind=np.full(m, BICONE), sensor=np.zeros(m, np.int64), axes=axes[None], origin=np.tile(centre, (m, 1)),
        sd=np.tile(np.array(sd), (m, 1)), z=z, y=np.ascontiguousarray(y), valid=inside.astype(np.int64),
        dof=np.full(m, 3), settings=settings,
    )  # fmt: skip
    far = safe[:, 0].max(initial=0.0)
    index = float(conversion_index(far, sd[0], float(max(sd[1], sd[2]))))
    settings["conversion_index"] = Setting(round(index, 4), "default")
    if index > BAD_CONVERSION and parameters.measurement.startswith("converted"):
        out.notes.append(
            Note(
                "conversion_index",
                "converted measurements are biased by more than half their range error at the largest range; "
                "filter in the measurement's own coordinates",
            )
        )
    _note_outside(out)
    return out


def _polar(recording: PolarPlots, parameters: MeasurementParameters) -> Prepared:
    settings: dict[str, Setting] = {}
    resolve = _resolver(parameters, settings)
    cartesian = np.isfinite(recording.east_m).any() and not np.isfinite(recording.range_m).any()
    site = recording.site
    radars: tuple[Radar | None, ...]
    if cartesian and (site is None or not site.radars):
        radars, places = (None,) * len(recording.radars), np.zeros((len(recording.radars), 3))
    else:
        found = _sites_radars(recording)
        names = [r.name for r in found]
        order = [names.index(n) if n in names else min(i, len(names) - 1) for i, n in enumerate(recording.radars)]
        assert site is not None
        radars, places = tuple(found[i] for i in order), site.radar_positions()[order]
    m, lanes = recording.range_m.shape
    origin = places[recording.radar]
    for axis, moving in ((0, recording.radar_east_m), (1, recording.radar_north_m)):
        origin[:, axis] = np.where(np.isfinite(moving), moving, origin[:, axis])
    height = np.where(np.isfinite(recording.altitude_m), recording.altitude_m, parameters.assumed_height_m)
    elevated = np.isfinite(recording.elevation_rad).any()
    kind, sd = np.empty(m, np.int64), np.empty((m, 3))
    z, y = np.empty((m, 3, lanes)), np.empty((m, 3, lanes))
    for i, radar in enumerate(radars):
        rows = np.flatnonzero(recording.radar == i)
        if rows.size == 0:
            continue
        if cartesian:
            errors = [resolve(f"sigma_{a}_m", radar, SIGMA_PLAN_M) for a in ("east", "north")]
            errors.append(parameters.sigma_height_m)
            kind[rows] = CARTESIAN
            shift = origin[rows][:, :2, None]
            z[rows] = np.stack([recording.east_m[rows], recording.north_m[rows], height[rows]], axis=1)
            y[rows] = z[rows]
            y[rows, :2] += shift
            z[rows, 2] -= origin[rows, 2][:, None]
        else:
            errors = [
                resolve("sigma_range_m", radar, SIGMA_RANGE_M),
                np.radians(resolve("sigma_azimuth_deg", radar, SIGMA_AZIMUTH_DEG)),
            ]
            r, b = recording.range_m[rows], recording.azimuth_rad[rows]
            if elevated:
                errors.append(np.radians(resolve("sigma_elevation_deg", radar, SIGMA_AZIMUTH_DEG)))
                kind[rows] = POLAR
                z[rows] = np.stack([r, b, recording.elevation_rad[rows]], axis=1)
                plan, up = r * np.cos(recording.elevation_rad[rows]), r * np.sin(recording.elevation_rad[rows])
            else:
                errors.append(parameters.sigma_height_m)
                kind[rows] = PLAN
                up = height[rows] - origin[rows, 2][:, None]
                slant = radar is None or radar.range_kind != "ground"
                plan = np.sqrt(np.maximum(r * r - up * up, 0.0)) if slant else r
                z[rows] = np.stack([plan, b, up], axis=1)
            y[rows] = np.stack([plan * np.sin(b), plan * np.cos(b), up], axis=1) + origin[rows][:, :, None]
        sd[rows] = np.array(errors)
    valid = np.asarray(np.isfinite(z).all(axis=1) & np.isfinite(y).all(axis=1))
    if not cartesian:
        valid &= z[:, 0] > 0
    out = Prepared(
        kind=kind, sensor=recording.radar.copy(), axes=np.repeat(np.eye(3)[None], len(recording.radars), axis=0),
        origin=origin, sd=sd, z=z, y=y, valid=valid.astype(np.int64),
        dof=np.where(kind == POLAR, 3, 2), settings=settings,
    )  # fmt: skip
    _note_outside(out)
    return out


def _note_outside(prepared: Prepared) -> None:
    outside = int((prepared.valid == 0).sum())
    if outside:
        prepared.notes.append(
            Note("outside_domain", "measurements outside the domain of the sensor's coordinates are misses", outside)
        )


def groups_of(recording: Plots, rows: Ints, sensor: Ints, *, by_scan: bool) -> Ints:
    """(G + 1,) where groups begin in `rows`: rows of one time and radar, or of one scan where scans are numbered."""
    if not by_scan or rows.size == 0:
        return np.arange(rows.size + 1)
    scan = recording.scan[rows] if isinstance(recording, PolarPlots) else np.full(rows.size, -1)
    time, radar = recording.time_s[rows], sensor[rows]
    same = (np.diff(radar) == 0) & ((np.diff(time) == 0) | ((np.diff(scan) == 0) & (scan[1:] >= 0)))
    return np.concatenate([[0], np.flatnonzero(~same) + 1, [rows.size]])
