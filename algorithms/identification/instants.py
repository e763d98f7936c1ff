"""Plots of one look brought to one instant: radars that turn by themselves never see a target at the same time.

Each radar's plots are joined to tracks, and each plot goes on along the straight line through it and its neighbours to
the middle of its look. A position z with covariance R that goes on by v dt has the covariance
R + dt (K + K') + dt^2 V, with V that of the velocity and K that of position and velocity: the line goes through this
very plot. A plot whose track is no line stays where it is; its R grows by dt^2 times the mean square of the velocities
that are known, along each axis.

References
----------
barshalom2001, section 3.4 (weighted least squares); specification 10, "different times".

Differences from the paper
--------------------------
The paper's radars look at the same instant.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.plots import Plots
from algorithms.identification.registration_pairs import lines_of_plots
from algorithms.recording import PolarPlots
from algorithms.result import Note

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Together:
    """A recording whose plots are compared, and what was done to bring them to the instants of their looks.

    Attributes
    ----------
    plots : with `ahead` where plots were moved
    instant_s : (M,) when the plots are compared: the middle of the look, or their own time where nothing was moved
    at_instants : recording and plots as the agreement of the radars is judged: moved plots, at the time they have now
    notes : how far apart plots were, and how many stayed where they are
    """

    plots: Plots
    instant_s: Floats
    at_instants: tuple[PolarPlots, Plots]
    notes: list[Note]


def brought_together(recording: PolarPlots, plots: Plots, radars: tuple[int, ...], *, extrapolate: bool) -> Together:
    """Move the plots of some radars to the middle of their looks."""
    apart = _largest_delay(recording, plots, radars)
    if not apart > 0:
        return Together(plots, recording.time_s, (recording, plots), [])
    if not extrapolate or plots.lanes > 1:
        note = Note(
            "not_simultaneous",
            f"Plots of one look are up to {apart:.3g} s apart, and a moving target goes on meanwhile: 1 s at 250 m/s "
            "shifts a pair by 250 m. Nothing was moved; extrapolate does it.",
        )
        return Together(plots, recording.time_s, (recording, plots), [note])
    ahead = np.full((len(recording), 5), np.nan)
    instant = _instants(recording, plots, radars)
    squares: list[Floats] = []
    for radar in radars:
        lines = lines_of_plots(recording, plots, radar)
        own = np.isfinite(lines.velocity[:, 0])
        squares.append(np.square(lines.velocity[own]).ravel())
        dt = (instant - recording.time_s)[own]
        cross = lines.with_place[own]
        spread = (
            dt[:, None, None] * (cross + np.swapaxes(cross, 1, 2)) + (dt * dt)[:, None, None] * lines.covariance[own]
        )
        ahead[own, :2] = lines.velocity[own] * dt[:, None]
        ahead[own, 2:] = np.stack([spread[:, 0, 0], spread[:, 1, 1], spread[:, 0, 1]], axis=1)
    known = np.isfinite(ahead[:, 0])
    compared = np.isin(plots.radar, radars) & plots.usable[:, 0]
    left = compared & ~known & (instant != recording.time_s)
    staying = int(left.sum())
    ahead = np.nan_to_num(ahead)
    flown = np.concatenate(squares)
    if flown.size:
        # Nobody knows where these are by then: they may fly as the others do, in any direction.
        spread = np.square(instant - recording.time_s)[left] * flown.mean()
        ahead[left, 2] = ahead[left, 3] = spread
    notes = []
    if (compared & known).any():
        notes.append(
            Note(
                "moved_to_one_instant",
                f"Plots of one look are up to {apart:.3g} s apart: each was moved to the middle of its look by the "
                "velocity that the track of its own radar tells.",
                int((compared & known).sum()),
            )
        )
    if staying:
        notes.append(
            Note(
                "not_simultaneous",
                f"Plots of one look are up to {apart:.3g} s apart, and a moving target goes on meanwhile: 1 s at "
                "250 m/s shifts a pair by 250 m. Plots whose track tells no velocity stay where they are, as uncertain "
                "as the others' speeds make them: a track takes four looks at least, and a straight flight.",
                staying,
            )
        )
    moved = replace(plots, ahead=ahead)
    now = replace(recording, time_s=np.where(known, instant, recording.time_s))
    return Together(moved, instant, (now, replace(plots, shift_m=ahead[:, :2])), notes)


def _instants(recording: PolarPlots, plots: Plots, radars: tuple[int, ...]) -> Floats:
    """(M,) middle of each plot's look."""
    instant = recording.time_s.copy()
    for look in plots.looks:
        rows = _compared(plots, look.rows, radars)
        if rows.size:
            time = recording.time_s[rows]
            instant[rows] = (time.min() + time.max()) / 2
    return instant


def _compared(plots: Plots, each: tuple[Ints, ...], radars: tuple[int, ...]) -> Ints:
    rows = np.concatenate([each[r] for r in radars])
    found: Ints = rows[plots.usable[rows].any(axis=1)]
    return found


def _largest_delay(recording: PolarPlots, plots: Plots, radars: tuple[int, ...]) -> float:
    """Longest time between plots of two radars at one look, s."""
    largest = 0.0
    for look in plots.looks:
        each = [recording.time_s[look.rows[r]] for r in radars if look.rows[r].size]
        for k, a in enumerate(each):
            for b in each[:k]:
                largest = max(largest, float(max(a.max() - b.min(), b.max() - a.min())))
    return largest


def truth_at(recording: PolarPlots, instant_s: Floats) -> Floats:
    """(M, 2) east and north of each plot's target at another instant than the plot's own; NaN where nobody knows.

    It goes on from the plot by its true velocity; without one along the straight line between the true places of the
    plots of a named target.
    """
    later = (instant_s - recording.time_s)[:, None]
    place = recording.truth_m[:, :2] + np.where(later == 0, 0.0, later * recording.truth_velocity_mps[:, :2])
    for number, name in enumerate(recording.targets):
        rows = np.flatnonzero((recording.target == number) & np.isfinite(recording.truth_m[:, :2]).all(axis=1))
        wanted = rows[np.isnan(place[rows]).any(axis=1)]
        if name and wanted.size:
            time, first = np.unique(recording.time_s[rows], return_index=True)
            for axis in range(2):
                along = recording.truth_m[rows[first], axis]
                place[wanted, axis] = np.interp(instant_s[wanted], time, along, left=np.nan, right=np.nan)
    return place
