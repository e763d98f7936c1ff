"""Trajectories from segments: the checkpoints of specification 7.1, arcs against integration, bad segments."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from algorithms.errors import ParameterError
from algorithms.multilateration.scenario import (
    CircuitParameters,
    IncompleteParameters,
    simulate,
)
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.scenario.trajectory import Segment, fly

EARTH = earths.sphere()


def test_circuit_checkpoints() -> None:
    truth = simulate(CircuitParameters(), (0,), 0).truth_m
    for t, x, y in (
        (0, 130_766.152, 0), (400, 50_766.152, 0), (520, 27_847.840, 0), (560, 19_847.840, 0),
        (680, 9_923.920, 17_188.734), (720, 13_923.920, 24_116.937), (960, 13_923.920, 24_116.937),
        (1899, 107_823.920, 186_756.508),
    ):  # fmt: skip
        assert truth[t, :2] == pytest.approx((x, y), abs=6e-4), t
    assert truth[1899, 2] == pytest.approx(6_355.017, abs=6e-4)


def test_incomplete_marks_are_the_specifications_own() -> None:
    recording = simulate(IncompleteParameters(), tuple(range(40)), 1)
    assert len(recording) == 1022
    assert recording.time_s[0] == pytest.approx(1.80265468, abs=1e-8)
    assert np.diff(recording.time_s).max() == pytest.approx(4.211, abs=1e-3)
    complete = np.isfinite(recording.toa_s).all(axis=1)
    early = recording.time_s < 400
    assert 0.29 < complete[early].mean() < 0.33, "31-32 % of the marks are complete before 400 s"
    assert complete[~early].mean() < 0.01
    assert np.nanmax(np.abs(recording.altitude_m / 30.48 - np.round(recording.altitude_m / 30.48))) < 1e-9


def test_an_accelerating_climbing_turn_against_integration() -> None:
    segment = Segment(duration_s=60, turn_rate_deg_s=2.0, climb_rate_mps=8.0, acceleration_mps2=1.5)
    times = np.linspace(0, 60, 7)
    got = fly(
        times, [segment], east_m=20_000, north_m=-5_000, altitude_m=3_000, heading_deg=40, speed_mps=120, earth=EARTH
    )

    def derivative(t: float, _: np.ndarray) -> list[float]:
        psi, v = np.radians(40 + 2.0 * t), 120 + 1.5 * t
        return [v * np.sin(psi), v * np.cos(psi)]

    plan = solve_ivp(derivative, (0, 60), [20_000, -5_000], t_eval=times, rtol=1e-11, atol=1e-8).y.T
    np.testing.assert_allclose(got.position_m[:, :2], plan, atol=1e-5)
    np.testing.assert_allclose(got.altitude_m, 3_000 + 8 * times)
    dt = 1e-3
    near = fly(
        times[1:-1] + dt, [segment], east_m=20_000, north_m=-5_000, altitude_m=3_000, heading_deg=40, speed_mps=120,
        earth=EARTH,
    )  # fmt: skip
    slope = (near.position_m - got.position_m[1:-1]) / dt
    np.testing.assert_allclose(got.velocity_mps[1:-1], slope, atol=5e-3)


@pytest.mark.parametrize(
    ("segments", "times", "pointer"),
    [
        ([Segment(duration_s=10)], [0.0, 11.0], "/segments"),
        ([Segment(duration_s=10, acceleration_mps2=-50)], [0.0], "/segments/0/acceleration_mps2"),
        ([Segment(duration_s=10), Segment(duration_s=100, climb_rate_mps=-50)], [0.0], "/segments/1/climb_rate_mps"),
    ],
)
def test_impossible_segments(segments: list[Segment], times: list[float], pointer: str) -> None:
    with pytest.raises(ParameterError) as caught:
        fly(np.array(times), segments, east_m=0, north_m=0, altitude_m=1_000, heading_deg=0, speed_mps=100, earth=EARTH)
    assert caught.value.pointer == pointer
    assert caught.value.remedy
