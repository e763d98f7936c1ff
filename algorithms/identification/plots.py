"""From a recording to what a comparison needs: usable plots in the axes of the plane, radars, and looks.

A *look* is a set of plots of all radars that are compared with each other: one scan. Scan numbers tell it where all
plots have one; else a given length; else a pause between the plots.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError, RecordingError
from algorithms.identification.parameters import RadarParameters
from algorithms.recording import PolarPlots
from algorithms.result import Note, Setting
from algorithms.site import Radar
from algorithms.toolbox.frames.polar_conversion import angle_from_compass
from algorithms.toolbox.frames.slant import ground_from_slant

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# Plots within so long of each other are one look where nothing says more.
PAUSE_S = 1.0
# A look that lasts longer without a pause is no look but a radar that turns.
LONGEST_LOOK_S = 5.0
LARGEST_SIGMA_RAD = 0.5
WIDE_SIGMA_RAD = 0.2
SMALLEST_SIGMA_RANGE_M, LARGEST_SIGMA_RANGE_M = 1.0, 10_000.0
# Nearer to its radar than this many range errors a plot's covariance means nothing.
NEAR_SIGMA = 5.0


@dataclass(frozen=True)
class Look:
    """Positions of the rows of each radar at one look."""

    number: int
    rows: tuple[Ints, ...]


@dataclass(frozen=True)
class Plots:
    """Measurements of K radars, M rows, L trials.

    Attributes
    ----------
    range_m, angle_rad : (M, L); the angle counter-clockwise from east; NaN where unusable or not detected
    usable : (M, L)
    bad : (M,) why a row is unusable in every trial, "" = it is not
    radar : (M,) index into `names`
    sites : (K, 2) m
    sigma_range, sigma_angle : (K,) m and rad
    looks : in the order of time
    frame : (M,) number of the look
    shift_m : (M, 2) what is to be added to where each plot is, for what is tried; None = nothing
    ahead : (M, 5) east, north m and xx, yy, xy m2: how far each target goes on from its plot's instant to that of its
        look, and the covariance that this adds; None = all plots of a look have one instant
    """

    range_m: Floats
    angle_rad: Floats
    usable: Bools
    bad: tuple[str, ...]
    radar: Ints
    names: tuple[str, ...]
    sites: Floats
    sigma_range: Floats
    sigma_angle: Floats
    looks: tuple[Look, ...]
    frame: Ints
    settings: dict[str, Setting]
    notes: tuple[Note, ...]
    shift_m: Floats | None = None
    ahead: Floats | None = None

    @property
    def lanes(self) -> int:
        """Number of trials."""
        return int(self.range_m.shape[1])


def plots_of(recording: PolarPlots, parameters: RadarParameters) -> Plots:
    """Resolve radars, accuracies and looks, and set aside what cannot be used.

    Raises
    ------
    RecordingError
        No site, one radar only, a radar without a place or accuracy, a moving radar, or plots that cannot be cut.
    ParameterError
        An accuracy that no radar has.
    """
    radars = _radars(recording)
    notes: list[Note] = []
    settings: dict[str, Setting] = {}
    sigma_range = _accuracies(parameters, radars, "sigma_range_m", settings)
    sigma_angle = np.radians(_accuracies(parameters, radars, "sigma_azimuth_deg", settings))
    _look_at_accuracies(recording.radars, sigma_range, sigma_angle, parameters, notes)
    assert recording.site is not None
    places = {r.name: place for r, place in zip(recording.site.radars, recording.site.radar_positions(), strict=True)}
    sites = np.array([places[name] for name in recording.radars])
    range_m, angle = _polar(recording, radars, sites[:, 2], notes)
    bad = _unusable(range_m, angle)
    usable = np.isfinite(range_m) & np.isfinite(angle) & (range_m > 0)
    near = usable & (range_m < NEAR_SIGMA * sigma_range[recording.radar][:, None])
    if near.any():
        notes.append(
            Note(
                "target_at_radar",
                "A plot nearer to its radar than five range errors has no meaningful covariance.",
                int(near.any(axis=1).sum()),
            )
        )
    frame = _frames(recording, parameters, settings)
    looks = tuple(
        Look(k, tuple(rows[recording.radar[rows] == r] for r in range(len(radars))))
        for k, rows in enumerate(_groups(frame))
    )
    return Plots(
        range_m=np.where(usable, range_m, np.nan),
        angle_rad=np.where(usable, angle, np.nan),
        usable=usable,
        bad=bad,
        radar=recording.radar,
        names=recording.radars,
        sites=np.ascontiguousarray(sites[:, :2]),
        sigma_range=sigma_range,
        sigma_angle=sigma_angle,
        looks=looks,
        frame=frame,
        settings=settings,
        notes=tuple(notes),
    )


def refuse_nothing(plots: Plots) -> None:
    """Refuse a recording of which no plot is left.

    Raises
    ------
    RecordingError
        Every row is unusable; the first reason is given.
    """
    if plots.bad and all(plots.bad):
        raise RecordingError(
            f"No plot can be used: {plots.bad[0]} in the first row, and the others are no better.",
            pointer="/recording_id",
            remedy="Look at the columns of range and azimuth, and at how they were read.",
            code="no_usable_plots",
        )


def _radars(recording: PolarPlots) -> tuple[Radar, ...]:
    if len(recording.radars) < 2:
        raise RecordingError(
            "The recording has plots of one radar only.",
            pointer="/recording_id",
            remedy="Give a recording with a column radar that names two or more radars.",
            code="one_radar",
        )
    site = recording.site
    if site is None or not site.radars:
        raise RecordingError(
            "The recording has no site, so its radars have no positions.",
            pointer="/site",
            remedy="Read the recording again with a site that lists its radars.",
            code="site_missing",
        )
    known = {r.name: r for r in site.radars}
    missing = [name for name in recording.radars if name not in known]
    if missing:
        raise RecordingError(
            f"The site has no radar {missing[0]!r}.",
            pointer="/site/radars",
            remedy="Give the site's radars the names of the recording's column radar.",
            code="site_mismatch",
        )
    if np.isfinite(recording.radar_east_m).any():
        raise RecordingError(
            "The recording has a radar that moves.",
            pointer="/recording_id",
            remedy="Only radars that stand still are compared: give their places in the site.",
            code="moving_radar",
        )
    return tuple(known[name] for name in recording.radars)


def _accuracies(
    parameters: RadarParameters, radars: tuple[Radar, ...], name: str, settings: dict[str, Setting]
) -> Floats:
    given: float | None = getattr(parameters, name)
    if given is not None:
        settings[name] = Setting(given, "run")
        return np.full(len(radars), given)
    own = [getattr(r, name) for r in radars]
    for radar, value in zip(radars, own, strict=True):
        if value is None:
            raise RecordingError(
                f"The radar {radar.name!r} has no {name}.",
                pointer=f"/{name}",
                remedy="Give it in the site, or for all radars as a parameter.",
                code="accuracy_missing",
            )
    settings[name] = Setting(own, "site")
    return np.array(own, float)


def _look_at_accuracies(
    names: tuple[str, ...], sigma_range: Floats, sigma_angle: Floats, parameters: RadarParameters, notes: list[Note]
) -> None:
    for name, sr, sb in zip(names, sigma_range.tolist(), sigma_angle.tolist(), strict=True):
        if sb > LARGEST_SIGMA_RAD:
            raise ParameterError(
                f"The azimuth error of radar {name!r}, {np.degrees(sb):g} degrees, is larger than any radar's: "
                "probably a value in degrees was taken for radians and converted.",
                pointer="/sigma_azimuth_deg",
                remedy="Give it in degrees, 1 for one degree.",
            )
        if sb > WIDE_SIGMA_RAD:
            notes.append(Note("wide_azimuth", f"The azimuth error of radar {name!r} is unusually large."))
        if not SMALLEST_SIGMA_RANGE_M <= sr <= LARGEST_SIGMA_RANGE_M:
            notes.append(
                Note("range_error_unit", f"A range error of {sr:g} m (radar {name!r}) is unusual: check its unit.")
            )


def _polar(recording: PolarPlots, radars: tuple[Radar, ...], up_m: Floats, notes: list[Note]) -> tuple[Floats, Floats]:
    """Ground ranges and angles; Cartesian plots become polar, slant ranges with an altitude ground ranges."""
    range_m, angle = recording.range_m, angle_from_compass(recording.azimuth_rad)
    flat = np.isfinite(recording.east_m) & np.isfinite(recording.north_m) & ~np.isfinite(range_m)
    range_m = np.where(flat, np.hypot(recording.east_m, recording.north_m), range_m)
    angle = np.where(flat, np.arctan2(recording.north_m, recording.east_m), angle)
    slant = np.array([r.range_kind == "slant" for r in radars])[recording.radar][:, None] & ~flat
    known = slant & np.isfinite(recording.altitude_m) & (range_m > 0)
    if known.any():
        ground, _ = ground_from_slant(range_m, recording.altitude_m, up_m[recording.radar][:, None])
        range_m = np.where(known, ground, range_m)
    missing = int((slant & ~known & np.isfinite(range_m)).any(axis=1).sum())
    if missing:
        notes.append(Note("height_unknown", "Slant ranges without an altitude are taken for ground ranges.", missing))
    return range_m, angle


def _unusable(range_m: Floats, angle: Floats) -> tuple[str, ...]:
    """Why a row of an uploaded recording cannot be used; a simulated one without a range was not detected."""
    out = np.full(range_m.shape[0], "", object)
    if range_m.shape[1] == 1:
        out[~np.isfinite(range_m[:, 0]) | ~np.isfinite(angle[:, 0])] = "range or azimuth is no number"
        out[range_m[:, 0] <= 0] = "the range is not positive"
    return tuple(out.tolist())


def _frames(recording: PolarPlots, parameters: RadarParameters, settings: dict[str, Setting]) -> Ints:
    """(M,) number of the look, in the order of time."""
    time = recording.time_s
    if not time.size:
        return np.empty(0, np.int64)
    if parameters.frame_s is not None:
        settings["frame_s"] = Setting(parameters.frame_s, "run")
        number = np.floor((time - time[0]) / parameters.frame_s).astype(np.int64)
    elif (recording.scan >= 0).all():
        settings["frame_s"] = Setting("scan numbers", "recording")
        number = recording.scan
    else:
        settings["frame_s"] = Setting("pauses", "recording")
        number = np.concatenate([[0], np.cumsum(np.diff(time) > PAUSE_S)])
        for k in np.unique(number):
            own = time[number == k]
            if own[-1] - own[0] > LONGEST_LOOK_S:
                raise ParameterError(
                    f"The plots from {own[0]:g} s on follow each other for {own[-1] - own[0]:g} s without a pause, "
                    "and they have no scan numbers, so nothing tells which of them belong to one look.",
                    pointer="/frame_s",
                    remedy="Give the length of a look: the period in which the radars see everything once.",
                )
    return np.unique(number, return_inverse=True)[1].astype(np.int64)


def _groups(frame: Ints) -> list[Ints]:
    order = np.argsort(frame, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(frame[order])) + 1) if frame.size else []
