"""Signs that plots which name one radar are of two: two rotations, two cadences of scans, or targets that jump.

Nothing is changed: the user is told, and how the radars are told apart.

* **rotations**: of one antenna azimuth - 2 pi f t is the same for all plots. Where half of them have one value, the
  rest another (of another f, or of the same), and both sorts come in turn, two antennas turn.
* **cadences**: where plots carry the instant of their scan, the same of t modulo the period.
* **jumps**: plots of one target that is named (address or target) between places that nothing flies between so fast.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.recording import CLUTTER, Floats, Ints, PolarPlots
from backend.files.report import Findings

_TURN = 2 * np.pi
# Periods of antennas, s, and how much of a recording is looked at.
_SHORTEST_S, _LONGEST_S = 0.8, 40.0
_SAMPLE_S, _SAMPLE_PLOTS = 240.0, 600
_FEWEST = 24
# Half a window of phases, rad, and the share of plots in it that makes one antenna of them.
_HALF_WINDOW, _ONE, _BOTH = 0.25, 0.9, 0.2
# Of plots that come in turn at random so many neighbours are of different sorts: 2 p q; half of that is asked for.
_IN_TURN = 0.5
# Instants that several plots share: scans rather than a turning antenna.
_SHARED = 0.5
# Nothing flies so fast, m/s, over so many metres; of so many steps of a target and of so many targets.
_TOO_FAST_MPS, _FAR_M = 5_000.0, 5_000.0
_STEPS, _MOST_JUMPS, _MOST_JUMPING = 4, 0.2, 0.5


class _Two(NamedTuple):
    """Periods of two sorts of plots in s, and which plots are of the second."""

    first_s: float
    second_s: float
    second: Ints


def look_at_radars(plots: PolarPlots, findings: Findings) -> None:
    """Warn where plots of one name seem to be of two radars."""
    for radar in range(len(plots.radars)):
        _look_at_one(plots, np.flatnonzero(plots.radar == radar), findings)


def _look_at_one(plots: PolarPlots, mine: Ints, findings: Findings) -> None:
    if mine.size < _FEWEST:
        return
    time = plots.time_s[mine]
    east, north = _place(plots, mine)
    early = np.flatnonzero(time <= time[0] + _SAMPLE_S)
    instants, count = np.unique(time[early], return_counts=True)
    scans = count[count > 1].sum() > _SHARED * early.size
    two = None
    # What moves looks about from another place each time; its azimuths are no rotation.
    if scans or not np.isfinite(plots.radar_east_m[mine]).any():
        few = early[:_SAMPLE_PLOTS]
        few = few[np.isfinite(east[few] + north[few])]
        azimuth = np.mod(np.arctan2(east[few], north[few]), _TURN)
        two = _two_phases(instants, np.zeros(instants.size)) if scans else _two_phases(time[few], azimuth)
    if two is not None and scans:
        findings.warn(
            "radars_mixed",
            f"Scans come in two cadences, every {two.first_s:.4g} s and every {two.second_s:.4g} s. If the plots are "
            "of two radars, their tracks would be mixed: read the recording again with a column radar, or upload "
            "each radar's file by itself and join the recordings.",
        )
    elif two is not None:
        findings.warn(
            "radars_mixed",
            f"Two antennas seem to turn, in {two.first_s:.4g} s and in {two.second_s:.4g} s. If the plots are of two "
            "radars, their tracks would be mixed: read the recording again with a column radar, or upload each "
            "radar's file by itself and join the recordings.",
        )
    else:
        jumping, known = _jumping(plots, mine, east, north)
        if known and jumping > _MOST_JUMPING * known:
            findings.warn(
                "radars_mixed",
                f"Of {known} named targets {jumping} jump, faster than 5,000 m/s from plot to plot. If the plots are "
                "of two radars, their tracks would be mixed: read the recording again with a column radar, or upload "
                "each radar's file by itself and join the recordings.",
                jumping,
            )


def _place(plots: PolarPlots, mine: Ints) -> tuple[Floats, Floats]:
    """East and north of each plot, m, from range and azimuth where these were measured."""
    rho, theta = plots.range_m[mine, 0], plots.azimuth_rad[mine, 0]
    polar = np.isfinite(rho) & np.isfinite(theta)
    east = np.where(polar, rho * np.sin(theta), plots.east_m[mine, 0])
    north = np.where(polar, rho * np.cos(theta), plots.north_m[mine, 0])
    return east, north


def _two_phases(time: Floats, azimuth: Floats) -> _Two | None:
    """Periods of two sorts of plots, both steady and in turn; None where all are of one sort, or of none."""
    if time.size < _FEWEST:
        return None
    shortest = _SHORTEST_S
    if not azimuth.any():
        # Instants of scans: one cadence is that of the usual step, and every part of it would fit as well.
        usual = float(np.median(np.diff(time)))
        if _in_window(time, azimuth, 1 / usual)[1] > _ONE:
            return None
        shortest = max(0.8 * usual, _SHORTEST_S)
    first, inside = _steadiest(time, azimuth, shortest)
    share = inside.mean()
    rest = np.flatnonzero(~inside)
    if share > _ONE or min(share, 1 - share) < _BOTH or rest.size < _FEWEST // 2:
        return None
    second, of_rest = _steadiest(time[rest], azimuth[rest], shortest)
    if of_rest.mean() < _ONE:
        return None
    in_turn = float(np.mean(inside[1:] != inside[:-1]))
    return _Two(1 / first, 1 / second, rest) if in_turn > _IN_TURN * 2 * share * (1 - share) else None


def _steadiest(time: Floats, azimuth: Floats, shortest_s: float) -> tuple[float, np.ndarray]:
    """Turns per second at which most plots have one phase, and which of them have it."""
    span = max(float(time[-1] - time[0]), 1.0)
    tried = np.arange(1 / _LONGEST_S, 1 / shortest_s, 0.1 / span)
    shares = np.array([_in_window(time, azimuth, f)[1] for f in tried])
    # The slowest of those that are as good: of a cadence every multiple fits.
    best = float(tried[np.flatnonzero(shares >= shares.max() - 0.02)[0]])
    near = best + np.linspace(-0.1, 0.1, 41) / span
    shares = np.array([_in_window(time, azimuth, f)[1] for f in near])
    best = float(np.median(near[shares == shares.max()]))
    return best, _in_window(time, azimuth, best)[0]


def _in_window(time: Floats, azimuth: Floats, frequency: float) -> tuple[np.ndarray, float]:
    """Which plots lie in the fullest window of phases, and their share."""
    phase = np.mod(azimuth - _TURN * frequency * (time - time[0]), _TURN)
    order = np.sort(phase)
    wide = np.concatenate([order, order + _TURN])
    count = np.searchsorted(wide, order + 2 * _HALF_WINDOW, "right") - np.arange(order.size)
    begin = order[int(count.argmax())]
    inside = np.mod(phase - begin, _TURN) <= 2 * _HALF_WINDOW
    return inside, float(inside.mean())


def _jumping(plots: PolarPlots, mine: Ints, east: Floats, north: Floats) -> tuple[int, int]:
    """How many named targets jump to and fro, and how many have enough plots to tell."""
    address = plots.address[mine]
    real = np.array([target not in ("", CLUTTER) for target in plots.targets], bool)
    named = real[plots.target[mine]] if real.size else np.zeros(mine.size, bool)
    name = np.where(address >= 0, address, np.where(named, -2 - plots.target[mine], -1))
    known = np.flatnonzero((name != -1) & np.isfinite(east + north))
    order = known[np.lexsort((plots.time_s[mine][known], name[known]))]
    same = np.diff(name[order]) == 0
    way = np.hypot(np.diff(east[order]), np.diff(north[order]))
    took = np.diff(plots.time_s[mine][order])
    fast = (way > _FAR_M) & (way > _TOO_FAST_MPS * np.maximum(took, 1e-3))
    _, which = np.unique(name[order], return_inverse=True)
    steps = np.bincount(which[1:], weights=same)
    jumps = np.bincount(which[1:], weights=same & fast, minlength=steps.size)
    enough = steps >= _STEPS
    return int((jumps[enough] > _MOST_JUMPS * steps[enough]).sum()), int(enough.sum())
