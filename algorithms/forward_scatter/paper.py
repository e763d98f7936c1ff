"""Figures and claims of the forward-scatter paper, each as a run that anybody can repeat (specification 8)."""

from __future__ import annotations

from collections.abc import Sequence

from algorithms.forward_scatter.paper_variants import FALSE_VALUES, FOUR_DOPPLERS, ONE_RECEIVER
from algorithms.forward_scatter.study_words import BOUND, FAMILY, LINES, MEAN, ML, PAPER, PRESET, RMS, SD, word_of
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict

_PAPER_AND_ALL = (
    StudyEntry(LINES, "paper"),
    StudyEntry(LINES, "all data", {"window": 31}),
    StudyEntry(ML, "likelihood"),
)


def _accuracy(figure: str) -> Claim:
    return Claim(figure, "the accuracy is sufficient and comparable with the potential one", "comparable")


def _more_data(figure: str) -> Claim:
    return Claim(figure, "all measurements in place of ten lower the error at the end", "by 10 to 20 %")


def _reach(figure: str) -> Claim:
    return Claim(figure, "what the best estimator reaches", "not treated")


def _judge_figure(figure: str, run: StudyRun) -> Sequence[Verdict]:
    at = {label: run.metric(RMS, label, "t=16") for label in ("paper", "likelihood")}
    bound = run.metric(BOUND, "paper", "t=16").value
    ratio = at["paper"].value / bound
    end = run.metric(RMS, "paper", "t=30").value / run.metric(BOUND, "paper", "t=30").value
    first = Verdict(
        _accuracy(figure),
        ratio,
        "times",
        word_of(ratio < 2.5, ratio < 4),
        f"The rms error is {ratio:.1f} times the bound with the course known just after the crossing, {end:.1f} times "
        "it at the end.",
        at["paper"].low / bound,
        at["paper"].high / bound,
    )
    sd = 1 - run.metric(SD, "all data", "t=30").value / run.metric(SD, "paper", "t=30").value
    rms = 1 - run.metric(RMS, "all data", "t=30").value / run.metric(RMS, "paper", "t=30").value
    second = Verdict(
        _more_data(figure),
        100 * sd,
        "%",
        word_of(0.08 <= sd <= 0.22 and 0.08 <= rms <= 0.22, 0.05 <= sd <= 0.25),
        f"The standard deviation falls by {100 * sd:.0f} %, the rms error, with its bias, by {100 * rms:.0f} %.",
    )
    four = run.metric("crossing_distance_bound_4_m", "likelihood", "t=16").value
    best = at["likelihood"].value / four
    third = Verdict(
        _reach(figure),
        best,
        "times",
        "shown",
        f"Maximum likelihood is at {best:.2f} times the bound with the course unknown, the closed form at "
        f"{at['paper'].value / at['likelihood'].value:.1f} times the likelihood.",
    )
    return first, second, third


def _figure(number: str, kilometres: int) -> Study:
    return Study(
        name=f"forward_scatter_figure_{number}",
        title=f"Errors of a pass at {kilometres} km",
        summary="Mean, standard deviation and rms error of the crossing distance over the pass, windows of ten and all "
        "measurements, beside both bounds and maximum likelihood.",
        family=FAMILY,
        paper=Reference(PAPER, f"fig. {number}"),
        item=f"figure {number}",
        scenario=PRESET,
        scenario_parameters={"crossing_distance_m": 1000.0 * kilometres},
        entries=_PAPER_AND_ALL,
        claims=(_accuracy(number), _more_data(number), _reach(number)),
        judge=lambda run: _judge_figure(number, run),
        trials=1000,
        seed=2014,
    )


COURSES = (60.0, 75.0, 90.0, 105.0, 120.0)
_COURSES = Claim("4", "the algorithm works for courses of 60 to 120 degrees", "it works")
_LARGE_N = Claim("4", "a large N raises the bias where the course is not across", "bias grows")
_TRAP = Claim("4", "a likelihood that takes the course for known", "not treated")
_FREE = Claim("4", "a likelihood with the course unknown", "not treated")


def _judge_courses(run: StudyRun) -> Sequence[Verdict]:
    worst = {
        label: max((abs(run.metric(MEAN, label, where, course_deg=c).value), c) for c in COURSES)[0]
        for label, where in (("course known", "end"), ("course unknown", "end"))
    }
    errors = [run.metric(RMS, "paper", "crossing", course_deg=c).value for c in COURSES]
    far = max(run.metric("crossing_distance_over_5km_share", "paper", "crossing", course_deg=c).value for c in COURSES)
    first = Verdict(
        _COURSES,
        max(errors),
        "m",
        word_of(max(errors) < 2000 and far < 0.05, far < 0.2),
        f"The rms error at the crossing is between {min(errors):.0f} and {max(errors):.0f} m; {100 * far:.1f} % of the "
        "trials at most are lost.",
    )
    ten, many = (abs(run.metric(MEAN, label, "crossing", course_deg=60).value) for label in ("paper", "all data"))
    second = Verdict(
        _LARGE_N,
        many / ten,
        "times",
        word_of(many > 1.3 * ten, many > ten),
        f"At 60 degrees the bias at the crossing grows from {ten:.0f} to {many:.0f} m.",
    )
    chi2 = run.metric("chi2_per_dof", "course known", "end", course_deg=60).value
    third = Verdict(
        _TRAP,
        worst["course known"],
        "m",
        "shown",
        f"It is wrong by up to {worst['course known']:.0f} m at the end, with chi2 per degree of freedom of {chi2:.0f} "
        "at 60 degrees.",
    )
    fourth = Verdict(
        _FREE,
        worst["course unknown"],
        "m",
        "shown",
        f"Its bias at the end is at most {worst['course unknown']:.0f} m over all courses.",
    )
    return first, second, third, fourth


