"""The paper's table and the curves around it, each as a run that anybody can repeat (specification 12)."""

from __future__ import annotations

from collections.abc import Sequence

from algorithms.identification.paper_extended import EXTENDED
from algorithms.identification.verdicts import PAPER, REFERENCE, verdict
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict

# A printed share is reproduced within this much: its trials are not stated, a thousand give 0.03.
PRINTED_WITHIN = 0.035
# Target, method and what table 1 prints: correct, wrong, undecided.
PRINTED = (
    ("lin", "1", (0.674, 0.010, 0.316)),
    ("lin", "2", (0.342, 0.008, 0.650)),
    ("paper", "1", (0.631, 0.009, 0.360)),
    ("paper", "2", (0.649, 0.004, 0.347)),
)
_ROWS = tuple(
    Claim(
        "table 1",
        f"{'linearised' if label == 'lin' else 'bias corrected'}, target {target}: correct, wrong, undecided",
        " / ".join(f"{share:.3f}" for share in shares),
    )
    for label, target, shares in PRINTED
)
_EXCHANGED = Claim(
    "table 1", "the row of the linearised method for target 2 with its first and last number exchanged", "0.650 correct"
)
_GAIN = Claim("table 1", "removing the bias raises the share of correct associations of target 2", "0.342 to 0.649")
_KINDS = ("probability_correct", "probability_wrong", "probability_undecided")


def _judge_table_1(run: StudyRun) -> Sequence[Verdict]:
    out = []
    for claim, (label, target, shares) in zip(_ROWS, PRINTED, strict=True):
        ours = [run.metric_of_target(metric, label, target) for metric in _KINDS]
        near = all(abs(found.value - share) < PRINTED_WITHIN for found, share in zip(ours, shares, strict=True))
        correct, wrong, undecided = (found.value for found in ours)
        out.append(
            Verdict(
                claim,
                correct,
                "1",
                "reproduced" if near else "not",
                f"Correct {correct:.3f}, wrong {wrong:.3f}, undecided {undecided:.3f}.",
                ours[0].low,
                ours[0].high,
            )
        )
    row = run.metric_of_target("probability_correct", "lin", "2")
    fits = abs(row.value - 0.650) < PRINTED_WITHIN
    out.append(
        Verdict(
            _EXCHANGED,
            row.value,
            "1",
            "shown" if fits else "not",
            f"Correct {row.value:.3f}: the exchanged row fits. That two columns were exchanged is a hypothesis, an "
            "inference from four rows, not a proof.",
            row.low,
            row.high,
        )
    )
    gain = run.metric_of_target("probability_correct", "paper", "2")
    out.append(
        Verdict(
            _GAIN,
            gain.value - row.value,
            "1",
            "not" if gain.value - row.value < 0.1 else "reproduced",
            f"On the same draws the correction changes the share by {gain.value - row.value:.3f}: the bias of the "
            "difference of two plots is a hundredth of its standard deviation.",
        )
    )
    return out


TABLE_1 = Study(
    name="identification_table_1",
    title="The paper's table of associations",
    summary="Two targets 1,060 m apart on the first radar's line of sight, plain and bias-corrected conversion on the "
    "same draws: correct, wrong and undecided plots beside the printed ones.",
    family="identification",
    paper=Reference(PAPER, "table 1"),
    item="table 1",
    scenario="two_radars_two_targets",
    entries=(
        StudyEntry("pairwise_test", "lin", {"conversion": "lin"}),
        StudyEntry("pairwise_test", "paper", {"conversion": "paper"}),
        StudyEntry("assignment", "matching", {"conversion": "polar"}),
    ),
    claims=(*_ROWS, _EXCHANGED, _GAIN),
    judge=_judge_table_1,
    trials=20_000,
    seed=2008,
)


# Specification 12.3, target 1.
_APART = ((500, 0.120), (1000, 0.604), (1500, 0.949))
_SEPARATION = tuple(
    Claim(
        "curve",
        f"{dr} m apart in range: share of correct associations, plain conversion",
        REFERENCE.format(f"{expected:.3f}"),
    )
    for dr, expected in _APART
)
_RULE = Claim("curve", "1,000 m apart: share of right pairs in the most likely matching", REFERENCE.format("0.988"))


