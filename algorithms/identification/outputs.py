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

# Why a plot was not accepted: as the table `decisions` says it.
(
    NO_REASON,
    IMPROBABLE,
    NOBODY_NEAR,
    SEVERAL_NEAR,
    TIED,
    ONE_LINE,
    NO_NUMBER,
    LEFT_OUT,
    NOT_SEEN,
    SHORT_TRACK,
    SAME_TIME,
) = range(11)
REASONS = (
    "",
    "the most likely partner is not probable enough",
    "no partner inside the gate, or none more likely than to be alone",
    "several partners inside the gate",
    "two partners are exactly as probable",
    "both radars look along one line there, so that plots of the same range cannot be told apart",
    "range or azimuth cannot be used",
    "a plot of a radar that was not compared",
    "the radar did not detect the target",
    "its track has fewer than two plots",
    "its track has another plot at the same time",
)
REASON_OF_DECISION = (
    NO_REASON,
    IMPROBABLE,
    NOBODY_NEAR,
    SEVERAL_NEAR,
    NO_REASON,
    NO_NUMBER,
    LEFT_OUT,
    NOT_SEEN,
)
"""What a decision means where nothing more is known."""

PLOT_OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("frame", ("mark",), "", "number of the look that the plot belongs to"),
    Output("decision", ("mark", "trial"), "", "what became of the plot", DECISIONS),
    Output("reason", ("mark", "trial"), "", "why the plot was not accepted", REASONS),
    Output("group", ("mark", "trial"), "", "plots with the same number are one target; 0 = none"),
    Output("probability", ("mark", "trial"), "1", "of the most likely partner, or of having none; NaN = not computed"),
    Output("statistic", ("mark", "trial"), "1", "squared normalised distance to the most likely partner"),
    Output("position_m", ("mark", "axis", "trial"), "m", "east and north of the plot by itself"),
    Output("fused_m", ("mark", "axis", "trial"), "m", "east and north from all plots of the target; NaN = none"),
    Output(
        "instant_s",
        ("mark",),
        "s",
        "when the target is at the fused position",
    ),
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
