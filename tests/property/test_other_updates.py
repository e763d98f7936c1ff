"""Iterated, unscented and cubature updates and raw times of arrival, each against an independent dense statement."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multilateration import raw_toa, rdf, rdfv
from algorithms.multilateration.parameters import Start
from algorithms.multilateration.raw_toa import RawToaParameters
from algorithms.multilateration.scenario import IncompleteParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack
from tests.oracles import dense_updates as dense
from tests.oracles.dense_filter import f_matrix, q_matrix

SD = (500.0, 50.0, 1.0)
PRIOR = np.kron(np.eye(3), np.diag(np.square(SD)))
MARKS, TRIAL = 60, 17
SIGMA_M = 299_792_458.0 * 10e-9


@pytest.fixture(scope="module")
def marks() -> ToaMarks:
    return simulate(IncompleteParameters(), tuple(range(20)), 3).take(np.arange(MARKS))


def start_of(recording: ToaMarks) -> np.ndarray:
    state = np.zeros(9)
    state[[0, 3, 6]] = recording.truth_m[0] + [300.0, -200.0, 100.0]
    state[[1, 4, 7]] = recording.truth_velocity_mps[0]
    return state


def article(recording: ToaMarks) -> dict[str, object]:
    return {"profile": "article", "start": Start(mode="given", state=tuple(start_of(recording)), sd=SD)}


def complete(recording: ToaMarks, k: int) -> bool:
    return bool(np.isfinite(recording.toa_s[k, :, TRIAL]).sum() >= 2)


@pytest.mark.parametrize("update", ["iekf", "ukf", "ckf"])
@pytest.mark.parametrize("altitude", [True, False])
def test_agrees_with_the_dense_statement(marks: ToaMarks, update: str, altitude: bool) -> None:
    module = rdfv if altitude else rdf
    given = article(marks) | {"update": update}
    arrays = module.run(marks, module.ALGORITHM.parameters(**given), LocalContext()).arrays
    assert marks.site is not None
    stations = marks.site.station_positions()
    x, p = start_of(marks), PRIOR.copy()
    for k in range(MARKS):
        if k:
            t = marks.time_s[k] - marks.time_s[k - 1]
            f = f_matrix(t)
            x, p = f @ x, f @ p @ f.T + q_matrix(t, 0.1, "paper")
        if not complete(marks, k):
            break
        m = dense.measured(
            marks.toa_s[k, :, TRIAL], marks.altitude_m[k, TRIAL] if altitude else np.nan, stations, SIGMA_M, 100.0
        )
        x, p = dense.iterated(x, p, m) if update == "iekf" else dense.over_points(x, p, m, unscented=update == "ukf")
        p = (p + p.T) / 2
        np.testing.assert_allclose(arrays["state"][k, :, TRIAL], x, rtol=1e-6, atol=1e-4)
        np.testing.assert_allclose(unpack(arrays["covariance"][k, :, TRIAL]), p, rtol=1e-4, atol=1e-5)
    assert k > 10


def test_raw_times_with_a_wide_prior_are_the_range_differences(marks: ToaMarks) -> None:
    given = article(marks)
    raw = raw_toa.run(marks, RawToaParameters(**given), LocalContext()).arrays
    differences = rdfv.run(marks, rdfv.RdfvParameters(**given), LocalContext()).arrays
    apart = np.linalg.norm(raw["state"][:, [0, 3, 6]] - differences["state"][:, [0, 3, 6]], axis=1)
    assert np.nanmax(apart) < 0.05
    np.testing.assert_array_equal(raw["dof"], differences["dof"])
    np.testing.assert_allclose(raw["nis"], differences["nis"], rtol=1e-3, atol=1e-3)


def test_raw_times_with_a_narrow_prior_agree_with_ten_states(marks: ToaMarks) -> None:
    given = article(marks) | {"altitude": "none", "emission_prior_m": 50.0}
    arrays = raw_toa.run(marks, RawToaParameters(**given), LocalContext()).arrays
    assert marks.site is not None
    x, p = start_of(marks), PRIOR.copy()
    for k in range(8):
        if k:
            t = marks.time_s[k] - marks.time_s[k - 1]
            f = f_matrix(t)
            x, p = f @ x, f @ p @ f.T + q_matrix(t, 0.1, "paper")
        x, p = dense.with_emission(x, p, marks.toa_s[k, :, TRIAL], marks.site.station_positions(), SIGMA_M, 50.0)
        np.testing.assert_allclose(arrays["state"][k, :, TRIAL], x, rtol=1e-6, atol=1e-4)
        np.testing.assert_allclose(unpack(arrays["covariance"][k, :, TRIAL]), p, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize("update", ["iekf", "ukf", "ckf"])
def test_in_the_robust_profile_they_start_and_follow_by_themselves(marks: ToaMarks, update: str) -> None:
    def error(update: str) -> float:
        result = rdfv.run(marks, rdfv.RdfvParameters(update=update), LocalContext())
        assert result.settings["update"].value == update
        off = np.hypot(*(result.arrays["state"][:, [0, 3]] - marks.truth_m[:, :2, None]).transpose(1, 0, 2))
        assert np.isfinite(off[-1]).all()
        return float(np.nanmedian(off[30:]))

    # Specification 6.3: they equal the extended filter where an altitude makes the place observable.
    assert error(update) == pytest.approx(error("ekf"), rel=0.1)


def test_the_printed_formulas_do_what_the_errata_say(marks: ToaMarks) -> None:
    """Specification E1: the error grows from mark to mark; E2: NIS of the altitude explodes."""

    def run(printed: str) -> tuple[np.ndarray, np.ndarray]:
        arrays = rdfv.run(marks, rdfv.RdfvParameters(**article(marks), printed=printed), LocalContext()).arrays
        off = np.hypot(*(arrays["state"][:, [0, 3]] - marks.truth_m[:, :2, None]).transpose(1, 0, 2))
        return off, arrays["nis"]

    right, nis = run("corrected")
    wrong_sign, _ = run("sign")
    assert (wrong_sign[1] > 1.5 * right[0]).all()
    assert np.nanmedian(wrong_sign[9]) > 1e4
    _, wrong_gradient = run("gradient")
    assert np.nanmedian(wrong_gradient[-10:]) > 2 * np.nanmedian(nis[-10:])
    assert np.nanmedian(wrong_gradient[5:10]) > 1.5 * np.nanmedian(nis[5:10])
    plain = rdfv.run(marks, rdfv.RdfvParameters(**article(marks)), LocalContext()).arrays["state"]
    np.testing.assert_array_equal(plain[:, 0], right_state(marks))


def right_state(marks: ToaMarks) -> np.ndarray:
    parameters = rdfv.RdfvParameters(**article(marks), printed="corrected")
    state: np.ndarray = rdfv.run(marks, parameters, LocalContext()).arrays["state"]
    return state[:, 0]
