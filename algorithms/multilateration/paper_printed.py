"""What the article's misprints do, and two of its statements that a formula decides (specification 8.6, 9.4, 10)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from algorithms.multilateration.paper import ARTICLE, PAPER
from algorithms.multilateration.scenario import four_stations
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict
from algorithms.toolbox.bounds.accuracy_map import C_M_PER_NS, places_at, plan_bound
from algorithms.toolbox.frames.earth import sphere

_TRACK = Claim("2", "straight in on a low-GDOP azimuth, straight out on a high-GDOP one", "low, then high")
_CIRCLE = Claim("text", "68.3 % of the errors lie inside the DRMS circle", "68.3 %")
_SIGN = Claim("(19)", "the correction is subtracted", "minus")
_GRADIENT = Claim("(26)", "the altitude's derivative by z has z in its numerator", "z / r")
_VARIANCE = Claim("(13)", "all observations have one variance, the altitude too", "that of the times")
# sqrt(1 / 2) of both axes, and one axis alone: between these lies every ellipse.
CIRCULAR, FLAT = 1.0 - np.exp(-1.0), 0.6826894921370859


def _judge_sign(run: StudyRun) -> Sequence[Verdict]:
    time, printed = run.curve("rms_horizontal_m", "as printed")
    _, right = run.curve("rms_horizontal_m", "corrected")
    at = int(np.searchsorted(time, 10.0))
    return (
        Verdict(
            _SIGN, float(printed[at]), "m", "not",
            f"After ten marks the error is {printed[at] / 1e3:.0f} km with a minus, {right[at]:.0f} m with a plus: "
            "positive feedback.",
        ),
    )  # fmt: skip


def _judge_gradient(run: StudyRun) -> Sequence[Verdict]:
    printed = run.metric("rms_horizontal_m", "as printed", "out_far")
    right = run.metric("rms_horizontal_m", "corrected", "out_far")
    stations = four_stations(sigma_toa_ns=10.0, sigma_altitude_m=100.0)
    azimuth = np.radians([90.0, 30.0])
    places = places_at(1e5 * np.sin(azimuth), 1e5 * np.cos(azimuth), 10_000.0, sphere())
    low, high = plan_bound(places, stations.station_positions(), np.full(4, 10 * C_M_PER_NS), "known").drms_m
    return (
        Verdict(
            _GRADIENT, printed.value, "m", "not",
            f"On the last leg the error is {printed.value / 1e3:.0f} km as printed, {right.value:.0f} m with R + z.",
            printed.low, printed.high,
        ),
        Verdict(
            _TRACK, float(high / low), "times", "shown",
            f"At 100 km one mark has {low:.0f} m on azimuth 90 and {high:.0f} m on azimuth 30, the altitude known.",
        ),
        Verdict(
            _CIRCLE, float(CIRCULAR), "1", "not",
            "63.2 % of circular errors, 68.3 % of errors along one line only; every ellipse lies between.",
            float(CIRCULAR), FLAT,
        ),
    )  # fmt: skip


def _judge_variance(run: StudyRun) -> Sequence[Verdict]:
    printed = run.metric("rms_horizontal_m", "as printed", "turn")
    right = run.metric("rms_horizontal_m", "corrected", "turn")
    claims = run.metric("actual_over_claimed", "as printed", "turn")
    honest = run.metric("actual_over_claimed", "corrected", "turn")
    return (
        Verdict(
            _VARIANCE, claims.value, "times", "not",
            f"In the turn near the stations the error is {printed.value:.0f} m and {claims.value:.1f} times the claim "
            f"as printed, {right.value:.0f} m and {honest.value:.1f} times the claim with the altitude's own variance.",
            claims.low, claims.high,
        ),
    )  # fmt: skip


def _entries(printed: str) -> tuple[StudyEntry, ...]:
    return (
        StudyEntry("rdfv", "corrected", ARTICLE),
        StudyEntry("rdfv", "as printed", ARTICLE | {"printed": printed}),
    )


SIGN = Study(
    name="multilateration_printed_sign",
    title="The update with the sign as printed",
    summary="Equation (19) subtracts the correction: the first half minute of the track, with a minus and with a plus.",
    family="multilateration",
    paper=Reference(PAPER, "eq. (19)"),
    item="equation (19)",
    scenario="four_station_circuit",
    scenario_parameters={"duration_s": 20, "sigma_altitude_m": 100},
    entries=_entries("sign"),
    claims=(_SIGN,),
    judge=_judge_sign,
    trials=64,
    seed=42,
)

GRADIENT = Study(
    name="multilateration_printed_gradient",
    title="The altitude's gradient as printed, the geometry of the track, the DRMS circle",
    summary="Equation (26) has z in place of R + z. Beside it two statements that a formula decides: where the "
    "geometry is good, and how many errors lie inside the DRMS circle.",
    family="multilateration",
    paper=Reference(PAPER, "eq. (26)"),
    item="equation (26), figure 2",
    scenario="four_station_circuit",
    scenario_parameters={"sigma_altitude_m": 100},
    entries=_entries("gradient"),
    claims=(_GRADIENT, _TRACK, _CIRCLE),
    judge=_judge_gradient,
    trials=64,
    seed=42,
)

VARIANCE = Study(
    name="multilateration_printed_variance",
    title="The altitude's variance as printed",
    summary="Equation (13) gives the altitude the variance of the times of arrival: what becomes of an altitude that "
    "is 100 m uncertain and is taken for one of 3 m.",
    family="multilateration",
    paper=Reference(PAPER, "eq. (13)"),
    item="equation (13)",
    scenario="four_station_circuit",
    scenario_parameters={"sigma_altitude_m": 100},
    entries=_entries("variance"),
    claims=(_VARIANCE,),
    judge=_judge_variance,
    trials=64,
    seed=42,
)

STUDIES = (SIGN, GRADIENT, VARIANCE)
