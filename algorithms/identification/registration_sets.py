"""Which of three radars and more disagrees with the others: its plots against the mean of the others in their sets."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.diagnosis import Diagnosis, diagnosed, suspected_among
from algorithms.identification.plots import Plots
from algorithms.identification.registration import OTHERS, Accepted, hypotheses_of, notes_of
from algorithms.identification.registration_pairs import MAX_SPEED_MPS, inverse, placed, target_numbers, times
from algorithms.identification.velocities import MOST_POSITIONS, joined_tracks, velocities
from algorithms.recording import PolarPlots

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class AcceptedSets(NamedTuple):
    """Accepted sets of plots of the first trial: rows (T, K), -1 = none; fused places (T, 2), covariances (T, 3)."""

    rows: Ints
    place: Floats
    covariance: Floats


def joined_sets(sets: list[AcceptedSets], radars: int) -> AcceptedSets:
    """Sets of all looks in one."""
    if not sets:
        return AcceptedSets(np.empty((0, radars), np.int64), np.empty((0, 2)), np.empty((0, 3)))
    return AcceptedSets(*(np.concatenate([one[k] for one in sets]) for k in range(3)))


def diagnosed_sets(recording: PolarPlots, plots: Plots, sets: AcceptedSets) -> Diagnosis:
    """Judge all radars; hypotheses of the one that disagrees most come first."""
    radars = len(plots.names)
    if radars == 2:
        return diagnosed(recording, plots, 0, 1, sets.rows)
    found = suspected_among(recording, plots)
    if found is not None:
        return found
    velocity = _velocities(recording, plots, sets)
    each = [hypotheses_of(_against_others(recording, plots, sets, k, velocity), OTHERS, k) for k in range(radars)]
    each.sort(key=lambda hypotheses: -max((h.statistic for h in hypotheses), default=0.0))
    hypotheses = [h for hypotheses in each for h in hypotheses]
    return hypotheses, notes_of(each[0], plots.names)


def _first_rows(sets: AcceptedSets) -> Ints:
    """(T,) row of the first plot of each set."""
    column = (sets.rows >= 0).argmax(axis=1)
    rows: Ints = sets.rows[np.arange(len(sets.rows)), column]
    return rows


def _velocities(recording: PolarPlots, plots: Plots, sets: AcceptedSets) -> Floats:
    """(T, 2) m/s of the sets' targets."""
    if not len(sets.rows) or len(sets.rows) > MOST_POSITIONS:
        return np.full((len(sets.rows), 2), np.nan)
    first = _first_rows(sets)
    frame = plots.frame[first]
    order = np.argsort(frame, kind="stable")
    looks = np.split(order, np.flatnonzero(np.diff(frame[order])) + 1)
    numbers = np.where(sets.rows >= 0, target_numbers(recording)[sets.rows], -2)
    own = target_numbers(recording)[first]
    named = np.where(((numbers == own[:, None]) | (numbers == -2)).all(axis=1), own, -1)
    time_s = recording.time_s[first]
    tracks = joined_tracks(looks, named, time_s, sets.place, sets.covariance, MAX_SPEED_MPS)
    return velocities(tracks, time_s, sets.place, sets.covariance)


def _against_others(recording: PolarPlots, plots: Plots, sets: AcceptedSets, radar: int, velocity: Floats) -> Accepted:
    """Plots of one radar against the mean of the others in their sets."""
    here = np.flatnonzero(sets.rows[:, radar] >= 0)
    if not here.size:
        return Accepted.nothing()
    rows = sets.rows[here, radar]
    where = placed(plots)
    z, own = where.place[rows], inverse(where.covariance[rows])
    whole = inverse(sets.covariance[here])
    covariance = inverse(whole - own)
    mean = times(covariance, times(whole, sets.place[here]) - times(own, z))
    others = np.where(np.arange(sets.rows.shape[1]) == radar, -1, sets.rows[here])
    seen = others >= 0
    theirs = (np.where(seen, recording.time_s[others], 0.0)).sum(axis=1) / seen.sum(axis=1)
    speed = velocity[here]
    ahead = np.where(np.isfinite(speed), speed * (theirs - recording.time_s[rows])[:, None], 0.0)
    none = np.full(z.shape, np.nan)
    return Accepted(mean - z - ahead, covariance + where.covariance[rows], none, z - plots.sites[radar], speed)
