"""Bad input and edge cases of specification 17: a clear error, or a listed decision; never a silent repair."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import ParameterError
from algorithms.multiple_model import multiple_model, states
from algorithms.multiple_model.multiple_model import MultipleModelParameters
from algorithms.multiple_model.scenario import AeroballisticParameters, StraightParameters, simulate
from algorithms.multiple_model.soundness import indefinite
from algorithms.recording import AntennaPlots
from algorithms.result import Result
from algorithms.spec import LocalContext

TWO = ({"kind": "cv", "sigma_mps2": 1.0}, {"kind": "ca", "sigma_mps2": 5.0})


@pytest.fixture(scope="module")
def arc() -> AntennaPlots:
    """Two trials of the arc, 60 s at 1 Hz."""
    return simulate(AeroballisticParameters(rate_hz=1.0, duration_s=60.0), (0, 1), 5)


def run(recording: AntennaPlots, **parameters: Any) -> Result:
    return multiple_model.run(recording, MultipleModelParameters(**parameters), LocalContext())


def finite(result: Result, rows: slice = slice(None)) -> None:
    """Everything of the rows is a number, variances are not negative, probabilities sum to one."""
    state, p = result.arrays["state"][rows], result.arrays["mode_probability"][rows]
    assert np.isfinite(state).all()
    assert (result.arrays["covariance"][rows][:, range(9), range(9)] >= 0).all()
    np.testing.assert_allclose(p.sum(axis=1), 1, atol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "code", "words"),
    [
        (((0.9, 0.2), (0.1, 0.9)), "transition_sum", "Row 1 of the transition matrix sums to 1.1, not to 1"),
        (((0.9, 0.2), (0.1, 0.8)), "transition_transposed", "Row 1"),
        (((0.9, 0.1), (0.1, 0.8)), "transition_sum", "Row 2 of the transition matrix sums to 0.9"),
        (((1.1, -0.1), (0.1, 0.9)), "transition_entry", "from model 1 to model 1 is 1.1"),
        (((0.9, 0.1),), "transition_size", "1x2 for 2 models"),
        (((0.9, 0.1, 0.0), (0.1, 0.9, 0.0)), "transition_size", "2x3 for 2 models"),
        (((float("nan"), 1.0), (0.1, 0.9)), "transition_entry", "nan"),
    ],
)
def test_a_matrix_that_is_none_is_named(arc: AntennaPlots, matrix: Any, code: str, words: str) -> None:
    with pytest.raises((ParameterError, ValidationError)) as caught:
        run(arc, models=TWO, transition=matrix)
    if isinstance(caught.value, ParameterError):
        assert caught.value.code == code
        assert words in str(caught.value)
        assert str(caught.value.pointer).startswith("/transition")
    else:
        assert "nan" in words, caught.value


@pytest.mark.parametrize(
    "wrong",
    [
        {"models": ()},
        {"models": TWO * 6},
        {"models": ({"kind": "jerk", "sigma_mps2": 1.0},)},
        {"models": ({"kind": "ca", "sigma_mps2": -1.0},)},
        {"models": ({"kind": "ca", "sigma_mps2": float("inf")},)},
        {"transition_step_s": 0.0},
        {"transition_step_s": -1.0},
        {"sigma_range_m": 0.0},
        {"start_velocity_sd_mps": float("nan")},
    ],
)
def test_what_is_no_model_set_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        MultipleModelParameters(**wrong)


def test_no_noise_at_all_is_legal(arc: AntennaPlots) -> None:
    quiet = tuple({**m, "sigma_mps2": 0.0} for m in TWO)
    finite(run(arc, models=quiet, transition=((0.9, 0.1), (0.1, 0.9)), transition_step_s=1.0))


def test_ten_models_and_a_bank_that_never_changes(arc: AntennaPlots) -> None:
    ten = tuple({"kind": "ca", "sigma_mps2": float(s)} for s in np.geomspace(0.05, 50, 10))
    finite(run(arc, models=ten, transition=tuple(map(tuple, np.full((10, 10), 0.1)))))
    finite(run(arc, models=TWO, transition=((1.0, 0.0), (0.0, 1.0))))


def test_a_repeated_time_is_refused_and_listed(arc: AntennaPlots) -> None:
    time = arc.time_s.copy()
    time[20] = time[19]
    twice = run(replace(arc, time_s=time))
    assert (twice.arrays["status"][20] == states.REJECTED).all()
    assert (twice.arrays["reason"][20] == states.R_EQUAL).all()
    # The track is what it would have been without the row.
    missing = arc.range_m.copy()
    missing[20] = np.nan
    np.testing.assert_array_equal(twice.arrays["state"][21:], run(replace(arc, range_m=missing)).arrays["state"][21:])
    codes = [code for code in multiple_model.tabulate(arc, twice)["decisions"].columns["code"] if code]
    assert codes.count("equal_time") == 2


@pytest.mark.parametrize("wrong", [0.0, -5.0, np.nan, np.inf])
def test_a_range_that_is_none_is_a_miss_and_listed(arc: AntennaPlots, wrong: float) -> None:
    z = arc.range_m.copy()
    z[30] = wrong
    result = run(replace(arc, range_m=z))
    assert (result.arrays["reason"][30] == states.R_DOMAIN).all()
    assert (result.arrays["status"][30] == states.COASTING).all()
    assert any(note.code == "outside_domain" for note in result.notes)
    finite(result)


def test_what_a_simulation_cannot_measure_is_a_miss() -> None:
    """A straight flight past the antenna: behind it, or beyond the edge by noise, is no measurement; truth goes on."""
    past = simulate(StraightParameters(rate_hz=1.0, duration_s=600.0), (0,), 5)
    behind = np.isnan(past.range_m[:, 0])
    assert 0 < behind.sum() < behind.size
    assert np.isfinite(past.truth_m).all()
    result = run(past)
    missed = result.arrays["reason"] == states.R_DOMAIN
    assert missed[behind].all()
    assert not missed[past.time_s < 300].any()
    (note,) = (note for note in result.notes if note.code == "outside_domain")
    assert note.count == missed.sum()


def test_a_covariance_that_is_none_is_counted_and_stays() -> None:
    """A variance of 1e4 beside -1e-3: below -1e-9 of the largest eigenvalue. -1e-7 there would be rounding."""
    report = states.new_report(3, 1, 1)
    for row, last in enumerate((0.0, -1e-7, -1e-3)):
        report.covariance[row, :, 0] = 0.0
        report.covariance[row, 0, 0], report.covariance[row, 44, 0] = 1e4, last
    before = report.covariance.copy()
    (note,) = indefinite(report)
    assert (note.code, note.count) == ("covariance_indefinite", 1)
    np.testing.assert_array_equal(report.covariance, before)


def test_angles_outside_the_half_space_are_a_miss(arc: AntennaPlots) -> None:
    e, a = arc.bicone_elevation_rad.copy(), arc.bicone_azimuth_rad.copy()
    e[25] = np.radians(91)
    e[26], a[26] = np.radians(50), np.radians(50)
    result = run(replace(arc, bicone_elevation_rad=e, bicone_azimuth_rad=a))
    assert (result.arrays["reason"][[25, 26]] == states.R_DOMAIN).all()
    finite(result)


def test_a_gap_of_hours_closes_the_track(arc: AntennaPlots) -> None:
    time = arc.time_s.copy()
    time[30:] += 3 * 3600
    result = run(replace(arc, time_s=time))
    assert (result.arrays["track"][29] == 1).all()
    assert (result.arrays["track"][30] == 2).all()
    assert (result.arrays["reason"][30] == states.R_GAP).all()
    finite(result)
    # Where nobody closes it, variances of 1e20 may lose their meaning: then it starts anew, and that is listed too.
    kept = run(replace(arc, time_s=time), track_timeout_s=1e5)
    finite(kept)
    assert np.isin(kept.arrays["reason"][30], (states.R_RATE, states.R_UNUSUAL, states.R_RESTARTED)).all()


def test_one_wild_measurement_is_marked_and_survived(arc: AntennaPlots) -> None:
    z = arc.range_m.copy()
    z[40] += 3000.0
    result = run(replace(arc, range_m=z))
    assert (result.arrays["status"][40] == states.UNUSUAL).all()
    finite(result)
    plain = run(arc).arrays["state"][-1, [0, 3, 6]]
    assert np.abs(result.arrays["state"][-1, [0, 3, 6]] - plain).max() < 500
    # A gate refuses it, and says so.
    gated = run(replace(arc, range_m=z), association="nearest")
    assert (gated.arrays["status"][40] == states.OUTSIDE_GATE).all()
    np.testing.assert_allclose(gated.arrays["state"][-1, [0, 3, 6]], plain, rtol=0, atol=60)
