"""Scenarios of marks: each effect by itself, the presets of the specification, and what cannot be."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import ParameterError
from algorithms.multilateration.scenario import CircuitParameters, IncompleteParameters
from algorithms.toolbox.frames.earth import altitude_from_position, sphere
from algorithms.toolbox.scenario.mark_parameters import MarkScenario
from algorithms.toolbox.scenario.recording import legs_of, simulate

C = 299_792_458.0
STATIONS = [
    {"name": "W", "east_m": -8_000.0, "north_m": 0.0, "up_m": 0.0},
    {"name": "E", "east_m": 8_000.0, "north_m": 0.0, "up_m": 0.0},
    {"name": "N", "east_m": 0.0, "north_m": 9_000.0, "up_m": 50.0},
]
STRAIGHT = {
    "east_m": 0.0, "north_m": -20_000.0, "altitude_m": 4_000.0, "heading_deg": 90.0, "speed_mps": 100.0,
    "segments": [{"duration_s": 99}],
}  # fmt: skip


def scenario(**changes: Any) -> MarkScenario:
    return MarkScenario.model_validate(
        {"stations": STATIONS, "targets": [STRAIGHT], "sigma_toa_ns": 1e-6, "sigma_altitude_m": 0.0} | changes
    )


def offsets(**changes: Any) -> np.ndarray:
    """(M, S, 2): measured times of arrival less the flight time at the gate's opening, ns."""
    recording = simulate(scenario(**changes), (0, 1), 3)
    distance = np.linalg.norm(recording.truth_m[:, None] - recording.site.station_positions(), axis=2)
    return 1e9 * (recording.toa_s - distance[:, :, None] / C)


def test_without_noise_the_flight_times_remain() -> None:
    assert np.abs(offsets()).max() < 1e-4
    altitude = simulate(scenario(), (0,), 3).altitude_m
    np.testing.assert_allclose(altitude, 4_000.0)


def test_clock_errors_are_known_or_unknown_and_drift() -> None:
    unknown = {"clock_error_ns": -70.0, "clock_drift_ns_s": 2.0}
    stations = [STATIONS[0] | {"clock_offset_ns": 500.0}, STATIONS[1] | unknown, STATIONS[2]]
    found = offsets(stations=stations)[:, :, 0]
    time = np.arange(100.0)
    np.testing.assert_allclose(found[:, 0], 500.0, atol=1e-3)
    np.testing.assert_allclose(found[:, 1], 2.0 * time - 70.0, atol=1e-3)
    np.testing.assert_allclose(found[:, 2], 0.0, atol=1e-3)
    told = simulate(scenario(stations=stations), (0,), 3).site.stations
    assert [s.clock_offset_ns for s in told] == [500.0, 0.0, 0.0]


def test_emission_lies_in_the_gate_and_the_emitter_moves_on() -> None:
    found = offsets(gate_length_ms=10.0, emission_offset_ms=2.0, targets=[STRAIGHT | {"speed_mps": 10_000.0}])
    emission = found.mean(axis=1) / 1e6
    assert 1.9 < emission.min() < 2.5
    assert 11.5 < emission.max() < 12.1
    # Ahead of the target the flight is shorter, behind it longer: the stations differ by metres, not by kilometres.
    spread = np.ptp(found, axis=1) * 1e-9 * C
    assert 0.5 < spread.max() < 300
    assert simulate(scenario(gate_length_ms=10.0), (), 0).site.gate_length_s == 0.01


def test_outliers_are_late_by_what_was_said() -> None:
    found = offsets(outlier_share=0.25, outlier_least_ns=100, outlier_most_ns=300)
    late = found > 1
    assert 0.15 < late.mean() < 0.35
    assert found[late].min() > 99.9
    assert found[late].max() < 300.1


def test_receptions_by_time_and_station() -> None:
    p = scenario(receptions=[{"start_s": 20, "stop_s": 60, "probabilities": [1, 0, 0.5]}], reception_probability=0.9)
    toa = simulate(p, tuple(range(200)), 3).toa_s
    received = np.isfinite(toa).mean(axis=2)
    np.testing.assert_allclose(received[:20].mean(axis=0), 0.9, atol=0.02)
    np.testing.assert_allclose(received[20:60].mean(axis=0), [0.9, 0.0, 0.45], atol=0.02)


