"""The paper's test of pairs against a threshold.

A plot of one radar belongs to the only plot of the other that lies inside its gate, S <= -2 ln alpha. None or several
inside leave it undecided; the two kinds are told apart.

References
----------
prosov2008, eqs. (1)-(4), the test after them, table 1; specification 4.

Differences from the paper
--------------------------
Any number of plots, not two; `conversion` offers the known corrections beside the paper's two, and the exact
likelihood; S has two degrees of freedom, the dimension of a point.
"""

from __future__ import annotations

import numpy as np

from algorithms.identification.compare import Decide, compare, judged, pair_decisions, partners_both_ways
from algorithms.identification.filled import Decided
from algorithms.identification.measures import measure
from algorithms.identification.outputs import ACCEPTED, ALONE, PLOT_OUTPUTS, SEVERAL, UNDECIDED
from algorithms.identification.pairs import PairStatistics
from algorithms.identification.parameters import PairParameters
from algorithms.identification.scoring import score_looks
from algorithms.identification.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.association.only_partner import SEVERAL as SEVERAL_INSIDE
from algorithms.toolbox.association.only_partner import only_partners


class PairwiseTestParameters(PairParameters):
    """What the test knows."""


def _decide(parameters: PairParameters) -> Decide:
    threshold = gate_threshold(parameters.alpha, 2)
    anchor = 0 if parameters.reading == "A" else 1

    def decide(found: PairStatistics) -> Decided:
        n, m, lanes = found.statistic.shape
        turned = np.swapaxes(found.statistic, 0, 1)
        sides = (found.statistic, turned)
        own = only_partners(sides[anchor], threshold)
        partner = np.where(own >= 0, own, -1)
        others = partners_both_ways(partner, (n, m)[1 - anchor])
        seen = only_partners(sides[1 - anchor], threshold)
        word = np.where(own >= 0, ACCEPTED, np.where(own == SEVERAL_INSIDE, SEVERAL, ALONE))
        reply = np.where(
            others >= 0, ACCEPTED, np.where(seen == SEVERAL_INSIDE, SEVERAL, np.where(seen >= 0, UNDECIDED, ALONE))
        )
        several = (own == SEVERAL_INSIDE, seen == SEVERAL_INSIDE)
        pairs = pair_decisions(sides[anchor].shape, partner, word)
        inside = sides[anchor] <= threshold
        pairs = np.where(inside & (own == SEVERAL_INSIDE)[:, None], SEVERAL, pairs)
        best = tuple(_nearest(side) for side in sides)
        none = tuple(np.zeros((k, lanes), np.bool_) for k in (n, m))
        if anchor == 1:
            return Decided(
                (others, partner), (reply, word), np.swapaxes(pairs, 0, 1), None, (best[0], best[1]),
                (several[1], several[0]), (none[0], none[1]),
            )  # fmt: skip
        return Decided((partner, others), (word, reply), pairs, None, (best[0], best[1]), several, (none[0], none[1]))

    return decide


def _nearest(statistic: np.ndarray) -> np.ndarray:
    """(n, L) nearest partner, -1 = none."""
    if not statistic.shape[1]:
        return np.full((statistic.shape[0], statistic.shape[2]), -1)
    known = np.where(np.isfinite(statistic), statistic, np.inf)
    return np.where(np.isfinite(known.min(axis=1)), known.argmin(axis=1), -1)


def run(recording: PolarPlots, parameters: PairwiseTestParameters, context: RunContext) -> Result:
    """Test all pairs of two radars, look by look."""
    return compare(recording, parameters, context, _decide(parameters))


def score(recording: PolarPlots, parameters: PairwiseTestParameters, context: RunContext) -> Scores:
    """Count correct, wrong and undecided plots."""
    return score_looks(recording, judged(recording, parameters, context, _decide(parameters), matched=False))


ALGORITHM = Algorithm(
    name="pairwise_test",
    title="Pairwise test",
    summary="The paper's test: a plot belongs to the only plot of the other radar inside its chi-square gate; none or "
    "several leave it undecided.",
    family="identification",
    takes=("polar_plots",),
    parameters=PairwiseTestParameters,
    outputs=PLOT_OUTPUTS,
    charts=(
        "plan",
        "pairs_plan",
        "pair_closeup",
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
    ),
    references=(Reference("prosov2008", "table 1"), Reference("lerro1993"), Reference("longbin1998")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
