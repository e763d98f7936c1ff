"""What the article's misprints do, and two of its statements that a formula decides (specification 8.6, 9.4, 10)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.paper import ARTICLE, PAPER
from algorithms.multilateration.scenario import four_stations
from algorithms.spec import Reference
from algorithms.studies import Claim, Study, StudyEntry, StudyRun, Verdict
from algorithms.toolbox.bounds.accuracy_map import C_M_PER_NS, places_at, plan_bound
from algorithms.toolbox.frames.earth import sphere, up_from_position, z_from_altitude

Floats = NDArray[np.float64]

_TRACK = Claim("2", "straight in on a low-GDOP azimuth, straight out on a high-GDOP one", "low, then high")
_CIRCLE = Claim("text", "68.3 % of the errors lie inside the DRMS circle", "68.3 %")
_SIGN = Claim("(19)", "the correction is subtracted", "minus")
_GRADIENT = Claim("(26)", "the altitude's derivative by z has z in its numerator", "z / r")
_VARIANCE = Claim("(13)", "all observations have one variance, the altitude too", "that of the times")
_UNITS = Claim("(8), (13), (17)", "seconds and metres stand in one covariance", "s^2, m^2")
_SHARED = Claim("(13)", "range differences share the error of the last arrival", "off the diagonal")
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
        _judge_units(),
        _judge_shared(),
    )  # fmt: skip


def _at_100_km() -> tuple[Floats, Floats]:
    """Derivatives (4, 3) of 3 range differences against the last of four stations and of the altitude, and V (4, 4)."""
    stations = four_stations(sigma_toa_ns=10.0, sigma_altitude_m=100.0).station_positions()
    x, y = np.array(1e5), np.array(0.0)
    place = np.stack([x, y, z_from_altitude(x, y, np.array(10_000.0), sphere())])
    u = (place - stations) / np.linalg.norm(place - stations, axis=1)[:, None]
    noise = np.zeros((4, 4))
    noise[:3, :3] = (10 * C_M_PER_NS) ** 2 * (np.eye(3) + 1.0)
    noise[3, 3] = 100.0**2
    return np.vstack([u[3] - u[:3], up_from_position(place, sphere())]), noise


def _judge_units() -> Verdict:
    """One update of a position known to 400 m, its true place 150 m east, 140 m south and 30 m above (erratum E5)."""
    to, noise = _at_100_km()
    cross = 400.0**2 * to.T
    innovation = to @ np.array([150.0, -140.0, 30.0])
    metres = to @ cross + noise
    scale = np.array([1e-9 / C_M_PER_NS] * 3 + [1.0])
    mixed = metres * np.outer(scale, scale)
    right, inverse, pseudo = (
        (cross @ (k * (inverted @ (k * innovation))))[:2]
        for k, inverted in (
            (np.ones(4), np.linalg.inv(metres)),
            (scale, np.linalg.inv(mixed)),
            (scale, np.linalg.pinv(mixed)),
        )
    )
    whole, lost = float(np.hypot(*right)), float(np.hypot(*(right - pseudo)))
    off = float(np.hypot(*(right - inverse)))
    condition, in_metres = (np.log10(np.linalg.cond(matrix)) for matrix in (mixed, metres))
    return Verdict(
        _UNITS, lost, "m", "shown" if off < 1.0 and lost > 0.5 * whole else "not",
        f"The condition is 10^{condition:.0f}, in metres 10^{in_metres:.0f}. An inverse is {off:.3f} m off, yet "
        f"a pseudo-inverse drops every time of arrival and with them {lost:.0f} m of a correction of {whole:.0f} m.",
    )  # fmt: skip


def _judge_shared() -> Verdict:
    """One mark by least squares, weighted by the diagonal of V, against the last station and the first (trap T2)."""
    to, noise = _at_100_km()
    against_first = np.array([[-1.0, 0, 0, 0], [-1, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1]])
    numbers = []
    for turn in (np.eye(4), against_first):
        a, v = turn @ to, turn @ noise @ turn.T
        weight = np.diag(1.0 / np.diag(v))
        claim = np.linalg.inv(a.T @ weight @ a)
        gain = claim @ a.T @ weight
        best = np.linalg.inv(a.T @ np.linalg.inv(v) @ a)
        numbers.append([float(np.sqrt(np.trace(c[:2, :2]))) for c in (claim, gain @ v @ gain.T, best)])
    (claimed, error, right), (claimed_first, error_first, _) = numbers
    return Verdict(
        _SHARED, error / claimed, "times", "shown" if error > max(claimed, right) else "not",
        f"Without it one mark at 100 km claims {claimed:.0f} m and errs by {error:.0f} m against the last station, "
        f"{claimed_first:.0f} m and {error_first:.0f} m against the first; with it {right:.0f} m against any.",
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
    "is 100 m uncertain and is taken for one of 3 m. Beside it two things about the covariance that a formula decides: "
    "seconds and metres in it, and what range differences have in common.",
    family="multilateration",
    paper=Reference(PAPER, "eq. (13)"),
    item="equation (13)",
    scenario="four_station_circuit",
    scenario_parameters={"sigma_altitude_m": 100},
    entries=_entries("variance"),
    claims=(_VARIANCE, _UNITS, _SHARED),
    judge=_judge_variance,
    trials=64,
    seed=42,
)

STUDIES = (SIGN, GRADIENT, VARIANCE)
