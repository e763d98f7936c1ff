"""The most likely matching of all plots of two radars, with the probability of every pair.

Each pair has the likelihood that both plots are one target at an unknown place; each plot may also be a false one, or
that of a target which the other radar missed. The most likely set of pairs solves a linear assignment; probabilities
are sums over all sets, exact up to `exact_plots` plots a group, beyond with a stated error. A pair is accepted where it
is probable enough, else left undecided.

References
----------
barshalom2001, section 1.4; crouse2016; murty1968; specification 5 and 6.

Differences from the paper
--------------------------
The paper decides pair by pair. Here all pairs are decided together, with probabilities in place of a threshold.
"""

from __future__ import annotations

import numpy as np

from algorithms.identification.compare import Decide, compare, judged, pair_decisions, partners_both_ways
from algorithms.identification.filled import Decided
from algorithms.identification.matching import matched, scores_of
from algorithms.identification.measures import measure
from algorithms.identification.outputs import ACCEPTED, ALONE, PLOT_OUTPUTS
from algorithms.identification.pairs import PairStatistics
from algorithms.identification.parameters import DetectionParameters, ExactParameters, PairParameters
from algorithms.identification.scoring import score_looks
from algorithms.identification.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext


class AssignmentParameters(ExactParameters, DetectionParameters, PairParameters):
    """What the assignment knows."""


def _decide(parameters: AssignmentParameters) -> Decide:
    def decide(found: PairStatistics) -> Decided:
        n, m, lanes = found.statistic.shape
        score = scores_of(found.cost, found.statistic, parameters)
        done = matched(score, found.statistic, parameters, parameters.exact_plots)
        rows = partners_both_ways(done.partner, m)
        taken = np.maximum(rows, 0)
        if n:
            theirs = np.where(rows >= 0, np.take_along_axis(done.decision, taken, axis=0), ALONE)
            ties = (rows >= 0) & np.take_along_axis(done.ties, taken, axis=0)
        else:
            theirs, ties = np.full((m, lanes), ALONE), np.zeros((m, lanes), np.bool_)
        accepted = np.where(done.decision == ACCEPTED, done.partner, -1)
        doubtful = (done.partner >= 0) & (done.decision != ACCEPTED)
        return Decided(
            partner=(accepted, np.where(theirs == ACCEPTED, rows, -1)),
            decision=(done.decision, theirs),
            pair_decision=pair_decisions((n, m, lanes), done.partner, done.decision),
            pairs=done.pairs,
            best=(done.partner, rows),
            several=(doubtful, (rows >= 0) & (theirs != ACCEPTED)),
            ties=(done.ties, ties),
            ranked_groups=done.ranked_groups,
            truncation=done.truncation,
            split=done.split,
        )

    return decide


def run(recording: PolarPlots, parameters: AssignmentParameters, context: RunContext) -> Result:
    """Match the plots of two radars, look by look."""
    return compare(recording, parameters, context, _decide(parameters))


def score(recording: PolarPlots, parameters: AssignmentParameters, context: RunContext) -> Scores:
    """Count correct, wrong and undecided plots."""
    return score_looks(recording, judged(recording, parameters, context, _decide(parameters), matched=True))


ALGORITHM = Algorithm(
    name="assignment",
    title="Most likely matching",
    summary="All plots of two radars are matched together; every pair has a probability, missed detections and false "
    "plots are allowed for, and a pair that is not probable enough stays undecided.",
    family="identification",
    recommended=True,
    takes=("polar_plots",),
    parameters=AssignmentParameters,
    outputs=PLOT_OUTPUTS,
    charts=(
        "plan",
        "pairs_plan",
        "pair_closeup",
        "association_matrix",
        "pair_statistic",
        "trials_decisions",
        "trials_probability",
        "trials_base",
        "trials_sweep",
        "trials_nonlinearity",
        "trials_placement",
        "trials_statistic",
        "trials_quantiles",
        "trials_roc",
        "trials_tradeoff",
        "trials_reliability",
    ),
    references=(
        Reference("prosov2008", "table 1"),
        Reference("barshalom2001", "section 1.4"),
        Reference("crouse2016"),
        Reference("murty1968"),
    ),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