def test_altitude_bias_noise_step_and_decoding() -> None:
    p = scenario(sigma_altitude_m=20.0, altitude_bias_sd_m=300.0, decoding_probability=0.8, altitude_step_m=7.62)
    altitude = simulate(p, tuple(range(300)), 3).altitude_m
    assert np.isfinite(altitude).mean() == pytest.approx(0.8, abs=0.02)
    steps = altitude[np.isfinite(altitude)] / 7.62
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    of_trial = np.nanmean(altitude, axis=0) - 4_000
    assert of_trial.std() == pytest.approx(300, rel=0.2)
    assert np.nanstd(altitude - np.nanmean(altitude, axis=0)) == pytest.approx(20, rel=0.1)


def test_one_effect_leaves_the_draws_of_the_others() -> None:
    plain = simulate(scenario(sigma_toa_ns=10.0), (0, 1), 3)
    more = scenario(sigma_toa_ns=10.0, reception_probability=0.5, sigma_altitude_m=10.0, decoding_probability=0.5)
    other = simulate(more, (0, 1), 3)
    heard = np.isfinite(other.toa_s)
    assert 0.3 < heard.mean() < 0.7
    assert other.toa_s[heard].tobytes() == plain.toa_s[heard].tobytes()


def test_interrogators_make_bursts_and_gaps_are_empty() -> None:
    p = scenario(
        timing="interrogators",
        interrogators=[{"period_s": 10, "phase_s": 2, "replies": 5, "interval_s": 0.01, "reply_probability": 1}],
        gaps=[{"start_s": 40, "stop_s": 60}],
    )
    time = simulate(p, (), 0).time_s
    expected = [2 + 10 * k + 0.01 * i for k in (0, 1, 2, 3, 6, 7, 8, 9) for i in range(5)]
    np.testing.assert_allclose(time, expected)
    half = p.model_copy(update={"interrogators": (p.interrogators[0].model_copy(update={"reply_probability": 0.5}),)})
    assert set(simulate(half, (), 0).time_s) < set(time)


def test_a_further_target_leaves_the_instants_of_the_first() -> None:
    irregular = {"timing": "irregular", "timing_seed": 9}
    one = simulate(scenario(**irregular), (), 0)
    late = STRAIGHT | {"start_s": 30.0, "north_m": 5_000.0}
    two = simulate(scenario(**irregular, targets=[STRAIGHT, late]), (), 0)
    assert two.targets == ("1", "2")
    assert two.time_s[two.target == 0].tobytes() == one.time_s.tobytes()
    assert two.time_s[two.target == 1].min() > 30
    assert two.time_s.max() > 99 > one.time_s.max() - 1


def test_a_table_of_points_is_a_natural_cubic_in_time() -> None:
    points = [
        {"time_s": t, "east_m": 100.0 * t, "north_m": n, "altitude_m": 3_000.0}
        for t, n in ((0, 0.0), (10, 200.0), (25, 100.0), (40, 400.0))
    ]
    recording = simulate(scenario(targets=[{"points": points}], period_s=0.5), (), 0)
    truth, velocity, time = recording.truth_m, recording.truth_velocity_mps, recording.time_s
    for p in points:
        assert truth[time == p["time_s"], :2][0] == pytest.approx([p["east_m"], p["north_m"]], abs=1e-6)
    np.testing.assert_allclose(altitude_from_position(truth, sphere()), 3_000.0, atol=1e-6)
    np.testing.assert_allclose(velocity[:, 0], 100.0, rtol=1e-9)
    slope = np.gradient(truth[:, 1], time)
    np.testing.assert_allclose(velocity[2:-2, 1], slope[2:-2], atol=0.2)
    curvature = np.gradient(velocity[:, 1], time)
    assert abs(curvature[0]) < 0.3 * np.abs(curvature).max(), "no acceleration at the ends"
    high = [p | {"altitude_m": None, "up_m": 2_000.0} for p in points]
    flat = simulate(scenario(targets=[{"points": high}], period_s=10), (), 0)
    assert flat.truth_m[0, 2] == pytest.approx(2_000.0, abs=1e-6)


def test_an_origin_makes_the_earth_an_ellipsoid() -> None:
    origin = {"latitude_deg": 55.0, "longitude_deg": 37.0, "height_m": 150.0}
    round_, flat = simulate(scenario(), (), 0), simulate(scenario(origin=origin), (), 0)
    assert flat.site.origin is not None
    assert flat.truth_m[0, 2] == pytest.approx(round_.truth_m[0, 2] - 150, abs=1.0)


def test_presets_have_the_legs_of_the_specification() -> None:
    assert [(leg.name, leg.start_s, leg.stop_s) for leg in legs_of(CircuitParameters())] == [
        ("inbound", 50, 400), ("weave", 400, 520), ("turn", 560, 680), ("orbit", 720, 960), ("out_near", 960, 1200),
        ("out_far", 1200, 1900),
    ]  # fmt: skip
    assert [leg.name for leg in legs_of(IncompleteParameters())] == ["0-400", "400-700", "700-1000"]


