"""Studies of other sensors and of false values: one receiver with an angle, four Dopplers (specification 8.5, 8.6)."""

from __future__ import annotations

from collections.abc import Sequence

from algorithms.forward_scatter.study_words import ANGLE, BOUND, FAMILY, LINES, ML, PAPER, PRESET, RMS, word_of
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict

_REGRESSION = Claim("(20)", "the angular velocity from all azimuths through the crossing", "not treated")
_ENDS = Claim("(20)", "azimuth over time, (20), is the more accurate the further the target is away", "best far away")
DISTANCES_M = (15_000.0, 30_000.0)
SIGMAS_DEG = (0.1, 0.5, 1.0)


def _judge_one_receiver(run: StudyRun) -> Sequence[Verdict]:
    def error(label: str, segment: str, sigma: float = 0.5, distance: float = DISTANCES_M[0]) -> float:
        at = {"sigma_azimuth_deg": sigma, "crossing_distance_m": distance}
        return run.metric(RMS, label, segment, **at).value

    ends, slope, near = error("ends", "t=30"), error("slope", "t=30"), error("ends", "t=16")
    first = Verdict(
        _ENDS,
        slope / ends,
        "times",
        word_of(slope > 1.5 * ends and near > ends, slope > ends),
        f"At the end its error is {ends:.0f} m against {slope:.0f} m of the slope; near the crossing, "
        f"where it is singular, the last value is held: {near:.0f} m.",
    )
    at = {"sigma_azimuth_deg": 0.5, "crossing_distance_m": DISTANCES_M[0]}
    share = error("regression", "t=16") / run.metric(BOUND, "regression", "t=16", **at).value
    errors = [error("regression", "t=16", sigma) for sigma in SIGMAS_DEG]
    second = Verdict(
        _REGRESSION,
        share,
        "times",
        "shown",
        f"Its error just after the crossing is {share:.2f} times the bound with the course known, at 0.5 degrees; from "
        f"0.1 to 1 degree it grows from {errors[0]:.0f} to {errors[-1]:.0f} m.",
    )
    return first, second


ONE_RECEIVER = Study(
    name="forward_scatter_one_receiver",
    title="One receiver with azimuth",
    summary="Three ways to the angular velocity with azimuth errors of 0.1 to 1 degree, at 15 and 30 km.",
    family=FAMILY,
    paper=Reference(PAPER, "eqs. (19), (20)"),
    item="equations (19), (20)",
    scenario=PRESET,
    scenario_parameters={"one_receiver": True},
    entries=tuple(StudyEntry(ANGLE, word, {"omega": word}) for word in ("slope", "ends", "regression")),
    sweep={"scenario.sigma_azimuth_deg": SIGMAS_DEG, "scenario.crossing_distance_m": DISTANCES_M},
    claims=(_ENDS, _REGRESSION),
    judge=_judge_one_receiver,
    trials=1000,
    seed=2014,
)

_FOUR_LINES = Claim("1", "two transmitters: the closed form of both pairs together", "not treated")
_FOUR_ML = Claim("1", "two transmitters: maximum likelihood of all four Dopplers", "not treated")


def _judge_four_dopplers(run: StudyRun) -> Sequence[Verdict]:
    out = []
    for claim, label in ((_FOUR_LINES, "closed form"), (_FOUR_ML, "likelihood")):
        two, four = (
            [run.metric(RMS, label, "t=16", transmitter_spacing_m=d, crossing_distance_m=s).value for s in DISTANCES_M]
            for d in (0.0, 300.0)
        )
        out.append(
            Verdict(
                claim,
                two[1] / four[1],
                "times",
                "shown",
                f"Just after the crossing its error falls from {two[0]:.0f} to {four[0]:.0f} m at 15 km, from "
                f"{two[1]:.0f} to {four[1]:.0f} m at 30 km.",
            )
        )
    return out


FOUR_DOPPLERS = Study(
    name="forward_scatter_four_dopplers",
    title="Two transmitters and two receivers",
    summary="One transmitter against two of them 300 m apart, at 15 and 30 km: the closed form and maximum likelihood.",
    family=FAMILY,
    paper=Reference(PAPER, "sec. 2"),
    item="section 2",
    scenario=PRESET,
    entries=(StudyEntry(LINES, "closed form"), StudyEntry(ML, "likelihood")),
    sweep={"scenario.transmitter_spacing_m": (0.0, 300.0), "scenario.crossing_distance_m": DISTANCES_M},
    claims=(_FOUR_LINES, _FOUR_ML),
    judge=_judge_four_dopplers,
    seed=2014,
)

_FALSE_LINES = Claim("2", "least squares on false Dopplers", "not treated")
_FALSE_ROBUST = Claim("2", "lines by consensus with three confirming windows on false Dopplers", "not treated")
_FALSE_ML = Claim("2", "the robust likelihood on false Dopplers", "not treated")
SHARES = (0.0, 0.05, 0.1, 0.2)


def _judge_false(run: StudyRun) -> Sequence[Verdict]:
    def median(label: str, share: float) -> float:
        return run.metric("median_crossing_distance_m", label, "t=16", false_share=share).value

    def lost(label: str, share: float) -> float:
        return 100 * run.metric("crossing_distance_over_5km_share", label, "t=16", false_share=share).value

    out = []
    for claim, label in (
        (_FALSE_LINES, "least squares"),
        (_FALSE_ROBUST, "consensus"),
        (_FALSE_ML, "robust likelihood"),
    ):
        out.append(
            Verdict(
                claim,
                lost(label, 0.1),
                "%",
                "shown",
                f"At 10 % false ones the median error is {median(label, 0.1):.0f} m against {median(label, 0):.0f} m "
                f"without; {lost(label, 0.1):.0f} % of the trials are lost.",
            )
        )
    return out


FALSE_VALUES = Study(
    name="forward_scatter_false_values",
    title="False Dopplers",
    summary="Up to one Doppler in five is anything within 100 Hz: least squares, Huber's lines, consensus, and the "
    "likelihood plain and robust, just after the crossing at 15 km.",
    family=FAMILY,
    paper=Reference(PAPER, "sec. 4"),
    item="section 4",
    scenario=PRESET,
    entries=(
        StudyEntry(LINES, "least squares", {"passes": "one"}),
        StudyEntry(LINES, "huber", {"passes": "one", "robust": "huber", "confirm": 3}),
        StudyEntry(LINES, "consensus", {"passes": "one", "robust": "consensus", "confirm": 3}),
        StudyEntry(ML, "plain likelihood", {"passes": "one"}),
        StudyEntry(ML, "robust likelihood", {"passes": "one", "robust": "consensus"}),
    ),
    sweep={"scenario.false_share": SHARES},
    claims=(_FALSE_LINES, _FALSE_ROBUST, _FALSE_ML),
    judge=_judge_false,
    seed=2014,
)