def _judge_separation(run: StudyRun) -> Sequence[Verdict]:
    out = [
        verdict(claim, run.metric_of_target("probability_correct", "lin", "1", offset_along_m=dr), expected, 0.03)
        for claim, (dr, expected) in zip(_SEPARATION, _APART, strict=True)
    ]
    found = run.metric_of_target("assignment_correct", "matching", "1", offset_along_m=1000)
    return [*out, verdict(_RULE, found, 0.99, 0.01)]


SEPARATION = Study(
    name="identification_separation",
    title="Association over the separation of the targets",
    summary="Target 2 moves away along the first radar's line of sight: the threshold rule with plain and with exact "
    "measurements, and the most likely matching.",
    family="identification",
    paper=Reference(PAPER, "table 1, extended"),
    item="curves",
    scenario="two_radars_two_targets",
    entries=(
        StudyEntry("pairwise_test", "lin", {"conversion": "lin"}),
        StudyEntry("pairwise_test", "polar", {"conversion": "polar"}),
        StudyEntry("assignment", "matching", {"conversion": "polar"}),
    ),
    sweep={"scenario.offset_along_m": (0, 250, 500, 750, 1000, 1250, 1500, 2000)},
    claims=(*_SEPARATION, _RULE),
    judge=_judge_separation,
    trials=4_000,
    seed=2008,
)

_BASES_KM = ((0, 0.994), (30, 0.663), (100, 0.037))
_BASE = tuple(
    Claim(
        "curve",
        f"base of {base:g} km: share of correct associations, plain conversion",
        REFERENCE.format(f"{expected:.3f}"),
    )
    for base, expected in _BASES_KM
)
_ACCURACY = Claim("curve", "a longer base makes fused positions better and associations worse", "both")


def _judge_base(run: StudyRun) -> Sequence[Verdict]:
    out = [
        verdict(claim, run.metric_of_target("probability_correct", "lin", "1", base_m=1000 * base), expected, 0.03)
        for claim, (base, expected) in zip(_BASE, _BASES_KM, strict=True)
    ]
    short = run.metric("rms_horizontal_m", "matching", base_m=10_000).value
    long = run.metric("rms_horizontal_m", "matching", base_m=75_000).value
    out.append(
        Verdict(
            _ACCURACY,
            short / long,
            "times",
            "reproduced" if short > 2 * long else "not",
            f"The fused error is {short:.0f} m on a base of 10 km and {long:.0f} m on 75 km.",
        )
    )
    return out


BASE = Study(
    name="identification_base",
    title="What a longer base costs and brings",
    summary="The second radar moves away: associations get worse while the positions fused from both plots get better.",
    family="identification",
    paper=Reference(PAPER, "table 1, extended"),
    item="curves",
    scenario="two_radars_two_targets",
    entries=(
        StudyEntry("pairwise_test", "lin", {"conversion": "lin"}),
        StudyEntry("assignment", "matching", {"conversion": "polar", "decision": "most_likely"}),
    ),
    sweep={"scenario.base_m": (0, 10_000, 20_000, 30_000, 50_000, 75_000, 100_000, 150_000)},
    claims=(*_BASE, _ACCURACY),
    judge=_judge_base,
    trials=4_000,
    seed=2008,
)

# Specification 12.3, false rejection at 4 degrees, where a gate of 0.01 should reject 0.01.
_AT_4 = (("lin", 0.1033), ("paper", 0.0049), ("mucm", 0.0200), ("polar", 0.0106))
_CONSISTENCY = tuple(
    Claim(
        "curve",
        f"azimuth error of 4 degrees, {label}: true pairs that a gate of 0.01 rejects",
        REFERENCE.format(f"{expected:.4f}"),
    )
    for label, expected in _AT_4
)


def _judge_consistency(run: StudyRun) -> Sequence[Verdict]:
    return [
        verdict(claim, run.metric("false_rejection", label, sigma_azimuth_deg=4), expected, max(0.1 * expected, 0.005))
        for claim, (label, expected) in zip(_CONSISTENCY, _AT_4, strict=True)
    ]