def test_what_the_site_tells_the_filters() -> None:
    circuit = simulate(CircuitParameters(sigma_altitude_m=30.0), (0,), 0)
    assert circuit.site.sigma_altitude_m == 30.0
    assert np.std(circuit.altitude_m - 10_000) == pytest.approx(30, rel=0.1)
    incomplete = simulate(IncompleteParameters(), (), 0)
    assert incomplete.site.sigma_altitude_m == 100.0
    assert incomplete.site.gate_length_s == 0.012
    assert simulate(scenario(), (), 0).site.sigma_altitude_m is None


POINT = {"time_s": 0.0, "east_m": 0.0, "north_m": 0.0, "altitude_m": 100.0}


@pytest.mark.parametrize(
    ("changes", "pointer"),
    [
        ({"targets": [STRAIGHT | {"segments": [{"duration_s": 10}, {"duration_s": 100, "climb_rate_mps": -50}]}]},
         "/targets/0/segments/1/climb_rate_mps"),
        ({"targets": [STRAIGHT, STRAIGHT | {"segments": [{"duration_s": 30, "acceleration_mps2": 400}]}]},
         "/targets/1/segments/0/acceleration_mps2"),
        ({"targets": [STRAIGHT | {"east_m": 9e6}]}, "/targets/0"),
        ({"targets": [{"points": [POINT]}]}, "/targets/0/points"),
        ({"targets": [{"points": [POINT, POINT]}]}, "/targets/0/points/1/time_s"),
        ({"targets": [{"points": [POINT, POINT | {"time_s": 1e-3, "east_m": 1e6}]}]}, "/targets/0/points/0"),
        ({"targets": [{"points": [POINT, POINT | {"time_s": 9, "up_m": -900.0, "altitude_m": None}]}]},
         "/targets/0/points/0"),
        ({"targets": [STRAIGHT | {"name": "2"}, STRAIGHT]}, "/targets/1/name"),
        ({"period_s": 1e-5}, "/period_s"),
        ({"targets": [STRAIGHT] * 11, "period_s": 0.01}, "/targets"),
        ({"timing": "irregular", "minimum_interval_s": 0, "mean_extra_interval_s": 0}, "/minimum_interval_s"),
        ({"timing": "irregular", "minimum_interval_s": 0, "mean_extra_interval_s": 1e-5}, "/mean_extra_interval_s"),
        ({"timing": "interrogators", "interrogators": []}, "/timing"),
        ({"gaps": [{"start_s": 0, "stop_s": 1e6}]}, "/timing"),
        ({"gaps": [{"start_s": 9, "stop_s": 9}]}, "/gaps/0/stop_s"),
        ({"receptions": [{"probabilities": [1, 1]}]}, "/receptions/0/probabilities"),
        ({"receptions": [{"probabilities": [1, 1, 2]}]}, "/receptions/0/probabilities"),
        ({"receptions": [{"start_s": 5, "stop_s": 5, "probabilities": [1, 1, 1]}]}, "/receptions/0/stop_s"),
        ({"outlier_least_ns": 10, "outlier_most_ns": 5}, "/outlier_most_ns"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused_with_its_place(changes: dict[str, Any], pointer: str) -> None:
    with pytest.raises(ParameterError) as caught:
        simulate(scenario(**changes), (), 0)
    assert caught.value.pointer == pointer
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"targets": [STRAIGHT | {"segments": [{"duration_s": 0}]}]}, ("targets", 0, "segments", 0, "duration_s")),
        ({"targets": [STRAIGHT | {"speed_mps": 3.1e8}]}, ("targets", 0, "speed_mps")),
        ({"targets": [STRAIGHT | {"altitude_m": -1}]}, ("targets", 0, "altitude_m")),
        ({"targets": [STRAIGHT | {"points": [POINT]}]}, ("targets", 0)),
        ({"targets": []}, ("targets",)),
        ({"duration_s": 0}, ("duration_s",)),
        ({"stations": STATIONS[:1]}, ("stations",)),
        ({"stations": [STATIONS[0], STATIONS[0] | {"name": "again"}]}, ("stations",)),
        ({"stations": [*STATIONS, STATIONS[0]]}, ("stations",)),
        ({"sigma_toa_ns": float("nan")}, ("sigma_toa_ns",)),
        ({"sigma": 1}, ("sigma",)),
    ],
)
def test_values_out_of_their_bounds_are_refused(changes: dict[str, Any], place: tuple[Any, ...]) -> None:
    with pytest.raises(ValidationError) as caught:
        scenario(**changes)
    assert caught.value.errors()[0]["loc"] == place
