"""The paper's claims on trajectories that nobody selected, and two of its claims about what matters little.

Thirty random manoeuvres (specification 10); and how measurements enter, and how often models change, on the paper's
own trajectory (specification 3.3 and 14).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict

PAPER = "trudymai2023"
COUNT = 30
STAGES = ("ballistic", "manoeuvre", "settling", "later")
SIX = tuple(
    StudyEntry(name, name) for name in ("mma2_122", "mma2_11", "kalman_1_20", "kalman_1_5", "kalman_2_20", "kalman_2_1")
)

_BEST = Claim("5, 6", "MMA2-122 is the most accurate at every stage", "best of six")
_ARC = Claim("7", "the quiet constant-acceleration model leads on the arc", "leads")
_HARD = Claim("7", "the noisy model leads in the manoeuvre", "leads")
_MODIFIED = Claim("text", "at 1 Hz the modified rule is slightly better in the hard manoeuvre", "slightly better")
_CONVERSION = Claim("text", "the error of a converted mark may be taken for Gaussian", "justified")
_TRANSITION = Claim("text", "the transition matrix has little influence", "little influence")


def _share(hits: Sequence[bool]) -> tuple[float, float, float]:
    """Share with Wilson's 95 % interval."""
    n, p, z = len(hits), float(np.mean(hits)), 1.96
    middle, half = p + z * z / (2 * n), z * np.sqrt(p * (1 - p) / n + (z / (2 * n)) ** 2)
    return p, float((middle - half) / (1 + z * z / n)), float((middle + half) / (1 + z * z / n))


