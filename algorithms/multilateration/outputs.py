"""The arrays that the multilateration algorithms give, declared once: OUTPUTS by every one, more by the filters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.altitudes import SOURCES
from algorithms.multilateration.emitters import DECISIONS
from algorithms.multilateration.lanes import REASONS, STATUS
from algorithms.multilateration.separated import LIFE_WORDS
from algorithms.result import Output, Result
from algorithms.toolbox.tracks import life_cycle

OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("target", ("mark",), "", "index of the target"),
    Output("time_s", ("mark", "trial"), "s", "instant of the estimate (emission; article: gate)"),
    Output(
        "state",
        ("mark", "component", "trial"),
        "m, m/s, m/s2",
        "x vx ax y vy ay z vz az in the local frame; NaN where there is no estimate",
    ),
    Output(
        "covariance",
        ("mark", "triangle", "trial"),
        "products of the state's units",
        "lower triangle of the state's covariance row by row (45 elements), or of the position's alone (6): of "
        "one-mark solutions, and of filters over more than 100,000 marks",
    ),
    Output("track", ("mark", "trial"), "", "number of the track, 0 = none"),
    Output("status", ("mark", "trial"), "", "what became of the mark", STATUS),
    Output("reason", ("mark", "trial"), "", "why", REASONS),
    Output("nis", ("mark", "trial"), "1", "normalised innovation squared, before any scaling"),
    Output("dof", ("mark", "trial"), "1", "degrees of freedom of nis"),
    Output("used", ("mark", "station", "trial"), "", "whether the reception entered the estimate"),
    Output("altitude_used", ("mark", "trial"), "", "whether the altitude entered the estimate"),
    Output("residual_m", ("mark", "station", "trial"), "m", "range residual after the estimate, about its mean"),
)

FILTER_OUTPUTS = (
    *OUTPUTS,
    Output(
        "start_error_m",
        ("mark", "trial"),
        "m",
        "claimed horizontal error of the best start from several marks, while it is not accepted",
    ),
    Output("altitude_source", ("mark", "trial"), "", "where the mark's altitude comes from", SOURCES),
    Output("altitude_given_m", ("mark", "trial"), "m", "the altitude, decoded or standing in for one; NaN = none"),
    Output("altitude_sigma_m", ("mark", "trial"), "m", "its standard deviation"),
    Output("emitter", ("mark",), "", "whose the mark is, where emitters were told apart; -1 = nobody's"),
    Output("emitter_decision", ("mark",), "", "what was decided about that", DECISIONS),
    Output("emitter_distance", ("mark",), "1", "squared distance to the nearest emitter"),
    Output("emitter_threshold", ("mark",), "1", "up to which it may be that emitter's"),
    Output("emitter_rival", ("mark",), "", "the emitter that claimed it too; -1 = none"),
    Output("event_track", ("event",), "", "number of a track by which emitters are told apart"),
    Output("event_emitter", ("event",), "", "the emitter that it is of; -1 = none"),
    Output("event_time_s", ("event",), "s", "instant"),
    Output("event_state", ("event",), "", "where its life went", life_cycle.STATES),
    Output("event_reason", ("event",), "", "why", LIFE_WORDS),
)

MODELS_OUTPUTS = (
    *FILTER_OUTPUTS,
    Output("mode_probability", ("mark", "model", "trial"), "probability", "of straight flight and of manoeuvre"),
    Output("altitude_bias_m", ("mark", "trial"), "m", "decoded altitude less geometric height, as estimated"),
    Output("altitude_bias_sd_m", ("mark", "trial"), "m", "its standard deviation"),
)

# Where the elements of the position stand in the lower triangle of a covariance of nine components.
_IN_STATE = [0, 6, 9, 21, 24, 27]


def position_covariance(result: Result) -> NDArray[np.float64]:
    """(mark, 6, trial) m2: lower triangle east; north-east, north; up-east, up-north, up."""
    return position_part(result.arrays["covariance"])


def position_part(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """(M, 45 or 6, L) packed covariances of states or positions -> (M, 6, L) those of the positions."""
    return covariance if covariance.shape[1] == len(_IN_STATE) else covariance[:, _IN_STATE]
