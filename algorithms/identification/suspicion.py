"""When nothing fits: which mistake in the data would make the radars agree?

The sign is a median squared distance to the nearest partner beyond all reason. Each known mistake is then undone in
turn (an azimuth counted from east, degrees that were radians, plots that are counted from the other radar's place,
looks that are one or more apart), and the one is named that makes the radars agree. Where none does, one radar may be
turned, displaced or late by more than any gate holds: turns, shifts and delays are tried one after another, and the
best is where the least squares of the registration start from.

References
----------
specification 10.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.plots import Look, Plots
from algorithms.identification.registration_pairs import moved, placed, statistics
from algorithms.result import Note

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SUSPICIOUS_MEDIAN = 50.0
# The median that makes a suggestion, and how many times smaller than before it must be.
PLAUSIBLE_MEDIAN = 20.0
IMPROVED = 5.0
# A known mistake is named unless an error of some size explains so many times more.
RATHER_KNOWN = 3.0
MOST_LOOKS = 40
FEWEST_PLOTS = 4
LOOKS_APART = (-3, -2, -1, 1, 2, 3)
# What is tried of turns, shifts and delays, on so many plots of the first radar.
SEARCHED_PLOTS = 120
LARGEST_TURN_DEG = 45.0
MOST_TRIED = 250
LARGEST_DELAY_LOOKS = 3.0


@dataclass(frozen=True)
class Start:
    """An error of one radar that makes the radars agree roughly, told as a `Hypothesis` tells it."""

    radar: int
    kind: int
    value: Floats
    median: float = 0.0


@dataclass(frozen=True)
class Suspicion:
    """What is said, and where to start looking for the exact error: one of the two, or neither."""

    notes: list[Note]
    start: Start | None = None


@dataclass(frozen=True)
class Moving:
    """(M, 2) m/s of the second radar's plots, NaN where not known, worked out on demand; and the time between looks."""

    velocity: Callable[[], Floats]
    period_s: float


@dataclass(frozen=True)
class _Idea:
    note: Note
    plots: Plots
    apart: int = 0


def suspected(plots: Plots, first: int, second: int, moving: Moving) -> Suspicion | None:
    """Return what explains radars that disagree beyond all reason, None where they do not."""
    before = median_statistic(plots, first, second)
    if not before > SUSPICIOUS_MEDIAN:
        return None

    def explains(median: float) -> bool:
        return median < PLAUSIBLE_MEDIAN and median * IMPROVED < before

    notes = [
        Note(
            "radars_disagree",
            f"The nearest partners of the two radars are a squared distance of {before:.0f} apart (median); about 1.4 "
            "is usual.",
        )
    ]
    ideas = [(median_statistic(idea.plots, first, second, idea.apart), idea) for idea in _ideas(plots, first, second)]
    median, idea = min(ideas, key=lambda pair: pair[0])
    if explains(median) and median < RATHER_KNOWN:
        return Suspicion([*notes, idea.note])
    start = min(starts(plots, first, second, moving), key=lambda s: s.median, default=None)
    if explains(median) and (start is None or median < RATHER_KNOWN * start.median):
        return Suspicion([*notes, idea.note])
    if start is not None and explains(start.median):
        return Suspicion(notes, start)
    notes.append(
        Note(
            "disagreement_unexplained",
            "No known mistake explains it: look at the site, the accuracies, the units and the clocks.",
        )
    )
    return Suspicion(notes)


def median_statistic(plots: Plots, first: int, second: int, apart: int = 0) -> float:
    """Median over the plots of the first radar of the squared distance to the nearest plot of the second one."""
    where = placed(plots)
    nearest: list[Floats] = []
    for k in _spread(len(plots.looks), MOST_LOOKS):
        if not 0 <= k + apart < len(plots.looks):
            continue
        rows, others = plots.looks[k].rows[first], plots.looks[k + apart].rows[second]
        if rows.size and others.size:
            known = statistics(where, rows, others).min(axis=1)
            nearest.append(known[np.isfinite(known)])
    values = np.concatenate(nearest) if nearest else np.empty(0)
    return float(np.median(values)) if values.size >= FEWEST_PLOTS else 0.0


def _spread(count: int, wanted: int) -> Ints:
    """So many numbers below `count`, spread over all."""
    numbers: Ints = np.unique(np.linspace(0, max(count - 1, 0), min(count, wanted)).astype(np.int64))
    return numbers


