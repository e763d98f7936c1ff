"""From costs of pairs to a decision: the most likely matching, probabilities of all pairs, and when to say nothing.

References
----------
barshalom2001, section 1.4; crouse2016; murty1968; specification 5.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.outputs import ACCEPTED, ALONE, UNDECIDED
from algorithms.identification.parameters import DetectionParameters
from algorithms.toolbox.association.assignment import most_likely_matching, pair_scores
from algorithms.toolbox.association.exact import EXACT_COLUMNS, exact_probabilities
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.probabilities import association_probabilities

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Pairs outside this gate are impossible where a look is too large for the sum over all matchings.
WIDE_TAIL = 1e-6
# n m 2^m of a look up to which all trials are summed side by side; beyond, trial by trial and group by group.
SIDE_BY_SIDE = 70_000
# Probabilities nearer to each other than this are a tie.
TIE = 1e-12


@dataclass(frozen=True)
class Matched:
    """The most likely matching of n with m plots, and how sure it is.

    Attributes
    ----------
    partner : (n, L) column of each row, -1 = none
    pairs : (n, m, L) probability of each pair
    decision : (n, L) what becomes of each row
    ties : (n, L) whether another partner is exactly as probable
    ranked_groups, truncation : of `association_probabilities`
    split : whether there were too many plots for one sum over all matchings
    """

    partner: Ints
    pairs: Floats
    decision: Ints
    ties: NDArray[np.bool_]
    ranked_groups: int = 0
    truncation: float = 0.0
    split: bool = False


def scores_of(cost: Floats, statistic: Floats, p: DetectionParameters) -> Floats:
    """(n, m, L) log-likelihood ratios of the pairs; -inf where a plot is missing.

    The density of targets is that of the plots that are there, less the false ones, unless it is given. With a
    detection probability of 1 and no clutter a lone plot is next to impossible, so that as many pairs as can be are
    made: the complete case.
    """
    here = np.isfinite(statistic)
    if p.target_count is not None:
        count: Floats = np.full(cost.shape[-1], p.target_count)
    else:
        seen = (here.any(axis=1).sum(axis=0) + here.any(axis=0).sum(axis=0)) / 2
        count = np.maximum((seen - p.clutter_per_radar) / p.detection_probability, 1.0)
    clutter = p.clutter_per_radar / p.region_area_m2
    score = pair_scores(
        cost,
        detection_probability=(p.detection_probability, p.detection_probability),
        target_density=count / p.region_area_m2,
        clutter_density=(clutter, clutter),
    )
    return np.where(here, score, -np.inf)


def matched(score: Floats, statistic: Floats, p: DetectionParameters, exact_columns: int = EXACT_COLUMNS) -> Matched:
    """Match, give probabilities and decide; `exact_columns` plots on the shorter side are summed exactly."""
    n, m, lanes = score.shape
    small = min(n, m) <= exact_columns and n * m * 2 ** min(n, m) <= SIDE_BY_SIDE
    ranked, truncation = 0, 0.0
    if small:
        pairs, _ = exact_probabilities(score)
    else:
        pairs = np.zeros((n, m, lanes))
        gated = np.where(statistic <= gate_threshold(WIDE_TAIL, 2), score, -np.inf)
        for lane in range(lanes):
            found = association_probabilities(gated[:, :, lane], exact_columns=exact_columns)
            pairs[:, :, lane] = found.pairs
            ranked += found.ranked_groups
            truncation = max(truncation, found.truncation)
    partner = np.full((n, lanes), -1)
    for lane in range(lanes):
        partner[:, lane] = most_likely_matching(score[:, :, lane])
    if not m:
        return Matched(partner, pairs, np.full((n, lanes), ALONE), np.zeros((n, lanes), np.bool_))
    own = np.where(partner >= 0, np.take_along_axis(pairs, np.maximum(partner, 0)[:, None], axis=1)[:, 0], -1.0)
    # Far outside all gates every probability is 0: that is no tie.
    ties = (own > TIE) & ((np.abs(pairs - own[:, None]) < TIE).sum(axis=1) > 1)
    sure = (own >= p.p_min) & ~ties if p.decision == "posterior" else np.ones_like(ties)
    decision = np.where(partner < 0, ALONE, np.where(sure, ACCEPTED, UNDECIDED))
    return Matched(partner, pairs, decision, ties, ranked, truncation, min(n, m) > exact_columns)
