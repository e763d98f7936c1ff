"""What the paper claims in words, and the numbers of a reference computation, each as a run that anybody can repeat.

The paper prints no number and no figure: what is compared with are tables of a simulation of its own (specification 9,
up to 400 trials), said to be reference numbers. There tracks began from the first three plots whatever the gates said;
here they begin as they do in life.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from algorithms.spec import Reference
from algorithms.studies import Claim, Found, Study, StudyEntry, StudyRun, Verdict, Word

PAPER = "plots2006"
REFERENCE = "{} (reference, not printed)"

_PAPER = StudyEntry("curvature_tracker", "paper")
_LINE = StudyEntry("curvature_tracker", "line", {"predictor": "line", "gate": "sqrt", "kept_plots": 3})
_HELD = StudyEntry("curvature_tracker", "held", {"predictor": "map6", "gate": "exact"})
_IMM = StudyEntry("imm_tracker", "imm", {"association": "nearest"})
_JOINT = StudyEntry("imm_tracker", "joint", {"association": "joint"})


def near(claim: Claim, found: Found, expected: float, within: float, unit: str, digits: int = 0) -> Verdict:
    """Reproduced within this much of the reference or within its own interval, partly within twice as much."""
    off = abs(found.value - expected)
    inside = found.low - within <= expected <= found.high + within
    word: Word = "reproduced" if off <= within or inside else "partly" if off <= 2 * within else "not"
    reason = f"Here {found.value:.{digits}f}, expected {expected:.{digits}f}."
    return Verdict(claim, found.value, unit, word, reason, found.low, found.high)


# Position in m in the legs pre, man, rec, end of the wide turn (specification 9.1).
_TURN = (
    ("paper", (171, 215, 284, 157)),
    ("line", (142, 713, 519, 131)),
    ("held", (164, 210, 255, 147)),
    ("imm", (137, 185, 141, 111)),
)
_LEGS = ("pre", "man", "rec", "end")
_TURN_CLAIMS = tuple(
    Claim("9.1", f"{label}: rms position error in the leg {leg}", REFERENCE.format(f"{value} m"))
    for label, values in _TURN
    for leg, value in zip(_LEGS, values, strict=True)
)
_CURVED = Claim("section 4", "in a turn the curved trajectory is better than straight windows", "said in words")
_ALARMS = Claim("section 2", "a plot in the outermost ring is a manoeuvre: share of false alarms in straight flight",
                REFERENCE.format("0.035"))  # fmt: skip


def _judge_turn(run: StudyRun) -> Sequence[Verdict]:
    out = []
    for claim, (label, leg, expected) in zip(
        _TURN_CLAIMS, [(n, leg, v) for n, vs in _TURN for leg, v in zip(_LEGS, vs, strict=True)], strict=True
    ):
        found = run.metric("rms_horizontal_m", label, leg)
        # Where tracks are lost and begin anew, the way of beginning matters: a window of straight lines is lost.
        within = (0.35 if label == "line" and leg in ("man", "rec") else 0.08) * expected
        out.append(near(claim, found, expected, within, "m"))
    gain = run.ratio("rms_horizontal_m", "paper", "line", "man")
    better = gain.high < 1
    out.append(
        Verdict(
            _CURVED,
            gain.value,
            "1",
            "reproduced" if better else "not",
            f"On the same draws the error in the turn is {gain.value:.2f} times that of straight windows.",
            gain.low,
            gain.high,
        )
    )
    out.append(near(_ALARMS, run.metric("manoeuvre_share", "paper", "pre"), 0.035, 0.008, "1", 3))
    return out


_CROSSINGS = (("paper", {90: 0.0, 30: 0.08, 10: 0.58}), ("imm", {90: 0.0, 30: 0.10, 10: 0.34}),
              ("joint", {90: 0.0, 30: 0.08, 10: 0.04}))  # fmt: skip
_CROSSING_CLAIMS = tuple(
    Claim("9.2", f"{label}, courses {angle} degrees apart: switches of a target", REFERENCE.format(f"{value:g}"))
    for label, values in _CROSSINGS
    for angle, value in values.items()
)


def _judge_crossings(run: StudyRun) -> Sequence[Verdict]:
    cases = [(label, angle, value) for label, values in _CROSSINGS for angle, value in values.items()]
    return [
        near(claim, run.metric("switches_per_target", label, crossing_angle_deg=angle), value, 0.1, "1", 2)
        for claim, (label, angle, value) in zip(_CROSSING_CLAIMS, cases, strict=True)
    ]


_CLUTTER = (("paper", {0: 243, 10: 257, 50: 308}), ("imm", {0: 161, 10: 162}),
            ("joint", {0: 166, 10: 164, 50: 184}))  # fmt: skip
_CLUTTER_CLAIMS = tuple(
    Claim("9.3", f"{label}, {count} false plots a scan: mean OSPA", REFERENCE.format(f"{value} m"))
    for label, values in _CLUTTER
    for count, value in values.items()
)


def _judge_clutter(run: StudyRun) -> Sequence[Verdict]:
    cases = [(label, count, value) for label, values in _CLUTTER for count, value in values.items()]
    return [
        near(claim, run.metric("ospa_m", label, false_plots=count), value, 0.12 * value, "m")
        for claim, (label, count, value) in zip(_CLUTTER_CLAIMS, cases, strict=True)
    ]


_FALSE = (("paper", {20: 0.0003, 50: 0.0245, 100: 0.282}), ("slow", {20: 0.0, 50: 0.0047, 100: 0.063}))
_FALSE_CLAIMS = tuple(
    Claim("9.4", f"{label}, {count} false plots a scan: false tracks in a scan", REFERENCE.format(f"{value:g}"))
    for label, values in _FALSE
    for count, value in values.items()
)
_REACH = Claim("section 2", "a start gate for 1,000 m/s has 6 times the area of one for 350 m/s, and more false tracks",
               REFERENCE.format("4.5 times at 100"))  # fmt: skip


def _judge_false(run: StudyRun) -> Sequence[Verdict]:
    cases = [(label, count, value) for label, values in _FALSE for count, value in values.items()]
    out = [
        near(claim, run.metric("false_tracks_per_scan", label, false_plots=count), value, 0.004 + 0.15 * value, "1", 4)
        for claim, (label, count, value) in zip(_FALSE_CLAIMS, cases, strict=True)
    ]
    wide, narrow = (run.metric("false_tracks_per_scan", label, false_plots=100).value for label in ("paper", "slow"))
    ratio = wide / narrow if narrow else float("nan")
    word: Word = "reproduced" if 3 < ratio < 7 else "not"
    out.append(Verdict(_REACH, ratio, "1", word, f"{ratio:.1f} times as many false tracks at 100 false plots."))
    return out


# Shares inside the inner ellipse, in the outer ring and outside in straight flight (specification 5).
_GATES = tuple((label, (0.65, 0.05, 0.002)) for label in ("paper", "line", "held"))
_WHERE = ("share in the inner ellipse", "share in the outer ring", "share just outside the gate")
_GATE_CLAIMS = tuple(
    Claim("section 2", f"{label}: {what}", REFERENCE.format(f"{value:g}"))
    for label, values in _GATES
    for what, value in zip(_WHERE, values, strict=True)
)


def _judge_gates(run: StudyRun) -> Sequence[Verdict]:
    out = []
    names = ("inner_share", "manoeuvre_share", "outside_share")
    cases = [(label, name, value) for label, values in _GATES for name, value in zip(names, values, strict=True)]
    for claim, (label, name, expected) in zip(_GATE_CLAIMS, cases, strict=True):
        found = run.metric(name, label)
        within = {"inner_share": 0.1, "manoeuvre_share": 0.02, "outside_share": 0.002}[name]
        out.append(near(claim, found, expected, within, "1", 3))
    return out


Judge = Callable[[StudyRun], Sequence[Verdict]]


def study(
    name: str, title: str, summary: str, item: str, scenario: str, entries: tuple[StudyEntry, ...],
    claims: tuple[Claim, ...], judge: Judge, **more: Any,
) -> Study:  # fmt: skip
    """A study of this family and its paper."""
    return Study(
        name=name, title=title, summary=summary, family="plot_tracking", paper=Reference(PAPER, item), item=item,
        scenario=scenario, entries=entries, claims=claims, judge=judge, **more,
    )  # fmt: skip


STUDIES = (
    study(
        "plots_wide_turn",
        "Trackers in a wide turn",
        "Position errors before, in and after a turn by 90 degrees: the paper's tracker, straight windows, the "
        "penalised curve with exact gates, and interacting models, on the same draws.",
        "section 4",
        "wide_turn",
        (_PAPER, _LINE, _HELD, _IMM),
        (*_TURN_CLAIMS, _CURVED, _ALARMS),
        _judge_turn,
        trials=200,
        seed=2006,
    ),
    study(
        "plots_crossing",
        "Crossing aircraft",
        "Two aircraft at one place at one instant, every tenth plot missing, ten false plots a scan: how often tracks "
        "change hands.",
        "section 1",
        "crossing_aircraft",
        (_PAPER, _IMM, _JOINT),
        _CROSSING_CLAIMS,
        _judge_crossings,
        scenario_parameters={"detection_probability": 0.9, "false_plots": 10.0},
        sweep={"scenario.crossing_angle_deg": [90.0, 30.0, 10.0]},
        trials=64,
        seed=2006,
    ),
    study(
        "plots_clutter",
        "Ten aircraft among false plots",
        "Every tenth plot missing, 0, 10 and 50 false plots a scan: the distance of the set of tracks from the set of "
        "aircraft.",
        "section 1",
        "ten_aircraft",
        (_PAPER, _IMM, _JOINT),
        _CLUTTER_CLAIMS,
        _judge_clutter,
        scenario_parameters={"detection_probability": 0.9},
        sweep={"scenario.false_plots": [0.0, 10.0, 50.0]},
        trials=32,
        seed=2006,
    ),
    study(
        "plots_false_tracks",
        "Tracks of nothing",
        "False plots alone: how many tracks are confirmed in a scan, with the paper's largest speed and with 350 m/s.",
        "section 2",
        "clutter_only",
        (_PAPER, StudyEntry("curvature_tracker", "slow", {"max_speed_mps": 350.0})),
        (*_FALSE_CLAIMS, _REACH),
        _judge_false,
        sweep={"scenario.false_plots": [20.0, 50.0, 100.0]},
        trials=32,
        seed=2006,
    ),
    study(
        "plots_gates",
        "What the gates hold",
        "Straight flight: shares of plots in the inner ellipse and in the ring of manoeuvres, for the printed gates, "
        "for straight windows with the root of K_Q, and for gates from the covariance.",
        "section 2",
        "straight_aircraft",
        (_PAPER, _LINE, _HELD),
        _GATE_CLAIMS,
        _judge_gates,
        trials=200,
        seed=2006,
    ),
)
