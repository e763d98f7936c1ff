"""The arrays that the algorithms on plots give, and what became of a plot or a pair, in words."""

from __future__ import annotations

from algorithms.result import Output

# What became of a plot or of a pair.
ACCEPTED, UNDECIDED, ALONE, SEVERAL, REJECTED, UNUSABLE, NOT_COMPARED, MISSING = range(8)
DECISIONS = (
    "accepted",
    "undecided",
    "alone",
    "several",
    "rejected",
    "unusable",
    "not_compared",
    "not_detected",
)

PLOT_OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("frame", ("mark",), "", "number of the look that the plot belongs to"),
    Output("decision", ("mark", "trial"), "", "what became of the plot", DECISIONS),
    Output("group", ("mark", "trial"), "", "plots with the same number are one target; 0 = none"),
    Output("probability", ("mark", "trial"), "1", "of the most likely partner, or of having none; NaN = not computed"),
    Output("statistic", ("mark", "trial"), "1", "squared normalised distance to the most likely partner"),
    Output("position_m", ("mark", "axis", "trial"), "m", "east and north of the plot by itself"),
    Output("fused_m", ("mark", "axis", "trial"), "m", "east and north from all plots of the target; NaN = none"),
    Output("fused_covariance_m2", ("mark", "element", "trial"), "m2", "east-east, north-north, east-north"),
    Output("pair_row", ("pair", "side"), "", "rows of the two plots"),
    Output("pair_frame", ("pair",), "", "look"),
    Output("pair_statistic", ("pair", "trial"), "1", "squared normalised distance; NaN = one of the two is missing"),
    Output("pair_probability", ("pair", "trial"), "1", "that the two are one target; NaN = not computed"),
    Output("pair_decision", ("pair", "trial"), "", "what became of the pair", DECISIONS),
    Output("alone_probability", ("mark", "trial"), "1", "that the plot has no partner; NaN = not computed"),
    Output("radar", ("mark",), "", "number of the radar, from 0"),
    Output("threshold", ("one",), "1", "of the statistic"),
    Output(
        "registration",
        ("hypothesis", "number"),
        "",
        "kind, radar, against which, two values, two standard deviations, statistic, tail; see table registration",
    ),
)
