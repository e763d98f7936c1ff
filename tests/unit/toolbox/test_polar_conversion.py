"""Conversions of range and azimuth against the specification's worked numbers and against quadrature."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from algorithms.errors import ParameterError
from algorithms.toolbox.frames.polar_conversion import (
    CONVERSIONS,
    ConversionName,
    Prediction,
    angle_from_compass,
    cartesian_from_polar,
    nonlinearity_index,
    polar_statistic,
    wrapped,
)

Floats = np.ndarray

MEASURED = (120_000.0, np.radians(30.0), 80.0, np.radians(0.8))
PREDICTION = Prediction(120_500.0, np.radians(30.3), 100.0**2, np.radians(0.4) ** 2)
# Worked example 1: x, y, xx, yy, xy.
WORKED: dict[ConversionName, tuple[float, ...]] = {
    "lin": (103923.048454, 60000.0, 706638.535189, 2107115.605566, -1212848.720364),
    "paper": (103912.918287, 59994.151346, 706979.512065, 2106502.239992, -1212022.235558),
    "paper_literal": (103912.918287, 59994.151346, 706979.512065, 2106502.239992, 1217323.670878),
    "dcm": (103933.177140, 60005.847799, 706979.512065, 2106502.239992, -1212022.235558),
    "ucm": (103933.179115, 60005.848940, 707116.783854, 2106911.028756, -1212257.376156),
    "mucm": (103912.918781, 59994.151631, 706706.302745, 2106774.201720, -1212494.367535),
    "ducm": (103933.179115, 60005.848940, 725619.167080, 2111857.485083, -1230088.341406),
}
NODES, WEIGHTS = np.polynomial.hermite_e.hermegauss(24)
WEIGHTS = WEIGHTS / WEIGHTS.sum()


def converted(name: ConversionName, r: float, b: float, sr: float, sb: float) -> tuple[Floats, Floats]:
    found = cartesian_from_polar(r, b, sr, sb, name, PREDICTION if name == "ducm" else None)
    return found.point, found.covariance


def plane(r: Floats, b: Floats) -> Floats:
    return np.stack([r * np.cos(b), r * np.sin(b)], axis=-1)


def mean_of(function: Callable[[Floats, Floats], Floats], sr: float, sb: float) -> Floats:
    """Mean of a function of the errors of range and azimuth."""
    er, eb = np.meshgrid(sr * NODES, sb * NODES, indexing="ij")
    values = function(er, eb)
    return np.tensordot(WEIGHTS[:, None] * WEIGHTS, values, axes=2)


def outer(x: Floats) -> Floats:
    return x[..., :, None] * x[..., None, :]


@pytest.mark.parametrize("name", CONVERSIONS)
def test_the_worked_example(name: ConversionName) -> None:
    z, p = converted(name, *MEASURED)
    assert (*z, p[0, 0], p[1, 1], p[0, 1]) == pytest.approx(WORKED[name], abs=1.1e-6)
    assert p[0, 1] == p[1, 0]


@pytest.mark.parametrize("sigma_deg", [0.05, 0.8, 4.0])
@pytest.mark.parametrize("azimuth", [0.3, 2.0, -2.9])
def test_mucm_is_mean_and_covariance_given_the_measurement(azimuth: float, sigma_deg: float) -> None:
    r, sr, sb = 90_000.0, 120.0, np.radians(sigma_deg)
    z, p = converted("mucm", r, azimuth, sr, sb)
    mean = mean_of(lambda er, eb: plane(r - er, azimuth - eb), sr, sb)
    spread = mean_of(lambda er, eb: outer(plane(r - er, azimuth - eb) - mean), sr, sb)
    assert z == pytest.approx(mean, rel=1e-11)
    assert p == pytest.approx(spread, rel=1e-7)


@pytest.mark.parametrize("sigma_deg", [0.05, 0.8, 4.0])
def test_ucm_is_unbiased_given_the_truth_and_its_second_moment_given_the_measurement(sigma_deg: float) -> None:
    r, b, sr, sb = 90_000.0, 0.7, 120.0, np.radians(sigma_deg)
    mean = mean_of(lambda er, eb: plane(r + er, b + eb), sr, sb)
    z, p = converted("ucm", r, b, sr, sb)
    factor = z / plane(np.array(r), np.array(b))
    assert factor * mean == pytest.approx(plane(np.array(r), np.array(b)), rel=1e-12)
    moment = mean_of(lambda er, eb: outer(z - plane(r - er, b - eb)), sr, sb)
    assert p == pytest.approx(moment, rel=1e-7)


@pytest.mark.parametrize("sigma_deg", [0.8, 3.0])
def test_dcm_averages_bias_and_covariance_over_the_truth(sigma_deg: float) -> None:
    r, b, sr, sb = 90_000.0, 0.7, 120.0, np.radians(sigma_deg)

    def raw_given(er: Floats, eb: Floats) -> tuple[Floats, Floats]:
        truth_r, truth_b = (r - er)[..., None, None], (b - eb)[..., None, None]
        raw = plane(truth_r + sr * NODES[:, None], truth_b + sb * NODES)
        weight = (WEIGHTS[:, None] * WEIGHTS)[..., None]
        mean = (weight * raw).sum(axis=(-3, -2))
        spread = (weight[..., None] * outer(raw - mean[..., None, None, :])).sum(axis=(-4, -3))
        return mean - plane(r - er, b - eb), spread

    bias = mean_of(lambda er, eb: raw_given(er, eb)[0], sr, sb)
    spread = mean_of(lambda er, eb: raw_given(er, eb)[1], sr, sb)
    z, p = converted("dcm", r, b, sr, sb)
    assert z == pytest.approx(plane(np.array(r), np.array(b)) - bias, rel=1e-11)
    assert p == pytest.approx(spread, rel=1e-7)
    assert converted("paper", r, b, sr, sb)[1] == pytest.approx(spread, rel=1e-7)


def test_the_misprint_turns_the_ellipse_into_the_line_of_sight() -> None:
    _, right = converted("paper", *MEASURED)
    _, wrong = converted("paper_literal", *MEASURED)
    assert wrong[0, 1] / right[0, 1] == pytest.approx(-1.0044, abs=1e-4)
    sight = plane(np.array(1.0), np.array(MEASURED[1]))
    assert sight @ right @ sight < 150.0**2
    assert sight @ wrong @ sight > 1_400.0**2


def test_ducm_is_the_covariance_around_an_independent_prediction() -> None:
    r0, b0, vr, vb = (float(np.asarray(x)) for x in PREDICTION)
    nodes, weights = np.polynomial.hermite_e.hermegauss(10)
    weights = weights / weights.sum()
    sr, sb = MEASURED[2:]
    tr, tb, er, eb = np.meshgrid(np.sqrt(vr) * nodes, np.sqrt(vb) * nodes, sr * nodes, sb * nodes, indexing="ij")
    error = np.exp(sb * sb / 2) * plane(r0 + tr + er, b0 + tb + eb) - plane(r0 + tr, b0 + tb)
    weight = np.einsum("i,j,k,l->ijkl", weights, weights, weights, weights)
    spread = np.einsum("ijkl,ijkla,ijklb->ab", weight, error, error)
    assert converted("ducm", *MEASURED)[1] == pytest.approx(spread, rel=1e-7)


def test_lin_is_the_covariance_of_first_order() -> None:
    r, b, sr, sb = MEASURED
    slope = np.stack(
        [(plane(np.array(r + 1), np.array(b)) - plane(np.array(r - 1), np.array(b))) / 2,
         (plane(np.array(r), np.array(b + 1e-6)) - plane(np.array(r), np.array(b - 1e-6))) / 2e-6], axis=1,
    )  # fmt: skip
    assert converted("lin", *MEASURED)[1] == pytest.approx(slope @ np.diag([sr**2, sb**2]) @ slope.T, rel=1e-8)


@pytest.mark.parametrize("name", [n for n in CONVERSIONS if n != "lin"])
def test_a_precise_azimuth_makes_all_alike_down_to_the_last_digits(name: ConversionName) -> None:
    """A difference of nearly equal exponentials would leave nothing of the variance along the line of sight."""
    r, b, sr, sb = 150_000.0, 0.4, 1.0, 1e-7
    prediction = Prediction(r, b, 0.0, 0.0)
    found = cartesian_from_polar(r, b, sr, sb, name, prediction).covariance
    if name == "paper_literal":
        return
    assert found == pytest.approx(cartesian_from_polar(r, b, sr, sb, "lin").covariance, rel=1e-9)


def test_arrays_of_any_shape_convert_like_single_ones() -> None:
    rng = np.random.default_rng(3)
    r, b = rng.uniform(1e3, 2e5, (4, 3)), rng.uniform(-np.pi, np.pi, (4, 3))
    many = cartesian_from_polar(r, b, np.array([10.0, 50.0, 100.0]), 0.01)
    assert many.point.shape == (4, 3, 2)
    assert many.covariance.shape == (4, 3, 2, 2)
    one = cartesian_from_polar(r[2, 1], b[2, 1], 50.0, 0.01)
    assert (many.point[2, 1] == one.point).all()
    assert (many.covariance[2, 1] == one.covariance).all()
    assert np.isnan(cartesian_from_polar(np.nan, 0.0, 1.0, 0.01).point).all()


@pytest.mark.parametrize(
    ("sigma_deg", "expected"),
    [
        (0.5, {"lin": 2.009, "paper": 1.987, "ucm": 2.000, "mucm": 2.000}),
        (2, {"lin": 4.502, "paper": 1.445, "mucm": 2}),
    ],
)
def test_how_honest_each_is_for_one_plot(sigma_deg: float, expected: dict[ConversionName, float]) -> None:
    """Normalised error of single plots at 150 km and 100 m (specification 12.4), by quadrature instead of a million
    draws: the truth is fixed and the measurement varies."""
    r, b, sr, sb = 150_000.0, 0.8, 100.0, np.radians(sigma_deg)
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    weights = weights / weights.sum()
    er, eb = np.meshgrid(sr * nodes, sb * nodes, indexing="ij")
    for name, value in expected.items():
        found = cartesian_from_polar(r + er, b + eb, sr, sb, name)
        error = found.point - plane(np.array(r), np.array(b))
        nees = np.einsum("...i,...ij,...j->...", error, np.linalg.inv(found.covariance), error)
        # A million draws of a heavy-tailed value scatter by some thousandths.
        assert weights @ nees @ weights == pytest.approx(value, rel=0.005), name


def test_every_conversion_says_what_it_means() -> None:
    assert {m.mean for m in CONVERSIONS.values()} <= {"truth", "measurement", "prediction", "none"}
    assert CONVERSIONS["mucm"].mean == CONVERSIONS["mucm"].covariance == "measurement"
    assert CONVERSIONS["paper"].mean != CONVERSIONS["paper"].covariance


def test_refusals() -> None:
    with pytest.raises(ParameterError, match="no conversion"):
        cartesian_from_polar(1.0, 0.0, 1.0, 0.1, "best")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="prediction"):
        cartesian_from_polar(1.0, 0.0, 1.0, 0.1, "ducm")


def test_angles_and_their_seam() -> None:
    assert angle_from_compass(np.radians([0.0, 90.0, 180.0])) == pytest.approx([np.pi / 2, 0, -np.pi / 2])
    assert angle_from_compass(angle_from_compass(2.0)) == pytest.approx(2.0)
    assert wrapped(np.array([np.pi, -np.pi, 3 * np.pi, 0.5])) == pytest.approx([np.pi, np.pi, np.pi, 0.5])
    assert nonlinearity_index(150_000.0, 100.0, np.radians(1.0)) == pytest.approx(0.457, abs=5e-4)
    # Range one sigma short, azimuth two sigma off across the seam of the angle.
    off = polar_statistic((-1000.0, 1e-9), 1010.0, -np.pi + 0.02, 10.0, 0.01)
    assert off == pytest.approx(1 + 4)
