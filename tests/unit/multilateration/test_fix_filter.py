"""The filter over one-mark solutions: a plain Kalman filter over `single_mark`, its gate, restart and lost marks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from algorithms.multilateration import fix_filter, single_mark
from algorithms.multilateration.lanes import STATUS
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels.symmetric import unpack

PARAMETERS = fix_filter.FixFilterParameters()
MARKS = 60


def marks(trials: tuple[int, ...] = (0,)) -> ToaMarks:
    return simulate(CircuitParameters(sigma_altitude_m=100.0), trials, 11).take(np.arange(600, 600 + MARKS))


def run(recording: ToaMarks) -> Result:
    return fix_filter.run(recording, PARAMETERS, LocalContext())


def statuses(result: Result, trial: int = 0) -> list[str]:
    return [STATUS[s] for s in result.arrays["status"][:, trial]]


def test_it_is_a_kalman_filter_over_the_fixes() -> None:
    """Written out for one trial, with the covariance updated in Joseph's form."""
    recording = marks()
    fixes = single_mark.run(recording, single_mark.SingleMarkParameters(), LocalContext()).arrays
    ours = run(recording).arrays
    h = np.zeros((3, 9))
    h[range(3), [0, 3, 6]] = 1.0
    x, p = np.zeros(9), np.diag(np.tile([0.0, 300.0**2, 10.0**2], 3))
    for k in range(MARKS):
        z, r = fixes["state"][k, [0, 3, 6], 0], unpack(fixes["covariance"][k, :, 0])
        if k == 0:
            x[[0, 3, 6]] = z
            p[np.ix_([0, 3, 6], [0, 3, 6])] = r
        else:
            t = fixes["time_s"][k, 0] - fixes["time_s"][k - 1, 0]
            f1 = np.array([[1, t, t * t / 2], [0, 1, t], [0, 0, 1]])
            q1 = 0.01 * np.array(
                [[t**5 / 20, t**4 / 8, t**3 / 6], [t**4 / 8, t**3 / 3, t**2 / 2], [t**3 / 6, t**2 / 2, t]]
            )
            f, q = np.kron(np.eye(3), f1), np.kron(np.eye(3), q1)
            x, p = f @ x, f @ p @ f.T + q
            s = h @ p @ h.T + r
            gain = p @ h.T @ np.linalg.inv(s)
            innovation = z - h @ x
            assert ours["nis"][k, 0] < fix_filter.GATE, "no fix of these is outside the gate"
            np.testing.assert_allclose(ours["nis"][k, 0], innovation @ np.linalg.solve(s, innovation), rtol=1e-6)
            x = x + gain @ innovation
            a = np.eye(9) - gain @ h
            p = a @ p @ a.T + gain @ r @ gain.T
        np.testing.assert_allclose(ours["state"][k, :, 0], x, rtol=1e-7, atol=1e-5)
        np.testing.assert_allclose(unpack(ours["covariance"][k, :, 0]), p, rtol=1e-6, atol=1e-6)


def test_incomplete_marks_are_lost_and_a_minute_ends_the_track() -> None:
    recording = marks()
    toa = recording.toa_s.copy()
    toa[20:30, 1:] = np.nan
    result = run(replace(recording, toa_s=toa))
    assert statuses(result)[19:31] == ["updated", *["coast"] * 10, "updated"]
    assert not result.arrays["used"][20:30].any()
    claimed = result.arrays["covariance"][:, 0, 0]
    assert (np.diff(claimed[19:30]) > 0).all(), "nothing but the prediction"
    far = recording.time_s.copy()
    far[40:] += 61.0
    again = run(replace(recording, time_s=far))
    assert statuses(again)[40] == "initialised"
    assert again.arrays["track"][[39, 40], 0].tolist() == [1, 2]


def test_a_wild_fix_is_left_out_and_five_in_a_row_are_the_target() -> None:
    recording = marks()
    late = recording.toa_s.copy()
    late[30, 0] += 3e-6
    result = run(replace(recording, toa_s=late))
    assert statuses(result)[29:32] == ["updated", "residual_gate", "updated"]
    late[30:, 0] += 3e-6
    late[30, 0] -= 3e-6
    assert statuses(run(replace(recording, toa_s=late)))[30:36] == [*["residual_gate"] * 4, "reinitialised", "updated"]


def test_trials_do_not_know_of_each_other() -> None:
    both, alone = marks((0, 1)), marks((1,))
    together, single = run(both).arrays, run(alone).arrays
    np.testing.assert_array_equal(together["state"][:, :, 1], single["state"][:, :, 0])
    np.testing.assert_array_equal(together["status"][:, 1], single["status"][:, 0])
