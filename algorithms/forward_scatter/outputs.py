"""The arrays that the forward-scatter algorithms give, declared once."""

from __future__ import annotations

from algorithms.result import Output

(
    NO_VALUES,
    INSUFFICIENT,
    NO_LINE,
    NO_CROSSING,
    INVALID,
    NOT_CONVERGED,
    AT_BOUND,
    FALLBACK,
    EXTRAPOLATED,
    CROSSED,
    FITTED,
    HELD,
) = range(12)

STATUS = (
    "no_values",
    "insufficient_data",
    "no_line",
    "no_crossing",
    "invalid",
    "not_converged",
    "at_bound",
    "fallback",
    "extrapolated",
    "crossed",
    "fitted",
    "held",
)
# Statuses that come with a position.
ANSWERED = (FALLBACK, EXTRAPOLATED, CROSSED, FITTED, HELD)

OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("target", ("mark",), "", "index of the target"),
    Output("time_s", ("mark", "trial"), "s", "instant of the estimate"),
    Output(
        "state",
        ("mark", "axis", "trial"),
        "m, m/s, m/s2",
        "x vx ax y vy ay z vz az in the local frame; NaN where there is no estimate",
    ),
    Output(
        "covariance",
        ("mark", "component", "component", "trial"),
        "m2",
        "of the position east, north, up, of a fit along the curved ridge of its likelihood; the altitude is known",
    ),
    Output("track", ("mark", "trial"), "", "number of the pass, 0 = none"),
    Output("status", ("mark", "trial"), "", "what became of the row", STATUS),
    Output(
        "theta",
        ("mark", "unknown", "trial"),
        "s, m, m/s, m/s, m/s2",
        "crossing time, crossing distance from the receivers, velocity across and along the base line, acceleration",
    ),
    Output(
        "theta_covariance",
        ("mark", "component", "component", "trial"),
        "squares of the units of theta",
        "predicted by linearisation; 0 where an unknown is not estimated",
    ),
    Output(
        "distance_interval_m",
        ("mark", "end", "trial"),
        "m",
        "95 % interval of the crossing distance: 1.96 standard deviations, of a fit where its likelihood falls by as "
        "much",
    ),
    Output("chi2", ("mark", "trial"), "1", "sum of squared residuals over the error's square, of all data so far"),
    Output("dof", ("mark", "trial"), "", "degrees of freedom of chi2"),
    Output("used", ("mark", "channel", "trial"), "", "whether the Doppler went into the estimate"),
    Output("residual_hz", ("mark", "channel", "trial"), "Hz", "Doppler minus that of the pass's last estimate"),
)

LINE_OUTPUTS = (
    *OUTPUTS,
    Output(
        "line",
        ("mark", "receiver", "number", "trial"),
        "s, Hz, Hz/s, s2, 1, s",
        "window's line: mean time, value there, slope, sum of squared times, values, zero",
    ),
    Output("crossing_s", ("mark", "receiver", "trial"), "s", "crossing time of each receiver as it was used"),
    Output("frozen", ("mark", "receiver", "trial"), "", "whether that crossing time is kept"),
    Output("omega_rad_s", ("mark", "trial"), "rad/s", "angular velocity seen from the receivers"),
    Output("difference_hz", ("mark", "trial"), "Hz", "Doppler of the lower minus that of the upper receiver"),
)
