"""The filter of two interacting models on marks against a dense one, and what must not matter to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration import mlat_imm
from algorithms.multilateration.lanes import REASON_CODES, STATUS
from algorithms.multilateration.mlat_imm import MlatImmParameters
from algorithms.multilateration.parameters import Start
from algorithms.multilateration.scenario import CircuitParameters, IncompleteParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack
from tests.oracles.dense_filter import C, DenseFilter
from tests.oracles.dense_interacting import DenseInteracting

SD = (500.0, 30.0, 1.0)


def run(recording: ToaMarks, **changes: object) -> Result:
    return mlat_imm.run(recording, MlatImmParameters(**changes), LocalContext())


def given(recording: ToaMarks) -> Start:
    state = np.zeros(9)
    state[[0, 3, 6]] = recording.truth_m[0] + [300.0, -200.0, 100.0]
    state[[1, 4, 7]] = recording.truth_velocity_mps[0]
    return Start(mode="given", state=tuple(state), sd=SD)


def lane(recording: ToaMarks, i: int) -> ToaMarks:
    """One trial alone."""
    return replace(recording, toa_s=recording.toa_s[:, :, i : i + 1], altitude_m=recording.altitude_m[:, i : i + 1])


@pytest.fixture(scope="module")
def circuit() -> ToaMarks:
    """Straight flight and the beginning of the weave, seventeen trials: the last stands in a padded block."""
    recording = simulate(CircuitParameters(duration_s=440.0, sigma_altitude_m=30.0, legs=()), tuple(range(17)), 3)
    return recording.take(np.flatnonzero(recording.time_s >= 350.0))


@pytest.mark.parametrize("bias_m", [0.0, 150.0])
def test_agrees_with_the_dense_filter(circuit: ToaMarks, bias_m: float) -> None:
    start = given(circuit)
    toa = circuit.toa_s.copy()
    toa[5, 1], toa[9, 0], toa[20:25, 2] = np.nan, np.nan, np.nan
    altitude = circuit.altitude_m.copy()
    altitude[12:15] = np.nan
    marks = replace(circuit, toa_s=toa, altitude_m=altitude)
    chosen = {"altitude": "bias_state", "sigma_altitude_bias_m": bias_m} if bias_m else {"altitude": "white"}
    result = run(marks, start=start, sigma_altitude_m=30.0, gate_probability=1 - 1e-12, **chosen)
    trial = 16
    total = float(np.hypot(30.0, bias_m))
    assert marks.site is not None
    stations = marks.site.station_positions()
    single = DenseFilter(stations, 10e-9, total, 0.5, "white", np.array(start.state), np.diag(np.tile(SD, 3)) ** 2)
    dense = DenseInteracting(stations, 10e-9, 30.0, bias_m, 0.05, 0.5)
    time, x = marks.time_s[0], single.x
    for k in range(len(marks)):
        ahead = marks.time_s[k] - time
        place = x[[0, 3, 6]] + ahead * x[[1, 4, 7]] + ahead**2 / 2 * x[[2, 5, 8]]
        received = np.isfinite(toa[k, :, trial])
        ranges = np.linalg.norm(place - stations, axis=1)
        step = max(ahead + np.mean(toa[k, received, trial] - ranges[received] / C), 0.0)
        if k == 0:
            single.predict(step)
            single.update(toa[k, :, trial], altitude[k, trial])
            dense.take_over(single, altitude[k, trial])
        else:
            dense.predict(step)
            dense.update(toa[k, :, trial], altitude[k, trial])
        time += step
        # The mark that began the track is still the single filter's.
        x, p = dense.shown() if k else dense.merged()
        np.testing.assert_allclose(result.arrays["state"][k, :, trial], x[:9], rtol=1e-6, atol=1e-6, err_msg=str(k))
        ours = unpack(result.arrays["covariance"][k, :, trial])
        scale = np.sqrt(np.outer(np.diag(p)[:9], np.diag(p)[:9]))
        np.testing.assert_allclose(ours / scale, p[:9, :9] / scale, atol=2e-6, err_msg=str(k))
        if k:
            np.testing.assert_allclose(result.arrays["mode_probability"][k, :, trial], dense.weight, atol=1e-6)
            assert result.arrays["altitude_bias_m"][k, trial] == pytest.approx(x[9], abs=1e-5)
            assert result.arrays["altitude_bias_sd_m"][k, trial] == pytest.approx(np.sqrt(p[9, 9]), abs=1e-5)
    assert dense.weight[1] > 0.5, "in the weave the manoeuvre is the more probable model"


def test_the_manoeuvre_is_recognised_and_the_straight_flight_too(circuit: ToaMarks) -> None:
    result = run(circuit, start=given(circuit), sigma_altitude_m=30.0)
    manoeuvre = result.arrays["mode_probability"][:, 1].mean(axis=1)
    time = circuit.time_s
    assert manoeuvre[(time > 380) & (time < 400)].max() < 0.3
    assert manoeuvre[(time > 415) & (time < 430)].min() > 0.7


def test_a_late_reception_is_left_out_and_named(circuit: ToaMarks) -> None:
    toa = circuit.toa_s.copy()
    toa[40, 1, :] += 1e-6
    late = run(replace(circuit, toa_s=toa), start=given(circuit), sigma_altitude_m=30.0)
    without = toa.copy()
    without[40, 1, :] = np.nan
    gone = run(replace(circuit, toa_s=without), start=given(circuit), sigma_altitude_m=30.0)
    codes = np.array(REASON_CODES)[late.arrays["reason"][40]]
    assert set(codes) == {"reception_left_out"}
    assert not late.arrays["used"][40, 1].any()
    assert late.arrays["used"][40, [0, 2, 3]].all()
    np.testing.assert_allclose(late.arrays["state"], gone.arrays["state"], rtol=1e-6, atol=1e-5)
    one = lane(replace(circuit, toa_s=toa), 0)
    decisions = mlat_imm.tabulate(one, run(one, start=given(circuit), sigma_altitude_m=30.0))["decisions"].columns
    (reason,) = (r for r in decisions["reason"] if "left out" in r)
    assert reason.endswith("station 2")


def test_a_wild_altitude_is_left_out(circuit: ToaMarks) -> None:
    altitude = circuit.altitude_m.copy()
    altitude[40] += 5000.0
    result = run(replace(circuit, altitude_m=altitude), start=given(circuit), sigma_altitude_m=30.0)
    assert set(np.array(REASON_CODES)[result.arrays["reason"][40]]) == {"altitude_left_out"}
    assert not result.arrays["altitude_used"][40].any()
    assert result.arrays["altitude_used"][41].all()


def test_two_late_receptions_are_nobody_s_fault_alone(circuit: ToaMarks) -> None:
    toa = circuit.toa_s.copy()
    toa[40, 1] += 1e-6
    toa[40, 0] -= 0.8e-6
    result = run(replace(circuit, toa_s=toa), start=given(circuit), sigma_altitude_m=30.0)
    assert set(np.array(STATUS)[result.arrays["status"][40]]) == {"downweighted"}
    error = np.linalg.norm(result.arrays["state"][41, [0, 3, 6]] - circuit.truth_m[41][:, None], axis=0)
    assert error.max() < 600


@pytest.mark.parametrize("turn", ["stations", "place"])
def test_what_must_not_matter(circuit: ToaMarks, turn: str) -> None:
    """The order of the stations, and a lane's place in the block."""
    start = given(circuit)
    plain = run(circuit, start=start, sigma_altitude_m=30.0)
    if turn == "place":
        alone = run(lane(circuit, 5), start=start, sigma_altitude_m=30.0)
        for name in ("state", "covariance", "mode_probability"):
            assert np.array_equal(alone.arrays[name][..., 0], plain.arrays[name][..., 5]), name
        return
    order = [2, 0, 3, 1]
    assert circuit.site is not None
    site = circuit.site.model_copy(update={"stations": tuple(circuit.site.stations[i] for i in order)})
    turned = replace(
        circuit, toa_s=circuit.toa_s[:, order], stations=tuple(circuit.stations[i] for i in order), site=site
    )
    other = run(turned, start=start, sigma_altitude_m=30.0)
    np.testing.assert_allclose(other.arrays["state"], plain.arrays["state"], rtol=1e-6, atol=1e-5)


def test_a_start_from_nothing(circuit: ToaMarks) -> None:
    """Incomplete marks, no start given: tracks begin by themselves and stay within what they claim."""
    recording = simulate(IncompleteParameters(), tuple(range(8)), 4)
    result = run(recording)
    error = np.hypot(*(result.arrays["state"][:, [0, 3]] - recording.truth_m[:, :2, None]).transpose(1, 0, 2))
    assert np.nanmax(error[50:]) < 2000
    assert np.isfinite(error[50:]).mean() > 0.999
