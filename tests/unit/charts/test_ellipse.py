import numpy as np
from scipy.stats import chi2

from backend.charts.ellipse import error_ellipses


def outline(sigma_east: float, sigma_north: float, covariance: float, **more: float) -> tuple[np.ndarray, np.ndarray]:
    one = np.ones(1)
    return error_ellipses(100 * one, 200 * one, sigma_east * one, sigma_north * one, covariance * one, **more)


def test_every_corner_lies_at_the_quantile_of_the_mahalanobis_distance() -> None:
    east, north = outline(30.0, 40.0, 600.0)
    inverse = np.linalg.inv([[900.0, 600.0], [600.0, 1600.0]])
    offset = np.stack([east[:-1] - 100, north[:-1] - 200])
    distance = np.einsum("in,ij,jn->n", offset, inverse, offset)
    np.testing.assert_allclose(distance, chi2.ppf(0.95, 2), rtol=1e-12)


def test_outlines_are_closed_and_separated() -> None:
    east, _ = outline(30.0, 40.0, 0.0)
    assert east[0] == east[-2]
    assert np.isnan(east[-1])


def test_another_probability() -> None:
    east, _ = outline(1.0, 1.0, 0.0, probability=0.5)
    np.testing.assert_allclose(np.nanmax(east) - 100, np.sqrt(chi2.ppf(0.5, 2)), rtol=1e-12)


def test_a_covariance_of_rank_one_is_a_line() -> None:
    east, north = outline(30.0, 40.0, 1200.0)
    np.testing.assert_allclose((north - 200)[:-1] * 30, (east - 100)[:-1] * 40, atol=1e-6)


def test_no_outline_without_a_sound_covariance() -> None:
    for bad in ((30.0, 40.0, 1300.0), (np.nan, 40.0, 0.0), (30.0, np.nan, 0.0), (30.0, 40.0, np.nan)):
        assert outline(*bad)[0].size == 0


def test_no_east_error_is_a_vertical_line() -> None:
    east, north = outline(0.0, 40.0, 0.0)
    assert set(east[:-1]) == {100.0}
    np.testing.assert_allclose(np.nanmax(north) - 200, 40 * np.sqrt(chi2.ppf(0.95, 2)))
