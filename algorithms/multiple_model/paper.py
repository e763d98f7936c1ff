"""Figures and claims of the multiple-model paper, each as a run that anybody can repeat (specification 10, 14).

The paper gives no trajectory and prints almost no numbers. The scenario is a reconstruction that was searched for the
claims marked "selected": it shows that the paper's pictures are possible, and is no independent evidence for them.
"""

from __future__ import annotations

from collections.abc import Sequence

from algorithms.multiple_model.paper_unselected import UNSELECTED
from algorithms.multiple_model.textbook import largest_difference_m
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict, Word

PAPER = "trudymai2023"
SIX = tuple(
    StudyEntry(name, name) for name in ("mma2_122", "mma2_11", "kalman_1_20", "kalman_1_5", "kalman_2_20", "kalman_2_1")
)
# Operations of a mark of MMA2 with three models, and of its three merges if all are done (specification 6.5).
OPERATIONS_THREE, MERGING_THREE = 4_444, 1_782
STAGES = ("ballistic", "manoeuvre", "settling", "near-straight")
RULES = ("combined", "modified", "moment", "max")

_BEST = Claim(
    "5, 6", "MMA2-122 is the most accurate at every stage (the scenario was selected for this)", "best of six"
)
_ARC = Claim("7", "the quiet constant-acceleration model leads on the arc", "leads")
_HARD = Claim("7", "the noisy model leads in the manoeuvre (the scenario was selected for this)", "leads")
_IDLE = Claim("7", "in MMA2-11 the quiet model takes practically no part", "no part")
_COMBINED = Claim("text", "the combined rule beats all hypotheses together and the best one alone", "better")
_MODIFIED = Claim("text", "the modified rule equals the combined one at 20 Hz", "equal")
_MODIFIED_SLOW = Claim("text", "at 1 Hz the modified rule is slightly better in the hard manoeuvre", "slightly better")
_CHEAPER = Claim("text", "the modified rule is cheaper than the combined one", "cheaper")
_TEXTBOOK = Claim("text", "MMA2 reduces to the textbook's IMM, and merging may come before the prediction", "equal")
_STRUCTURES = Claim("text", "MMA3 is the most accurate, MMA2 at most 5 % worse", "at most 5 %")
_STRAIGHT = Claim("text", "for straight flight the constant-velocity model takes over", "takes over")


def _best(run: StudyRun) -> Verdict:
    rivals = [e.label for e in SIX[1:]]
    ratios = {
        stage: min((run.ratio("rms_up_m", rival, "mma2_122", stage) for rival in rivals), key=lambda f: f.value)
        for stage in STAGES
    }
    won = sum(found.value > 1 for found in ratios.values())
    start = min(run.ratio("rms_up_m", rival, "mma2_122", "initial").value for rival in rivals)
    hard = ratios["manoeuvre"]
    word: Word = "reproduced" if won == len(STAGES) and start > 1 else "partly" if won else "not"
    return Verdict(
        _BEST,
        hard.value,
        "times",
        word,
        f"It has the smallest vertical error on {won} of 4 stages after the start; the best rival's error is "
        f"{hard.value:.3f} times its own in the manoeuvre and {start:.3f} times in the first 10 s.",
        hard.low,
        hard.high,
    )


def _judge_figures(run: StudyRun) -> Sequence[Verdict]:
    arc = run.metric("mode_probability_ca_0.05", "mma2_122", "ballistic")
    hard = run.metric("mode_probability_ca_30", "mma2_122", "manoeuvre")
    idle = run.metric("mode_probability_cv_5", "mma2_11", "ballistic")
    return (
        _best(run),
        Verdict(
            _ARC, arc.value, "1", "reproduced" if arc.value > 0.5 else "not",
            f"Its mean probability on the arc is {arc.value:.3f}.", arc.low, arc.high,
        ),
        Verdict(
            _HARD, hard.value, "1", "reproduced" if hard.value > 0.5 else "not",
            f"Its mean probability in the manoeuvre is {hard.value:.3f}.", hard.low, hard.high,
        ),
        Verdict(
            _IDLE, idle.value, "1", "not" if idle.value > 0.1 else "reproduced",
            f"Its mean probability on the arc is {idle.value:.3f}.", idle.low, idle.high,
        ),
    )  # fmt: skip


def _judge_merging(run: StudyRun) -> Sequence[Verdict]:
    moment = run.ratio("rms_up_m", "moment", "combined", "ballistic")
    largest = max(run.ratio("rms_up_m", "max", "combined", stage).value for stage in STAGES)
    hard = run.ratio("rms_up_m", "modified", "combined", "manoeuvre")
    structure = [run.ratio("rms_up_m", "combined", "gpb2", stage) for stage in STAGES]
    worst = max(structure, key=lambda f: f.value)
    least = min(found.value for found in structure)
    near: Word = "not" if worst.value >= 1.05 else "reproduced" if least > 1 else "partly"
    return (
        Verdict(
            _COMBINED, moment.value, "times",
            "reproduced" if moment.value > 1 and largest > 1.01 else "partly",
            f"On the arc the error of all together is {moment.value:.3f} times its own; that of the best one alone is "
            f"at most {largest:.3f} times its own on any stage.",
            moment.low, moment.high,
        ),
        Verdict(
            _MODIFIED, hard.value, "times", "reproduced" if abs(hard.value - 1) < 0.002 else "not",
            f"Its error in the manoeuvre is {hard.value:.4f} times that of the combined rule.", hard.low, hard.high,
        ),
        Verdict(
            _STRUCTURES, worst.value, "times", near,
            f"With the combined rule MMA2's error is {least:.3f} to {worst.value:.3f} times that of MMA3 over the "
            "stages.",
            worst.low, worst.high,
        ),
        _cheaper(run),
    )  # fmt: skip


