"""The arrays that the multiple-model algorithms give, declared once."""

from __future__ import annotations

from algorithms.multiple_model.states import REASONS, STATUS
from algorithms.result import Output

OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("target", ("mark",), "", "index of the target"),
    Output("time_s", ("mark",), "s", "instant of the estimate"),
    Output(
        "state",
        ("mark", "component", "trial"),
        "m, m/s, m/s2",
        "x vx ax y vy ay z vz az in the local frame; predicted where the row did not enter, NaN where there is none",
    ),
    Output("covariance", ("mark", "component", "component", "trial"), "squares of the state's units"),
    Output("track", ("mark", "trial"), "", "number of the track, 0 = none"),
    Output("status", ("mark", "trial"), "", "what became of the row", STATUS),
    Output("reason", ("mark", "trial"), "", "why", REASONS),
    Output("nis", ("mark", "trial"), "1", "normalised innovation squared of the most probable model"),
    Output("dof", ("mark",), "1", "degrees of freedom of nis"),
    Output("mode_probability", ("mark", "model", "trial"), "probability", "of each model after the row"),
    Output("model_state", ("mark", "model", "component", "trial"), "m, m/s, m/s2", "estimate of each model"),
    Output("log_likelihood", ("mark", "model", "trial"), "1", "logarithm of the row's density under each model"),
    Output("distance", ("mark", "trial"), "1", "normalised distance of the row from the prediction, with a gate"),
    Output("gate", ("mark", "trial"), "1", "largest distance that is taken, with a gate"),
    Output("sigma_model", ("model",), "m/s2", "noise of each model"),
    Output("kind_model", ("model",), "", "kind of each model", ("cv", "ca", "ct", "gv", "gd")),
)
