"""The arrays that the multilateration algorithms give, declared once: OUTPUTS by every one, more by the filters."""

from __future__ import annotations

from algorithms.multilateration.lanes import REASONS, STATUS
from algorithms.result import Output

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
    Output("covariance", ("mark", "component", "component", "trial"), "squares of the state's units"),
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
)
