"""Maximum likelihood over a window, against SciPy's own least squares on range differences; its statuses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from algorithms.multilateration import lanes, window_ml
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.multilateration.window_ml import WindowMlParameters
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack
from tests.oracles.dense_filter import C, sphere_altitude

SIGMA_M = C * 10e-9


@pytest.fixture(scope="module")
def marks() -> ToaMarks:
    return simulate(CircuitParameters(sigma_altitude_m=30.0, legs=()), (0, 1), 4).take(np.arange(380, 460))


def fitted(recording: ToaMarks, **chosen: object) -> Result:
    return window_ml.run(recording, WindowMlParameters(**chosen), LocalContext())


@pytest.mark.parametrize("altitude", ["white", "none"])
def test_agrees_with_general_least_squares(marks: ToaMarks, altitude: str) -> None:
    trial, last = 1, 18  # before the weave
    window = 12.5
    toa = marks.toa_s.copy()
    toa[10, 2] = np.nan
    some = replace(marks, toa_s=toa)
    arrays = fitted(some, window_s=window, altitude=altitude, manoeuvre="keep").arrays
    assert marks.site is not None
    stations = marks.site.station_positions()
    time = marks.time_s + np.nanmean(toa[:, :, trial], axis=1)
    rows = [k for k in range(last + 1) if time[last] - time[k] <= window]

    def residuals(theta: np.ndarray) -> np.ndarray:
        out = [theta[[1, 3, 5]] / 300.0]
        for k in rows:
            t = time[k] - time[last]
            p = theta[[0, 2, 4]] + t * theta[[1, 3, 5]]
            have = np.flatnonzero(np.isfinite(toa[k, :, trial]))
            n = len(have) - 1
            e = C * toa[k, have, trial] - np.linalg.norm(p - stations[have], axis=1)
            root = np.linalg.cholesky(SIGMA_M**2 * (np.eye(n) + np.ones((n, n))))
            out.append(np.linalg.solve(root, e[:-1] - e[-1]))
            if altitude == "white":
                out.append(np.array([(marks.altitude_m[k, trial] - sphere_altitude(p)[0]) / 30.0]))
        return np.concatenate(out)

    truth = np.stack([marks.truth_m[last], marks.truth_velocity_mps[last]], axis=1).ravel()
    solved = least_squares(residuals, truth, x_scale=np.tile([100.0, 10.0], 3), xtol=1e-14, ftol=1e-14, gtol=1e-14)
    state = arrays["state"][last, :, trial]
    np.testing.assert_allclose(state[[0, 3, 6]], solved.x[[0, 2, 4]], atol=0.1)
    np.testing.assert_allclose(state[[1, 4, 7]], solved.x[[1, 3, 5]], atol=0.05)
    covariance = np.linalg.inv(solved.jac.T @ solved.jac)[np.ix_([0, 2, 4], [0, 2, 4])]
    sd = np.sqrt(np.diag(covariance))
    off = unpack(arrays["covariance"][last, :, trial]) - covariance
    np.testing.assert_allclose(off / np.outer(sd, sd), 0.0, atol=2e-3)
    assert arrays["nis"][last, trial] == pytest.approx(2 * solved.cost, rel=1e-4)
    assert arrays["dof"][last, trial] == len(residuals(truth)) - 6


def test_the_window_is_shortened_where_flight_is_not_straight(marks: ToaMarks) -> None:
    def error(**chosen: object) -> np.ndarray:
        state = fitted(marks, window_s=40.0, **chosen).arrays["state"]
        return np.hypot(*(state[:, [0, 3]] - marks.truth_m[:, :2, None]).transpose(1, 0, 2)).max(axis=1)

    kept, shortened = error(manoeuvre="keep"), error(manoeuvre="shorten")
    assert kept[45] > 3 * shortened[45], "the weave begins with mark 20"
    np.testing.assert_allclose(kept[18], shortened[18])
    assert error(manoeuvre="keep", order=2)[45] < kept[45]


def test_statuses_of_gaps_and_of_marks_without_anything(marks: ToaMarks) -> None:
    toa, altitude = marks.toa_s.copy(), marks.altitude_m.copy()
    toa[0, :2] = np.nan  # two receptions and an altitude start nothing
    toa[30], altitude[30] = np.nan, np.nan
    time = marks.time_s.copy()
    time[60:] += 100.0
    arrays = fitted(replace(marks, toa_s=toa, altitude_m=altitude, time_s=time)).arrays
    words = [lanes.STATUS[i] for i in arrays["status"][:, 0]]
    assert words[0] == "not_initialised"
    assert words[1] == "initialised"
    assert words[30] == "coast"
    assert np.isfinite(arrays["state"][30, 0, 0])
    assert words[60] == "initialised", "a gap of 60 s ends the track"
    assert set(words) <= {"not_initialised", "initialised", "updated", "coast"}