CONSISTENCY = Study(
    name="identification_consistency",
    title="Which conversion is honest at which azimuth error",
    summary="True pairs outside a gate of 0.01 over the azimuth error: the exact likelihood keeps the promise "
    "everywhere, conversions as far as the nonlinearity index allows.",
    family="identification",
    paper=Reference(PAPER, "eqs. (1)-(4)"),
    item="curves",
    scenario="two_radars_two_targets",
    entries=tuple(StudyEntry("pairwise_test", label, {"conversion": label}) for label, _ in _AT_4),
    sweep={"scenario.sigma_azimuth_deg": (0.5, 0.7, 1, 1.5, 2, 3, 4)},
    claims=_CONSISTENCY,
    judge=_judge_consistency,
    trials=4_000,
    seed=2008,
)

_MANY = (
    Claim("table", "8 targets in 20 km: share that the threshold rule associates correctly", REFERENCE.format("0.660")),
    Claim("table", "8 targets in 20 km: share of right pairs in the most likely matching", REFERENCE.format("0.948")),
    Claim("table", "12 targets in 20 km: share of right pairs in the most likely matching", REFERENCE.format("0.923")),
)


def _judge_many(run: StudyRun) -> Sequence[Verdict]:
    found = (
        (run.metric("probability_correct", "threshold", targets=8), 0.660, 0.06),
        (run.metric("assignment_correct", "matching", targets=8), 0.948, 0.03),
        (run.metric("assignment_correct", "matching", targets=12), 0.923, 0.03),
    )
    return [verdict(c, f, e, w) for c, (f, e, w) in zip(_MANY, found, strict=True)]


MANY = Study(
    name="identification_many_targets",
    title="Many targets in one place",
    summary="Two to twelve targets at random in a square of 20 km: the threshold rule leaves ever more undecided, the "
    "most likely matching does not.",
    family="identification",
    paper=Reference(PAPER, "table 1, extended"),
    item="table of many targets",
    scenario="two_radars_cluster",
    entries=(
        StudyEntry("pairwise_test", "threshold", {"conversion": "lin"}),
        StudyEntry("assignment", "matching", {"conversion": "mucm"}),
    ),
    sweep={"scenario.targets": (2, 5, 8, 12)},
    claims=_MANY,
    judge=_judge_many,
    trials=100,
    seed=2008,
)

_TRACKS = (
    Claim(
        "table",
        "tracks of 20 scans, plain conversion: true pairs that a gate of 0.01 rejects",
        REFERENCE.format("0.027"),
    ),
    Claim("table", "tracks of 20 scans, straight flights fitted exactly: the same", REFERENCE.format("0.013")),
    Claim(
        "table",
        "300 m apart after 20 scans: share of right pairs in the most likely matching",
        REFERENCE.format("1.000"),
    ),
)


def _judge_tracks(run: StudyRun) -> Sequence[Verdict]:
    leg = "t=190"
    found = (
        (run.metric("false_rejection", "lin", leg), 0.027, 0.012),
        (run.metric("false_rejection", "polar", leg), 0.012, 0.008),
        (run.metric("assignment_correct", "mucm", leg), 1.0, 0.01),
    )
    return [verdict(c, f, e, w) for c, (f, e, w) in zip(_TRACKS, found, strict=True)]


TRACKS = Study(
    name="identification_tracks",
    title="Tracks instead of plots",
    summary="Two targets 300 m apart are tracked by two radars for twenty scans: what plots cannot tell apart tracks "
    "can; which conversion keeps them honest.",
    family="identification",
    paper=Reference(PAPER, "text before table 1"),
    item="table of tracks",
    scenario="two_radars_tracks",
    scenario_parameters={"scans": 20, "offset_along_m": 300},
    entries=tuple(
        StudyEntry("track_association", label, {"conversion": label})
        for label in ("lin", "paper", "mucm", "ducm", "polar")
    ),
    claims=_TRACKS,
    judge=_judge_tracks,
    trials=1_000,
    seed=2008,
)

STUDIES = (TABLE_1, SEPARATION, BASE, CONSISTENCY, MANY, TRACKS, *EXTENDED)
