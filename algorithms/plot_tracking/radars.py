"""From a recording to what a tracker takes of each radar: clean scans in the radar's own frame, and their accuracies.

One radar at a time is tracked. Its frame has its place as zero; of a radar that moves, where it stood first. Slant
ranges become ground ranges where a plot has an altitude. `Feed.to_site` brings places and velocities of the tracks
into the frame of the site.

References
----------
Specification 6 (step 0), 10.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.errors import RecordingError
from algorithms.plot_tracking.parameters import RadarAccuracy
from algorithms.plot_tracking.plots import FATES, NOT_MEASURED, TAKEN, Plots, plots_of
from algorithms.plot_tracking.turns import turning_period, turns_of
from algorithms.recording import PolarPlots
from algorithms.result import Note, Setting
from algorithms.site import Radar, Site
from algorithms.toolbox.frames.slant import ground_from_slant

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# An azimuth beyond a full turn is no number of radians.
LARGEST_AZIMUTH_RAD = 2 * np.pi + 0.01
# Share of plots of which an instant must be shared with others for instants to be scans.
SHARED_INSTANT = 0.5


@dataclass(frozen=True)
class Feed:
    """One radar.

    Attributes
    ----------
    name, index : of the radar
    plots : its scans, cleaned, in its own frame
    rows : (R,) positions of its rows in the recording
    sigma_r, sigma_th : m, rad; `across_m` is the least error across the ray, m
    origin : (2,) m, east and north of the radar's frame in that of the site
    turned : (2, 2) turns east and north of the radar's frame into those of the site
    period_s : of the antenna
    """

    name: str
    index: int
    plots: Plots
    rows: Ints
    sigma_r: float
    sigma_th: float
    across_m: float
    origin: Floats
    turned: Floats
    period_s: float

    def to_site(self, east: Floats, north: Floats) -> tuple[Floats, Floats]:
        """Places of the radar's frame in that of the site."""
        e, n = self.turn(east, north)
        return e + self.origin[0], n + self.origin[1]

    def turn(self, east: Floats, north: Floats) -> tuple[Floats, Floats]:
        """Directions of the radar's frame in that of the site."""
        (a, b), (c, d) = self.turned
        return a * east + b * north, c * east + d * north


def feeds_of(recording: PolarPlots, parameters: RadarAccuracy) -> tuple[list[Feed], dict[str, Setting], list[Note]]:
    """Resolve every radar of the recording.

    Raises
    ------
    RecordingError
        A radar without accuracy, or azimuths that are no radians.
    """
    settings: dict[str, Setting] = {}
    notes: list[Note] = []
    with np.errstate(invalid="ignore"):
        wild = np.abs(recording.azimuth_rad) > LARGEST_AZIMUTH_RAD
    if wild.any():
        raise RecordingError(
            f"{int(wild.any(axis=1).sum())} azimuths are larger than a full turn.",
            pointer="/recording_id",
            remedy="They are probably in another unit than was said: read the recording again with their unit.",
            code="azimuth_unit",
        )
    out = []
    for i, name in enumerate(recording.radars):
        rows = np.flatnonzero(recording.radar == i)
        out.append(_feed(recording, parameters, i, name, rows, settings, notes))
    return out, settings, notes


def _feed(
    recording: PolarPlots, p: RadarAccuracy, index: int, name: str, rows: Ints, settings: dict[str, Setting],
    notes: list[Note],
) -> Feed:  # fmt: skip
    radar = _radar(recording.site, name, len(recording.radars))
    sigma_r, sigma_th, across = _accuracy(recording, rows, p, radar, name, settings)
    own, origin, turned = _own_frame(recording, rows, radar, notes)
    own = _with_turns(own, rows, p, radar, settings)
    plots = plots_of(own, rows)
    for code, words in enumerate(FATES):
        count = int((plots.fate == code).sum())
        if count and code not in (TAKEN, NOT_MEASURED):
            notes.append(Note("plots_left_out", f"Plots not used: {words}.", count))
    period = p.period_s if p.period_s is not None else (radar.period_s if radar is not None else None)
    if period is None:
        period = plots.period_s
        settings.setdefault("period_s", Setting(round(period, 6), "recording"))
    return Feed(name, index, plots, rows, sigma_r, sigma_th, across, origin, turned, float(period))


def _radar(site: Site | None, name: str, count: int) -> Radar | None:
    """Return the radar of the site by its name; a single one needs none."""
    if site is None:
        return None
    by_name = {r.name: r for r in site.radars}
    if name in by_name:
        return by_name[name]
    return site.radars[0] if count == 1 and len(site.radars) == 1 else None


def _accuracy(
    recording: PolarPlots, rows: Ints, p: RadarAccuracy, radar: Radar | None, name: str, settings: dict[str, Setting]
) -> tuple[float, float, float]:
    """Errors along the ray in m, of the azimuth in rad, and the least across the ray in m."""
    names = ("sigma_range_m", "sigma_azimuth_deg", "sigma_east_m", "sigma_north_m")
    used: dict[str, float | None] = {
        n: getattr(p, n) if getattr(p, n) is not None else getattr(radar, n, None) for n in names
    }
    flat = np.isfinite(recording.east_m[rows]).any() and not np.isfinite(recording.range_m[rows]).any()
    east, north = used["sigma_east_m"], used["sigma_north_m"]
    if flat and east is not None and north is not None:
        mean = float(np.hypot(east, north) / np.sqrt(2))
        _say(settings, p, used, ("sigma_east_m", "sigma_north_m"))
        # A circle: the same across the ray as along it, at any range.
        return mean, 1e-9, mean
    along, azimuth = used["sigma_range_m"], used["sigma_azimuth_deg"]
    if along is None or azimuth is None:
        lacks = "sigma_range_m" if along is None else "sigma_azimuth_deg"
        raise RecordingError(
            f"The radar {name!r} has no {lacks}." if name else f"The recording's radar has no {lacks}.",
            pointer=f"/{lacks}",
            remedy="Give it in the site, or as a parameter; for plots in east and north their two errors do.",
            code="accuracy_missing",
        )
    _say(settings, p, used, ("sigma_range_m", "sigma_azimuth_deg"))
    return along, float(np.radians(azimuth)), p.least_across_m