def _ideas(plots: Plots, first: int, second: int) -> Iterator[_Idea]:
    whose = (
        ((first,), f"radar {plots.names[first]}"),
        ((second,), f"radar {plots.names[second]}"),
        ((first, second), "both radars"),
    )
    compass = np.pi / 2 - plots.angle_rad
    for radars, words in whose:
        chosen = np.isin(plots.radar, radars)[:, None]
        yield _Idea(
            Note(
                "suspect_azimuth_convention",
                f"The azimuths of {words} seem to be counted counter-clockwise from east: with 90 degrees less the "
                "azimuth the radars agree.",
            ),
            replace(plots, angle_rad=np.where(chosen, compass, plots.angle_rad)),
        )
        yield _Idea(
            Note(
                "suspect_azimuth_unit",
                f"The azimuths of {words} seem to be radians that were read as degrees: with the unit rad the radars "
                "agree.",
            ),
            replace(plots, angle_rad=np.where(chosen, np.pi / 2 - np.degrees(compass), plots.angle_rad)),
        )
    sites = plots.sites.copy()
    sites[second] = sites[first]
    yield _Idea(
        Note(
            "suspect_translation",
            f"The plots of radars {plots.names[first]} and {plots.names[second]} seem to be counted from one place: "
            "with the same place for both in the site the radars agree.",
        ),
        replace(plots, sites=sites),
    )
    for apart in LOOKS_APART:
        yield _Idea(
            Note(
                "suspect_clock",
                f"The looks of radar {plots.names[second]} seem to be {abs(apart)} too "
                f"{'early' if apart > 0 else 'late'}: shifted by as much the radars agree.",
            ),
            plots,
            apart,
        )


def starts(plots: Plots, first: int, second: int, moving: Moving) -> Iterator[Start]:
    """Give the best turn of either radar, the best shift and the best delay."""
    rows, few = _few_looks(plots, first)
    radars = (first, second)
    still = np.full((rows.size, 2), np.nan)
    for radar in radars:
        step = max(2 * float(np.degrees(plots.sigma_angle[radar])), 2 * LARGEST_TURN_DEG / MOST_TRIED)
        turns = np.arange(-LARGEST_TURN_DEG, LARGEST_TURN_DEG + step, step)
        yield _best(few, radars, radar, 1, turns[:, None], still)
    shifts = _shifts(few, first, second)
    if len(shifts):
        yield _best(few, radars, second, 0, shifts, still)
    velocity = moving.velocity()
    delays = _delays(plots, second, velocity, moving.period_s)
    if delays.size:
        yield _best(few, radars, second, 3, delays[:, None], velocity[rows])


def _few_looks(plots: Plots, first: int) -> tuple[Ints, Plots]:
    """Rows of some looks spread over all, and these looks by themselves."""
    each = [look.rows[first].size for look in plots.looks]
    wanted = int(np.clip(SEARCHED_PLOTS / max(float(np.mean(each)) if each else 1.0, 1.0), 1, MOST_LOOKS))
    chosen = [plots.looks[k] for k in _spread(len(plots.looks), wanted)]
    rows = np.concatenate([r for look in chosen for r in look.rows]) if chosen else np.empty(0, np.int64)
    new = np.full(plots.radar.size, -1)
    new[rows] = np.arange(rows.size)
    looks = tuple(Look(look.number, tuple(new[r] for r in look.rows)) for look in chosen)
    return rows, replace(
        plots,
        range_m=plots.range_m[rows, :1],
        angle_rad=plots.angle_rad[rows, :1],
        shift_m=None if plots.shift_m is None else plots.shift_m[rows],
        ahead=None if plots.ahead is None else plots.ahead[rows],
        usable=plots.usable[rows, :1],
        bad=tuple(plots.bad[i] for i in rows),
        radar=plots.radar[rows],
        frame=plots.frame[rows],
        looks=looks,
    )


def _best(plots: Plots, radars: tuple[int, int], radar: int, kind: int, tried: Floats, velocity: Floats) -> Start:
    medians = [median_statistic(moved(plots, radar, kind, value, velocity), *radars) for value in tried]
    k = int(np.argmin(medians))
    return Start(radar, kind, tried[k], medians[k])


def _shifts(plots: Plots, first: int, second: int) -> Floats:
    """(N, 2) differences of plots of one look: among them those of true pairs."""
    where = placed(plots)
    found = [
        (where.place[look.rows[second]][None] - where.place[look.rows[first]][:, None]).reshape(-1, 2)
        for look in plots.looks
    ]
    shifts = np.concatenate(found) if found else np.empty((0, 2))
    shifts = shifts[np.isfinite(shifts).all(axis=1)]
    return shifts[_spread(len(shifts), MOST_TRIED)]


def _delays(plots: Plots, second: int, velocity: Floats, period_s: float) -> Floats:
    """Delays up to some looks, so close that a target moves by less than the errors between two of them."""
    speed = np.hypot(*velocity[plots.radar == second].T)
    speed = speed[np.isfinite(speed)]
    if speed.size < FEWEST_PLOTS or not period_s > 0:
        return np.empty(0)
    longest = LARGEST_DELAY_LOOKS * period_s
    step = max(2 * float(plots.sigma_range[second]) / max(float(np.median(speed)), 1e-3), 2 * longest / MOST_TRIED)
    return np.arange(-longest, longest + step, step)
