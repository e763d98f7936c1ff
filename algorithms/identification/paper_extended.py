"""Beyond the paper's table: honest single plots, three and four radars, tracks that share their manoeuvres.

The expected numbers are those of specification 12.4, 12.6 and 12.7.
"""

from __future__ import annotations

from collections.abc import Sequence

from algorithms.identification.verdicts import PAPER, REFERENCE, verdict
from algorithms.spec import Reference
from algorithms.studies import Claim, Found, Study, StudyEntry, StudyRun, Verdict

# Conversion, azimuth error in degrees, mean squared error of a plot over its covariance (2 is honest).
_NEES = (
    ("lin", 2, 4.502),
    ("paper", 2, 1.445),
    ("dcm", 2, 2.001),
    ("ucm", 2, 1.999),
    ("mucm", 2, 2.000),
    ("paper_literal", 1, 1625.0),
)
_SINGLE = tuple(
    Claim(
        "table",
        f"azimuth error of {sigma} degrees, {label}: squared error of a plot over its covariance, 2 is honest",
        REFERENCE.format(f"{expected:.4g}"),
    )
    for label, sigma, expected in _NEES
)


def _judge_single(run: StudyRun) -> Sequence[Verdict]:
    out = []
    for claim, (label, sigma, expected) in zip(_SINGLE, _NEES, strict=True):
        found = run.metric_of_target("plot_nees", label, "1", sigma_azimuth_deg=sigma)
        whole = Found(2 * found.value, 2 * found.low, 2 * found.high)
        # The tail of the linearised method is long.
        out.append(verdict(claim, whole, expected, (0.12 if label == "lin" else 0.05) * expected))
    return out


SINGLE = Study(
    name="identification_single_plots",
    title="Which covariance a single plot deserves",
    summary="The squared error of a converted plot over its covariance, over the azimuth error: what the paper's "
    "correction claims too much, what plain conversion claims too little, and what the misprint of (4c) does.",
    family="identification",
    paper=Reference(PAPER, "eqs. (1)-(4)"),
    item="table of single plots",
    scenario="two_radars_two_targets",
    entries=tuple(StudyEntry("pairwise_test", label, {"conversion": label}) for label, *_ in _NEES),
    sweep={"scenario.sigma_azimuth_deg": (0.5, 1, 2, 3)},
    claims=_SINGLE,
    judge=_judge_single,
    trials=8_000,
    seed=2008,
)

# Radars, entry, share of targets of which all plots and no other one are put together.
_SETS = ((3, "exact", 0.879), (3, "sequential", 0.862), (4, "exact", 0.820), (4, "sequential", 0.787))
_RADARS = tuple(
    Claim(
        "table",
        f"{radars} radars, six targets with misses and false plots, {label}: share of targets put together rightly",
        REFERENCE.format(f"{expected:.3f}"),
    )
    for radars, label, expected in _SETS
)
_BETTER = Claim("table", "the exact choice of sets is better than radar by radar, for three radars and four", "both")


def _judge_radars(run: StudyRun) -> Sequence[Verdict]:
    found = [run.metric("probability_correct", label, radars=radars) for radars, label, _ in _SETS]
    out = [verdict(c, f, expected, 0.05) for c, f, (_, _, expected) in zip(_RADARS, found, _SETS, strict=True)]
    gains = [found[0].value - found[1].value, found[2].value - found[3].value]
    out.append(
        Verdict(
            _BETTER,
            min(gains),
            "1",
            "reproduced" if min(gains) > 0 else "not",
            f"By {gains[0]:.3f} with three radars and by {gains[1]:.3f} with four.",
        )
    )
    return out


_CLUSTER = {"detection_probability": 0.9, "clutter_per_radar": 2, "decision": "most_likely"}
RADARS = Study(
    name="identification_many_radars",
    title="Three radars and four",
    summary="Six targets in a square of 20 km, a tenth of the plots missing and two false ones a radar: the best "
    "choice of sets, found as an integer program, against radar by radar.",
    family="identification",
    paper=Reference(PAPER, "table 1, extended"),
    item="table of many radars",
    scenario="two_radars_cluster",
    scenario_parameters={"targets": 6, "looks": 20, "detection_probability": 0.9, "false_plots": 2},
    entries=(
        StudyEntry("multi_radar_assignment", "exact", _CLUSTER),
        StudyEntry("multi_radar_assignment", "sequential", _CLUSTER | {"most_candidates": 1}),
    ),
    sweep={"scenario.radars": (3, 4)},
    claims=(*_RADARS, _BETTER),
    judge=_judge_radars,
    trials=30,
    seed=2008,
)

# Entry, mean statistic of true pairs (4 is honest), share of correct associations.
_SHARED = (("ignored", 2.89, 0.865), ("included", 4.0, 0.920))
_MANOEUVRES = tuple(
    claim
    for label, statistic, correct in _SHARED
    for claim in (
        Claim("table", f"common manoeuvres {label}: mean statistic of true pairs, 4 is honest",
              REFERENCE.format(f"{statistic:.2f}")),
        Claim("table", f"common manoeuvres {label}: share of correct associations", REFERENCE.format(f"{correct:.3f}")),
    )
)  # fmt: skip


def _judge_manoeuvres(run: StudyRun) -> Sequence[Verdict]:
    out = []
    for k, (label, statistic, correct) in enumerate(_SHARED):
        found = run.metric("nis", label, "t=190")
        whole = Found(4 * found.value, 4 * found.low, 4 * found.high)
        # Tracks from two plots on are a little too sure of themselves whatever is allowed for.
        out.append(verdict(_MANOEUVRES[2 * k], whole, statistic, 0.35 if label == "ignored" else 0.6))
        out.append(verdict(_MANOEUVRES[2 * k + 1], run.metric("probability_correct", label, "t=190"), correct, 0.04))
    return out


MANOEUVRES = Study(
    name="identification_common_manoeuvres",
    title="Tracks of one target share its manoeuvres",
    summary="Two targets 600 m apart that manoeuvre a little are tracked by two radars: a test that takes the errors "
    "of both tracks for independent has too wide a gate and decides less.",
    family="identification",
    paper=Reference(PAPER, "text before table 1"),
    item="cross-covariance",
    scenario="two_radars_tracks",
    scenario_parameters={"scans": 20, "offset_along_m": 600, "acceleration_density_m2ps3": 1},
    entries=(
        StudyEntry("track_association", "ignored", {"acceleration_density_m2ps3": 1}),
        StudyEntry("track_association", "included", {"acceleration_density_m2ps3": 1, "cross_covariance": True}),
    ),
    claims=_MANOEUVRES,
    judge=_judge_manoeuvres,
    trials=2_000,
    seed=2008,
)

EXTENDED = (SINGLE, RADARS, MANOEUVRES)
