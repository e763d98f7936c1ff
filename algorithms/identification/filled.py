"""The arrays of a result, filled look by look: what became of each plot, and of each pair."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.outputs import (
    ALONE,
    MISSING,
    NO_REASON,
    ONE_LINE,
    REASON_OF_DECISION,
    REJECTED,
    SEVERAL,
    TIED,
    UNDECIDED,
    UNUSABLE,
)
from algorithms.identification.pairs import PairStatistics, Side, fused, on_one_line, points_of
from algorithms.identification.parameters import PairParameters
from algorithms.identification.plots import Plots
from algorithms.recording import PolarPlots
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DOF = 2
# A run on more pairs than this keeps those alone that could belong together in some trial.
KEPT_PAIRS = 200_000
WIDE_TAIL = 1e-6


@dataclass(frozen=True)
class Decided:
    """What an algorithm made of one look: n plots of the first radar, m of the second, L trials.

    Attributes
    ----------
    partner : (n, L) and (m, L) for the two sides, accepted partner or -1
    decision : (n, L) and (m, L)
    pair_decision : (n, m, L)
    pairs : (n, m, L) probabilities, or None
    best : (n, L) and (m, L) most likely partner whatever was decided, -1 = none
    several : (n, L) and (m, L) undecided because of several
    ties : (n, L) and (m, L)
    ranked_groups, truncation : groups too large for the sum over all matchings, and the largest error of that
    split : whether the look was too large as a whole
    """

    partner: tuple[Ints, Ints]
    decision: tuple[Ints, Ints]
    pair_decision: Ints
    pairs: Floats | None
    best: tuple[Ints, Ints]
    several: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    ties: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    ranked_groups: int = 0
    truncation: float = 0.0
    split: bool = False


@dataclass(frozen=True)
class Pairs:
    """Pairs of plots of one look: (P, 2) rows, (P,) look, (P, L) statistic, probability and decision."""

    row: Ints
    frame: Ints
    statistic: Floats
    probability: Floats
    decision: Ints


def listed_pairs(
    recording: PolarPlots,
    look: int,
    rows: tuple[Ints, Ints],
    statistic: Floats,
    probability: Floats | None,
    decision: Ints,
    total: int,
) -> Pairs:
    """Return all pairs of n with m plots, or, of more than `KEPT_PAIRS` in the run, those that could be one target."""
    n, m, lanes = statistic.shape
    i, j = np.indices((n, m)).reshape(2, -1)
    statistic = statistic.reshape(n * m, lanes)
    probability = np.full((n * m, lanes), np.nan) if probability is None else probability.reshape(n * m, lanes)
    decision = decision.reshape(n * m, lanes)
    if total > KEPT_PAIRS:
        near = statistic <= gate_threshold(WIDE_TAIL, DOF)
        keep = np.flatnonzero((near | (decision != REJECTED)).any(axis=1))
        i, j, statistic, probability, decision = i[keep], j[keep], statistic[keep], probability[keep], decision[keep]
    numbers = np.stack([recording.row[rows[0][i]], recording.row[rows[1][j]]], axis=1)
    return Pairs(numbers.reshape(-1, 2), np.full(i.size, look), statistic, probability, decision)


def joined_pairs(pairs: list[Pairs], lanes: int) -> dict[str, NDArray[np.generic]]:
    """Put the pairs of all looks under each other, as the outputs are declared."""

    def of(values: list[NDArray[np.generic]], width: int, kind: type) -> NDArray[np.generic]:
        return np.concatenate(values) if values else np.empty((0, width), kind)

    return {
        "pair_row": of([p.row for p in pairs], 2, np.int64),
        "pair_frame": np.concatenate([p.frame for p in pairs]) if pairs else np.empty(0, np.int64),
        "pair_statistic": of([p.statistic for p in pairs], lanes, np.float64),
        "pair_probability": of([p.probability for p in pairs], lanes, np.float64),
        "pair_decision": of([p.decision for p in pairs], lanes, np.int64),
    }


class Filled:
    """Arrays of the marks, filled look by look."""

    def __init__(self, plots: Plots) -> None:
        marks, lanes = plots.range_m.shape
        self.decision = np.where(plots.usable, ALONE, MISSING)
        self.decision[[bool(word) for word in plots.bad]] = UNUSABLE
        self.reason = np.full((marks, lanes), NO_REASON)
        self.group = np.zeros((marks, lanes), np.int64)
        self.probability = np.full((marks, lanes), np.nan)
        self.alone = np.full((marks, lanes), np.nan)
        self.statistic = np.full((marks, lanes), np.nan)
        self.position = np.full((marks, 2, lanes), np.nan)
        self.fused = np.full((marks, 2, lanes), np.nan)
        self.covariance = np.full((marks, 3, lanes), np.nan)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """As the outputs are declared."""
        usual = np.array(REASON_OF_DECISION)[self.decision]
        return {
            "decision": self.decision,
            "reason": np.where(self.reason == NO_REASON, usual, self.reason),
            "group": self.group,
            "probability": self.probability,
            "alone_probability": self.alone,
            "statistic": self.statistic,
            "position_m": self.position,
            "fused_m": self.fused,
            "fused_covariance_m2": self.covariance,
        }

    def take(
        self,
        recording: PolarPlots,
        parameters: PairParameters,
        rows: tuple[Ints, Ints],
        sides: tuple[Side, Side],
        found: PairStatistics,
        decided: Decided,
    ) -> None:
        """Put one look in. Plots that are one target get the number of the row of their anchor."""
        anchor = 0 if parameters.reading == "A" else 1
        for s in (0, 1):
            own, partner, best = rows[s], decided.partner[s], decided.best[s]
            points = points_of(sides[s]._replace(ahead=None), parameters.conversion)
            self.position[own] = np.stack([points.x, points.y], axis=1)
            here = np.isfinite(sides[s].range_m)
            self.decision[own] = np.where(here, decided.decision[s], self.decision[own])
            doubtful = np.isin(self.decision[own], (UNDECIDED, SEVERAL))
            self.reason[own] = np.where(doubtful & on_one_line(sides[s], sides[1 - s], best), ONE_LINE, NO_REASON)
            self.reason[own] = np.where(doubtful & decided.ties[s], TIED, self.reason[own])
            statistic = found.statistic if s == 0 else np.swapaxes(found.statistic, 0, 1)
            self.statistic[own] = _of_partner(statistic, best)
            if decided.pairs is not None:
                pairs = decided.pairs if s == 0 else np.swapaxes(decided.pairs, 0, 1)
                alone = np.where(here, np.clip(1 - pairs.sum(axis=1), 0.0, 1.0), np.nan)
                self.alone[own] = alone
                self.probability[own] = np.where(best >= 0, _of_partner(pairs, best), alone)
            place, covariance = fused(sides[s], sides[1 - s], parameters.conversion, partner)
            self.fused[own], self.covariance[own] = place, covariance
            number = recording.row[own][:, None]
            theirs = recording.row[rows[1 - s]]
            if s == anchor:
                group = np.where(partner >= 0, number, 0)
            elif theirs.size:
                group = np.where(partner >= 0, theirs[np.maximum(partner, 0)], 0)
            else:
                group = np.zeros(partner.shape, np.int64)
            self.group[own] = group


def _of_partner(values: Floats, partner: Ints) -> Floats:
    """(n, L) from (n, m, L): the value of each row's partner, NaN where it has none."""
    if not values.shape[1]:
        return np.full(partner.shape, np.nan)
    taken = np.take_along_axis(values, np.maximum(partner, 0)[:, None], axis=1)[:, 0]
    out: Floats = np.where(partner >= 0, taken, np.nan)
    return out