def _cheaper(run: StudyRun) -> Verdict:
    """Whole marks, where code branches; our own takes the same time, as it works on sixteen trials at once."""
    modified, combined = (run.metric("merging_operations", rule).value for rule in ("modified", "combined"))
    rest = OPERATIONS_THREE - MERGING_THREE
    ratio = (rest + modified) / (rest + combined)
    word: Word = "reproduced" if ratio < 0.9 else "partly" if ratio < 0.99 else "not"
    return Verdict(
        _CHEAPER, ratio, "times", word,
        f"Where code branches, merging takes {modified:.0f} operations of a mark against {combined:.0f}; the whole "
        f"mark takes {ratio:.3f} times as many.",
    )  # fmt: skip


def _textbook() -> Verdict:
    apart = largest_difference_m()
    return Verdict(
        _TEXTBOOK, apart, "m", "reproduced" if apart < 1e-6 else "not",
        f"On one trial at 1 Hz the textbook's filter, written apart and merging afterwards, lies at most {apart:.1e} m "
        "from MMA2 with all hypotheses merged.",
    )  # fmt: skip


def _judge_merging_slow(run: StudyRun) -> Sequence[Verdict]:
    first, _, third, cheaper = _judge_merging(run)
    hard = run.ratio("rms_up_m", "modified", "combined", "manoeuvre")
    second = Verdict(
        _MODIFIED_SLOW, hard.value, "times", "reproduced" if hard.high < 1 else "not",
        f"Its error in the manoeuvre is {hard.value:.4f} times that of the combined rule.", hard.low, hard.high,
    )  # fmt: skip
    return first, second, third, cheaper, _textbook()


def _judge_straight(run: StudyRun) -> Sequence[Verdict]:
    share = run.metric("mode_probability_cv_0.05", "mma2_122", "steady")
    word: Word = "reproduced" if share.value > 0.5 else "not"
    reason = f"Its mean probability after 20 s is {share.value:.3f}."
    return (Verdict(_STRAIGHT, share.value, "1", word, reason, share.low, share.high),)


_VARIANTS = (
    *(StudyEntry("mma2_122", rule, {"merging": rule}) for rule in RULES),
    StudyEntry("mma2_122", "gpb2", {"structure": "gpb2"}),
    StudyEntry("mma2_122", "gpb1", {"structure": "gpb1", "merging": "moment"}),
)

STUDIES = (
    Study(
        name="multiple_model_figures",
        title="Six algorithms at 20 Hz",
        summary="Vertical errors and model probabilities of the paper's six algorithms on a reconstructed trajectory.",
        family="multiple_model",
        paper=Reference(PAPER, "figs. 5-7"),
        item="figures 5 to 7",
        scenario="aeroballistic",
        entries=SIX,
        claims=(_BEST, _ARC, _HARD, _IDLE),
        judge=_judge_figures,
        trials=1000,
    ),
    Study(
        name="multiple_model_figures_1hz",
        title="Six algorithms at 1 Hz",
        summary="The same with one plot a second.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="aeroballistic",
        entries=SIX,
        claims=(_BEST, _ARC, _HARD, _IDLE),
        judge=_judge_figures,
        scenario_parameters={"rate_hz": 1.0},
        trials=1000,
    ),
    Study(
        name="multiple_model_merging",
        title="Merging rules and structures at 20 Hz",
        summary="Three models, merged by four rules and in three structures, on the same draws.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="aeroballistic",
        entries=_VARIANTS,
        claims=(_COMBINED, _MODIFIED, _STRUCTURES, _CHEAPER),
        judge=_judge_merging,
    ),
    Study(
        name="multiple_model_merging_1hz",
        title="Merging rules and structures at 1 Hz",
        summary="The same with one plot a second.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="aeroballistic",
        entries=_VARIANTS,
        claims=(_COMBINED, _MODIFIED_SLOW, _STRUCTURES, _CHEAPER, _TEXTBOOK),
        judge=_judge_merging_slow,
        scenario_parameters={"rate_hz": 1.0},
        trials=1000,
    ),
    Study(
        name="multiple_model_straight",
        title="Straight flight",
        summary="Which model leads where the object flies straight on.",
        family="multiple_model",
        paper=Reference(PAPER, "text"),
        item="text",
        scenario="straight_flight",
        entries=(StudyEntry("mma2_122", "mma2_122"), StudyEntry("mma2_11", "mma2_11")),
        claims=(_STRAIGHT,),
        judge=_judge_straight,
    ),
    *UNSELECTED,
)
