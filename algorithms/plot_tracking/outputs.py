"""The arrays that the trackers give, and what became of a plot, in words."""

from __future__ import annotations

from algorithms.result import Output
from algorithms.toolbox.tracks.life_cycle import REASONS, STATES

NOT_DETECTED, LEFT_OUT, STARTED, SECOND, ACQUIRED, UPDATED, MIDDLE, MANOEUVRE, SHARED = range(9)
DECISIONS = (
    "not_detected",
    "left_out",
    "started",
    "second_plot",
    "acquired",
    "updated",
    "updated_middle",
    "manoeuvre",
    "shared",
)
"""What became of a plot."""
NO_GATE, START_GATE, ACQUISITION_GATE, TRACKING_GATE = range(4)
GATES = ("none", "start", "acquisition", "tracking")
GATE_OF_STAGE = {1: START_GATE, 2: ACQUISITION_GATE, 3: TRACKING_GATE}
"""In which gate of its track a plot lay."""

MODELS = ("constant_velocity", "coordinated_turn")
"""Motion models whose probabilities a tracker may give."""
MOTION = ("acceleration_mps2", "normal_acceleration_mps2", "sigma_speed_mps", "sigma_course_deg", "q", "window_plots")
"""What a tracker says of a motion beside place and velocity; NaN where it has no such thing."""

TRACK_OUTPUTS = (
    Output("row", ("mark",), "", "row number in the source"),
    Output("decision", ("mark", "trial"), "", "what became of the plot", DECISIONS),
    Output("gate", ("mark", "trial"), "", "in which gate it lay", GATES),
    Output("track", ("mark", "trial"), "", "number of the track that took it, 0 = none"),
    Output("distance", ("mark", "trial"), "1", "from the middle of the gate, NaN = none"),
    Output("threshold", ("mark", "trial"), "1", "distance of the gate's edge"),
    Output("probability", ("mark", "trial"), "1", "that it belongs to that track; NaN = not computed"),
    Output("rivals", ("mark", "trial"), "", "number of tracks in whose gates it lay"),
    Output("pair_mark", ("pair",), "", "position of a plot that lay in a gate"),
    Output("pair_trial", ("pair",), "", "trial"),
    Output("pair_track", ("pair",), "", "number of the track, 0 = not yet numbered"),
    Output("pair_gate", ("pair",), "", "which gate", GATES),
    Output("pair_distance", ("pair",), "1", "from the middle of the gate"),
    Output("area_trial", ("area",), "", "trial"),
    Output("area_track", ("area",), "", "number of the track, 0 = not yet numbered"),
    Output("area_gate", ("area",), "", "which gate", GATES),
    Output("area_time_s", ("area",), "s", "scan that the gate is for"),
    Output("area_centre", ("area", "element"), "m", "predicted point, east and north; one for each motion model"),
    Output("area_covariance", ("area", "element"), "m2", "east-east, north-north, east-north, at the gate's edge"),
    Output("estimate_trial", ("estimate",), "", "trial"),
    Output("estimate_track", ("estimate",), "", "number of the track"),
    Output("estimate_radar", ("estimate",), "", "number of the radar, from 0"),
    Output("estimate_scan", ("estimate",), "", "position of the scan in scan_time_s"),
    Output("estimate_time_s", ("estimate",), "s", "instant that it holds for"),
    Output("estimate_mark", ("estimate",), "", "position of its newest plot, -1 = it missed the scan"),
    Output(
        "estimate_outside",
        ("estimate",),
        "",
        "position of a plot just outside its gate, -1 = none",
    ),
    Output("estimate_status", ("estimate",), "", "where the track is in its life", STATES),
    Output("estimate_misses", ("estimate",), "", "scans missed in a row"),
    Output("estimate_state", ("estimate", "element"), "m, m/s", "east, north, and their velocities"),
    Output("estimate_covariance", ("estimate", "element"), "m2", "east-east, north-north, east-north"),
    Output("estimate_motion", ("estimate", "element"), "", ", ".join(MOTION)),
    Output("estimate_nis", ("estimate",), "1", "squared distance of its newest plot; NaN = none, or not comparable"),
    Output("event_trial", ("event",), "", "trial"),
    Output("event_track", ("event",), "", "number of the track"),
    Output("event_time_s", ("event",), "s", "instant"),
    Output("event_state", ("event",), "", "where its life went", STATES),
    Output("event_reason", ("event",), "", "why", REASONS),
    Output("estimate_joined", ("estimate",), "", "number of the joint track of all radars: the least of its tracks"),
    Output("joined_estimate", ("joined",), "", "position of the estimate at whose instant tracks were joined"),
    Output("joined_tracks", ("joined",), "", "number of tracks in it"),
    Output("joined_state", ("joined", "element"), "m, m/s", "east, north, and their velocities, from all tracks"),
    Output("joined_covariance", ("joined", "element"), "m2", "east-east, north-north, east-north"),
    Output("compared_trial", ("compared",), "", "trial"),
    Output("compared_first", ("compared",), "", "number of a track"),
    Output("compared_second", ("compared",), "", "number of a track of another radar"),
    Output("compared_instants", ("compared",), "", "that both have"),
    Output("compared_statistic", ("compared",), "1", "mean squared distance of place and velocity"),
    Output("compared_threshold", ("compared",), "1", "what it may be"),
    Output("compared_same", ("compared",), "", "whether the tracks were joined", ("apart", "joined")),
    Output("scan_time_s", ("scan",), "s", "instants of the scans"),
    Output("scan_radar", ("scan",), "", "number of the radar"),
    Output("scan_accuracy", ("scan", "element"), "m, rad", "errors of range and azimuth; the radar's east and north"),
)