def _say(settings: dict[str, Setting], p: RadarAccuracy, used: dict[str, float | None], names: tuple[str, ...]) -> None:
    for n in names:
        settings[n] = Setting(used[n], "run" if getattr(p, n) is not None else "site")


def _own_frame(
    recording: PolarPlots, rows: Ints, radar: Radar | None, notes: list[Note]
) -> tuple[PolarPlots, Floats, Floats]:
    """The recording with ground ranges and azimuths from one place, and how that lies in the site's frame."""
    range_m, azimuth = recording.range_m, recording.azimuth_rad
    flat = np.isfinite(recording.east_m) & np.isfinite(recording.north_m) & ~np.isfinite(range_m)
    range_m = np.where(flat, np.hypot(recording.east_m, recording.north_m), range_m)
    azimuth = np.where(flat, np.arctan2(recording.east_m, recording.north_m), azimuth)
    if radar is None or radar.range_kind != "ground":
        # A range is along the line of sight unless the site says otherwise.
        up = 0.0 if radar is None else (radar.height_m if radar.is_geodetic else radar.up_m) or 0.0
        with np.errstate(invalid="ignore"):
            ground, _ = ground_from_slant(range_m, recording.altitude_m, up)
        known = ~flat & np.isfinite(recording.altitude_m)
        below = int((known[rows] & np.isfinite(range_m[rows]) & ~np.isfinite(ground[rows])).any(axis=1).sum())
        if below:
            notes.append(Note("range_below_altitude", "Plots not used: the range is less than the altitude.", below))
        unknown = int((~known & ~flat & np.isfinite(range_m))[rows].any(axis=1).sum())
        if unknown and radar is not None and radar.range_kind == "slant":
            notes.append(
                Note("height_unknown", "Slant ranges without an altitude are taken for ground ranges.", unknown)
            )
        # What has no ground range is then an azimuth without a range, which is counted as no number.
        range_m = np.where(known, ground, range_m)
    origin, turned = np.zeros(2), np.eye(2)
    moving = np.isfinite(recording.radar_east_m) & np.isfinite(recording.radar_north_m)
    if rows.size and moving[rows].any():
        place = np.stack([recording.radar_east_m, recording.radar_north_m])
        origin = place[:, rows[np.flatnonzero(moving[rows])[0]]]
        shift = np.where(moving, place - origin[:, None], 0.0)[:, :, None]
        east = range_m * np.sin(azimuth) + shift[0]
        north = range_m * np.cos(azimuth) + shift[1]
        range_m, azimuth = np.hypot(east, north), np.arctan2(east, north)
    elif radar is not None:
        origin, turned = _in_site(recording.site, radar)
    none = np.full(range_m.shape, np.nan)
    return replace(recording, range_m=range_m, azimuth_rad=azimuth, east_m=none, north_m=none), origin, turned


def _in_site(site: Site | None, radar: Radar) -> tuple[Floats, Floats]:
    """Place and turn of a radar's own frame in the frame of the site."""
    assert site is not None
    place = site.radar_positions()[[r.name for r in site.radars].index(radar.name)][:2]
    origin = site.frame_origin()
    if origin is None or not radar.is_geodetic:
        return place, np.eye(2)
    # North is another direction at another longitude: a step east and a step north say how.
    step = 1000.0
    columns = []
    for east, north in ((step, 0.0), (0.0, step)):
        there = pymap3d.enu2geodetic(east, north, 0.0, radar.latitude_deg, radar.longitude_deg, radar.height_m or 0.0)
        enu = pymap3d.geodetic2enu(*there, origin.latitude_deg, origin.longitude_deg, origin.height_m)
        columns.append((np.array(enu[:2], float) - place) / step)
    return place, np.stack(columns, axis=1)


def _with_turns(
    recording: PolarPlots, rows: Ints, p: RadarAccuracy, radar: Radar | None, settings: dict[str, Setting]
) -> PolarPlots:
    """Give plots of a steadily turning antenna the number of their turn, where they have none."""
    scan = recording.scan[rows]
    if not rows.size or (scan >= 0).any() or recording.range_m.shape[1] != 1:
        return recording
    azimuth = recording.azimuth_rad[rows, 0]
    known = np.flatnonzero(np.isfinite(azimuth))
    time = recording.time_s[rows][known]
    _, counts = np.unique(time, return_counts=True)
    if not time.size or counts[counts > 1].sum() > SHARED_INSTANT * time.size:
        return recording
    period = p.period_s or (radar.period_s if radar is not None else None) or turning_period(time, azimuth[known])
    if period is None or turning_period(time, azimuth[known]) is None:
        return recording
    settings["period_s"] = Setting(round(period, 6), "recording")
    numbers = recording.scan.copy()
    numbers[rows[known]] = turns_of(time, azimuth[known], period)
    return replace(recording, scan=numbers)