def _mean(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean over trajectories with its 95 % interval."""
    mean, half = float(np.mean(values)), 2.05 * float(np.std(values, ddof=1)) / np.sqrt(len(values))
    return mean, mean - half, mean + half


def _judge_family(run: StudyRun) -> Sequence[Verdict]:
    numbers = range(COUNT)

    def best(stage: str, number: int) -> bool:
        errors = [run.metric("rms_up_m", e.label, stage, number=number).value for e in SIX]
        return min(errors) == errors[0]

    shares = {stage: _share([best(stage, number) for number in numbers]) for stage in STAGES}
    arc_won, hard_won, after_won, later_won = (shares[stage][0] for stage in STAGES)
    arc = _mean([run.metric("mode_probability_ca_0.05", "mma2_122", STAGES[0], number=k).value for k in numbers])
    models = ("cv_0.05", "ca_0.05", "ca_30")
    hard = [
        [run.metric(f"mode_probability_{name}", "mma2_122", STAGES[1], number=k).value for name in models]
        for k in numbers
    ]
    noisy = _mean([row[2] for row in hard])
    led = _share([row[2] == max(row) for row in hard])
    least, most = (f([shares[stage][0] for stage in STAGES]) for f in (min, max))
    return (
        Verdict(
            _BEST, shares["manoeuvre"][0], "1", "reproduced" if least > 0.9 else "partly" if most > 0.9 else "not",
            f"Before, in and after the manoeuvre and later it has the smallest vertical error on {arc_won:.2f}, "
            f"{hard_won:.2f}, {after_won:.2f}, {later_won:.2f} of the trajectories.",
            *shares["manoeuvre"][1:],
        ),
        Verdict(
            _ARC, arc[0], "1", "reproduced" if arc[1] > 0.5 else "not",
            f"Its mean probability before the manoeuvre is {arc[0]:.3f}.", *arc[1:],
        ),
        Verdict(
            _HARD, noisy[0], "1", "reproduced" if led[0] > 0.9 else "partly" if led[0] > 0.5 else "not",
            f"Its mean probability in the manoeuvre is {noisy[0]:.3f}; it is the highest on {led[0]:.2f} of the "
            "trajectories.",
            *noisy[1:],
        ),
    )  # fmt: skip


def _judge_family_slow(run: StudyRun) -> Sequence[Verdict]:
    ratios = [run.ratio("rms_up_m", "modified", "mma2_122", STAGES[1], number=k).value for k in range(COUNT)]
    better = _share([ratio < 1 for ratio in ratios])
    middle = float(np.median(ratios))
    return *_judge_family(run), Verdict(
        _MODIFIED, middle, "times", "reproduced" if better[1] > 0.5 else "not",
        f"The median of its error in the manoeuvre is {middle:.4f} times that of the combined rule; it is better on "
        f"{better[0]:.2f} of the trajectories.",
    )  # fmt: skip


def _judge_influences(run: StudyRun) -> Sequence[Verdict]:
    place = run.ratio("rms_up_m", "ekf", "converted", "ballistic")
    speed = run.ratio("rms_velocity_up_mps", "ekf", "converted", "ballistic")
    rare_place = run.ratio("rms_up_m", "rarely left", "converted", "ballistic")
    rare_speed = run.ratio("rms_velocity_up_mps", "rarely left", "converted", "ballistic")
    small = rare_place.value > 0.95 and rare_speed.value > 0.95
    return (
        Verdict(
            _CONVERSION, speed.value, "times",
            "reproduced" if min(place.value, speed.value) > 0.97 else "partly" if speed.value > 0.9 else "not",
            f"Filtered in the antenna's own coordinates the error on the arc is {place.value:.3f} times that of "
            f"converted marks in position and {speed.value:.3f} times in velocity.",
            speed.low, speed.high,
        ),
        Verdict(
            _TRANSITION, rare_speed.value, "times",
            "reproduced" if small else "partly" if rare_place.value > 0.95 else "not",
            f"With models left a tenth as often the error on the arc is {rare_place.value:.3f} times as large in "
            f"position and {rare_speed.value:.3f} times in velocity.",
            rare_speed.low, rare_speed.high,
        ),
    )  # fmt: skip


_PAPER_SET = {
    "models": [
        {"kind": "cv", "sigma_mps2": 0.05},
        {"kind": "ca", "sigma_mps2": 0.05},
        {"kind": "ca", "sigma_mps2": 30.0},
    ],
    "measurement": "converted",
    "noise_form": "step",
    "merging": "combined",
    "output": "max",
}
_RARE = [[0.9996, 0.0, 0.0004], [0.0, 0.9996, 0.0004], [0.002, 0.002, 0.996]]
_INFLUENCES = (
    StudyEntry("mma2_122", "converted"),
    StudyEntry("mma2_122", "at the prediction", {"measurement": "converted_at_prediction"}),
    StudyEntry("mma2_122", "ekf", {"measurement": "ekf"}),
    StudyEntry("mma2_122", "ukf", {"measurement": "ukf"}),
    StudyEntry("multiple_model", "rarely left", {**_PAPER_SET, "transition": _RARE}),
)

UNSELECTED = (
    Study(
        name="multiple_model_random",
        title="Thirty random manoeuvres at 20 Hz",
        summary="The paper's six algorithms on trajectories that nobody selected.",
        family="multiple_model",
        paper=Reference(PAPER, "figs. 5-7"),
        item="figures 5 to 7",
        scenario="random_manoeuvres",
        entries=SIX,
        claims=(_BEST, _ARC, _HARD),
        judge=_judge_family,
        sweep={"scenario.number": tuple(range(COUNT))},
        trials=16,
    ),
    Study(
        name="multiple_model_random_1hz",
        title="Thirty random manoeuvres at 1 Hz",
        summary="The same with one plot a second, and the modified rule.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="random_manoeuvres",
        entries=(*SIX, StudyEntry("mma2_122", "modified", {"merging": "modified"})),
        claims=(_BEST, _ARC, _HARD, _MODIFIED),
        judge=_judge_family_slow,
        scenario_parameters={"rate_hz": 1.0},
        sweep={"scenario.number": tuple(range(COUNT))},
        trials=64,
    ),
    Study(
        name="multiple_model_influences",
        title="How marks enter, how often models change",
        summary="Converted marks against the antenna's own coordinates, and a transition matrix that leaves models a "
        "tenth as often, at 20 Hz.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="aeroballistic",
        entries=_INFLUENCES,
        claims=(_CONVERSION, _TRANSITION),
        judge=_judge_influences,
        trials=300,
    ),
)