FIGURE_4 = Study(
    name="forward_scatter_figure_4",
    title="Courses that are not across the base line",
    summary="Courses of 60 to 120 degrees at 30 km: the closed form with ten and with all measurements, and the "
    "likelihood with the course taken for known and unknown.",
    family=FAMILY,
    paper=Reference(PAPER, "fig. 4"),
    item="figure 4",
    scenario=PRESET,
    scenario_parameters={"crossing_distance_m": 30_000.0},
    entries=(
        StudyEntry(LINES, "paper"),
        StudyEntry(LINES, "all data", {"window": 31}),
        StudyEntry(ML, "course known", {"unknowns": 3}),
        StudyEntry(ML, "course unknown", {"acceleration_switch": False}),
    ),
    sweep={"scenario.course_deg": COURSES},
    claims=(_COURSES, _LARGE_N, _TRAP, _FREE),
    judge=_judge_courses,
    seed=2014,
)

_SAME = Claim("(14)-(18)", "formulas (14), (17) and (18) give about the same accuracy", "about the same")
_SLOPES = Claim("(19)", "the formula of slope and angular velocity", "given for one receiver")


def _judge_formulas(run: StudyRun) -> Sequence[Verdict]:
    near = [run.metric(RMS, label, "t=16").value for label in ("(14)", "(17)", "(18)")]
    late = [run.metric(RMS, label, "t=30").value for label in ("(14)", "(17)", "(18)")]
    spread = max(near) / min(near), max(late) / min(late)
    first = Verdict(
        _SAME,
        spread[1],
        "times",
        word_of(spread[1] < 1.3, spread[0] < 2.2),
        f"The largest error is {spread[0]:.1f} times the smallest just after the crossing, {spread[1]:.1f} times at "
        "the end: (17) depends on the origin of time.",
    )
    before = run.metric(RMS, "(19)", "t=9").value / run.metric(RMS, "(14)", "t=9").value
    second = Verdict(
        _SLOPES,
        before,
        "times",
        "shown",
        f"Before the crossing, at 9 s, its error is {before:.2f} times that of (14): it needs no crossing times.",
    )
    return first, second


FORMULAS = Study(
    name="forward_scatter_formulas",
    title="Formulas for the crossing distance",
    summary="Formulas (14), (17) as printed, (18) and (19) on the same Dopplers at 15 km.",
    family=FAMILY,
    paper=Reference(PAPER, "eqs. (14)-(19)"),
    item="equations (14)-(19)",
    scenario=PRESET,
    entries=(
        StudyEntry(LINES, "(14)"),
        StudyEntry(LINES, "(17)", {"formula": 17, "formula_17_origin": "start"}),
        StudyEntry(LINES, "(18)", {"formula": 18}),
        StudyEntry(LINES, "(19)", {"formula": 19}),
    ),
    claims=(_SAME, _SLOPES),
    judge=_judge_formulas,
    trials=1000,
    seed=2014,
)

_PULL = Claim("2", "small accelerations: the error grows mainly before the crossing", "mainly before")
_ALTITUDE = Claim("2", "an altitude of up to 2 km is insignificant", "insignificant")


def _judge_disturbances(run: StudyRun) -> Sequence[Verdict]:
    def error(segment: str, **at: float) -> float:
        return run.metric(RMS, "paper", segment, **at).value

    calm = {"acceleration_mps2": 0.0, "altitude_m": 0.0}
    speeding, slowing = ({**calm, "acceleration_mps2": a} for a in (1.0, -1.0))
    before = error("t=9", **speeding) / error("t=9", **calm)
    after = error("end", **speeding) / error("end", **calm)
    slow = error("end", **slowing) / error("end", **calm)
    first = Verdict(
        _PULL,
        before,
        "times",
        word_of(before > 1.5 > max(after, slow), before > 1.5 > after),
        f"With 1 m/s2 the error at 9 s is {before:.1f} times as large, at the end {after:.1f} times; with -1 m/s2 at "
        f"the end {slow:.1f} times.",
    )
    high = {**calm, "altitude_m": 2000.0}
    bias = run.metric(MEAN, "paper", "t=16", **high).value - run.metric(MEAN, "paper", "t=16", **calm).value
    change = run.metric(SD, "paper", "t=16", **high).value / run.metric(SD, "paper", "t=16", **calm).value
    second = Verdict(
        _ALTITUDE,
        bias,
        "m",
        word_of(abs(bias) < 250, abs(bias) < 500),
        f"2 km shift the mean by {bias:.0f} m; the standard deviation is {change:.2f} times that of a flight in the "
        "plane.",
    )
    return first, second


DISTURBANCES = Study(
    name="forward_scatter_disturbances",
    title="Accelerations and altitude that nobody knows",
    summary="The closed form at 15 km where the target accelerates across the base line, or flies above the plane of "
    "the receivers.",
    family=FAMILY,
    paper=Reference(PAPER, "sec. 4"),
    item="section 4",
    scenario=PRESET,
    scenario_parameters={"crossing_time_s": 15.0},
    entries=(StudyEntry(LINES, "paper"), StudyEntry(ML, "likelihood")),
    sweep={"scenario.acceleration_mps2": (-1.0, 0.0, 1.0), "scenario.altitude_m": (0.0, 2000.0)},
    claims=(_PULL, _ALTITUDE),
    judge=_judge_disturbances,
    seed=2014,
)

STUDIES = (
    _figure("2", 15),
    _figure("3", 30),
    FIGURE_4,
    FORMULAS,
    DISTURBANCES,
    ONE_RECEIVER,
    FOUR_DOPPLERS,
    FALSE_VALUES,
)
