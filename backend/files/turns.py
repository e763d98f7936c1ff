"""Scans: which turn of its antenna a plot belongs to.

Three ways, each per radar, numbering from 1:

* **marks**: a radar says when its antenna looked north (or into a sector). Between two marks the antenna turns
  evenly, which gives the angle turned at any time; the number of the turn is the whole number by which that angle
  and the plot's azimuth differ. So a plot just east of north belongs to the new turn even where its time was rounded
  to before the mark.
* **azimuth**: without marks the period is found from the plots themselves. Where f is the frequency of the antenna,
  azimuth - 2 pi f t is the same for all of them, so f is where the periodogram |sum exp i(azimuth - 2 pi f t)| peaks.
  From plot to plot the turned angle then grows by the difference of the azimuths, and by the whole turns that make it
  the nearest to f times the time between them. A new turn begins at north.
* **period**: equal slices of time, from the first plot on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints, PolarPlots
from backend.files.report import Findings, some

Cut = Literal["marks", "azimuth", "period"]
_TURN = 2 * np.pi
# Periods of antennas, s: from harbour radars to early warning.
_SHORTEST_S, _LONGEST_S = 0.8, 40.0
_SAMPLE_S, _SAMPLE_PLOTS = 240.0, 3000
_FEWEST = 12
# Mean resultant length of azimuth - 2 pi f t: 1 for an even turn, near 0 for no turn at all.
_TURNS_EVENLY = 0.7


@dataclass(frozen=True)
class TurnMarks:
    """When a radar's antenna looked where.

    Attributes
    ----------
    radar : (K,) int, index into `radars`
    time_s : (K,) float, on the clock of the plots
    azimuth_rad : (K,) float
    period_s : radar -> its period, where it says so
    """

    radars: tuple[str, ...]
    radar: Ints
    time_s: Floats
    azimuth_rad: Floats
    period_s: dict[str, float]


def marked_turns(time_s: Floats, azimuth_rad: Floats, mark_s: Floats, mark_rad: Floats, period_s: float) -> Ints:
    """Number of the turn of each plot, from marks of one radar in order of time; the first whole turn is 1."""
    fraction = mark_rad / _TURN
    steps = np.diff(mark_s)
    moved = np.mod(np.diff(fraction), 1.0)
    # Marks may be missing: whole turns that the period says are in between.
    moved += np.maximum(np.round(steps / period_s - moved), 0)
    turned = fraction[0] + np.concatenate([[0.0], np.cumsum(moved)])
    angle = np.interp(time_s, mark_s, turned)
    angle += np.where(time_s < mark_s[0], (time_s - mark_s[0]) / period_s, 0.0)
    angle += np.where(time_s > mark_s[-1], (time_s - mark_s[-1]) / period_s, 0.0)
    return np.asarray(np.round(angle - np.mod(azimuth_rad / _TURN, 1.0)), np.int64)


def mark_period(mark_s: Floats, mark_rad: Floats) -> float:
    """Period told by marks: the time from one mark to the next of the same azimuth; NaN where none repeats.

    Marks may be missing, so a gap is a whole number of turns: how many, the lower quartile of the gaps tells.
    """
    # The azimuths are those of sectors, so equal ones are equal to the bit.
    gaps = [np.diff(mark_s[mark_rad == a]) for a in np.unique(mark_rad)]
    joined = np.concatenate(gaps)
    joined = joined[joined > 0]
    if not joined.size:
        return np.nan
    rough = np.quantile(joined, 0.25, method="lower")
    return float(np.median(joined / np.maximum(np.round(joined / rough), 1.0)))


def antenna_frequency(time_s: Floats, azimuth_rad: Floats) -> tuple[float, float]:
    """Turns per second (negative: counter-clockwise) and how evenly the antenna turns (0 to 1), from plots alone."""
    few = time_s <= time_s[0] + _SAMPLE_S
    time, azimuth = time_s[few][:_SAMPLE_PLOTS], azimuth_rad[few][:_SAMPLE_PLOTS]
    time = time - time[0]
    span = max(float(time[-1]), 1.0)
    positive = np.arange(1 / _LONGEST_S, 1 / _SHORTEST_S, 0.2 / span)
    tried = np.concatenate([positive, -positive])
    best, length = 0.0, -1.0
    for _ in range(3):
        heights = np.array([abs(np.exp(1j * (azimuth - _TURN * f * time)).mean()) for f in tried])
        best, length = float(tried[heights.argmax()]), float(heights.max())
        step = float(np.ptp(tried) / (len(tried) - 1)) if len(tried) == 41 else 0.2 / span
        tried = best + np.linspace(-step, step, 41)
    return best, length


def followed_turns(time_s: Floats, azimuth_rad: Floats, frequency: float) -> Ints:
    """Number of the turn of each plot, in order of time, by following the azimuth."""
    turned = np.sign(frequency) * azimuth_rad / _TURN
    step = np.mod(np.diff(turned), 1.0)
    step += np.round(abs(frequency) * np.diff(time_s) - step)
    angle = np.mod(turned[0], 1.0) + np.concatenate([[0.0], np.cumsum(step)])
    # Rounding must not lift a plot over north that stands exactly there.
    return np.asarray(np.floor(angle + 1e-9), np.int64)


def with_turns(
    plots: PolarPlots, cut: Cut | None, period_s: float | None, marks: TurnMarks | None, findings: Findings
) -> PolarPlots:
    """Number the scans of plots in order of time.

    Without `cut`, marks are used where there are any, and else (where the source has marks for some radars, or is one
    of which they could be expected) the azimuth. A radar whose turns cannot be told keeps what its plots say.

    Raises InputError where the period is needed and nobody tells it.
    """
    scan = plots.scan.copy()
    failed: list[str] = []
    for radar in np.unique(plots.radar).tolist():
        mine = np.flatnonzero(plots.radar == radar)
        turns = _turns(plots, mine, plots.radars[radar], cut, period_s, marks, findings)
        if turns is None:
            failed.append(plots.radars[radar] or "radar")
        else:
            scan[mine] = turns - turns.min() + 1
    if failed:
        findings.warn(
            "scans_unknown",
            f"Nothing tells the turns of the antenna of {some(failed)}; its plots have no scan numbers. The option "
            "scan_cut = period cuts equal slices of time.",
            len(failed),
        )
    return replace(plots, scan=scan)


def _turns(
    plots: PolarPlots,
    mine: Ints,
    name: str,
    cut: Cut | None,
    period_s: float | None,
    marks: TurnMarks | None,
    findings: Findings,
) -> Ints | None:
    """Turns of the plots of one radar, and the warning that says how they were told; None where they cannot be."""
    time_s, azimuth = plots.time_s[mine], _azimuth(plots, mine)
    told = period_s or (None if marks is None else marks.period_s.get(name)) or _period_of_site(plots, name)
    word = name or "radar"
    if cut == "period":
        if told is None:
            raise InputError(
                "Scans are to be cut by period, and nothing tells it.",
                pointer="/options/scan_period_s",
                remedy="Give scan_period_s, the seconds of one turn.",
                code="period_unknown",
            )
        findings.warn("scans_cut", f"Scans of {word} are equal slices of {told:.6g} s.")
        return np.asarray(np.floor((time_s - time_s[0]) / told), np.int64)
    own = None if marks is None or cut == "azimuth" else _own_marks(marks, name)
    if own is not None:
        mark_s, mark_rad = own
        period = mark_period(mark_s, mark_rad)
        period = told if told is not None and not np.isfinite(period) else period
        if np.isfinite(period):
            count = len(mark_s)
            findings.warn("scans_cut", f"Scans of {word} were told by {count} marks; period {period:.4g} s.")
            return marked_turns(time_s, np.nan_to_num(azimuth), mark_s, mark_rad, float(period))
    if cut == "marks" or len(mine) < _FEWEST or not np.isfinite(azimuth).all():
        return None
    frequency, evenly = (1 / told, 1.0) if told else antenna_frequency(time_s, azimuth)
    if evenly < _TURNS_EVENLY:
        return None
    findings.warn("scans_cut", f"Scans of {word} begin at north; period {abs(1 / frequency):.4g} s, told by the plots.")
    return followed_turns(time_s, azimuth, frequency)


def _own_marks(marks: TurnMarks, name: str) -> tuple[Floats, Floats] | None:
    """Times and azimuths of one radar's marks in order of time; of several at one instant the first."""
    if name not in marks.radars:
        return None
    own = np.flatnonzero(marks.radar == marks.radars.index(name))
    own = own[np.argsort(marks.time_s[own], kind="stable")]
    own = own[np.diff(marks.time_s[own], prepend=-np.inf) > 0]
    return (marks.time_s[own], marks.azimuth_rad[own]) if own.size else None


def _azimuth(plots: PolarPlots, mine: Ints) -> Floats:
    azimuth, east, north = (v[mine, 0] for v in (plots.azimuth_rad, plots.east_m, plots.north_m))
    return np.asarray(np.mod(np.where(np.isfinite(azimuth), azimuth, np.arctan2(east, north)), _TURN))


def _period_of_site(plots: PolarPlots, name: str) -> float | None:
    radars: Sequence[object] = () if plots.site is None else plots.site.radars
    return next((r.period_s for r in radars if r.name == name), None)  # type: ignore[attr-defined]
