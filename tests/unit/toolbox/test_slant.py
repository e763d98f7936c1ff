import numpy as np
import pytest

from algorithms.toolbox.frames.earth import altitude_from_position, sphere
from algorithms.toolbox.frames.slant import ground_from_slant

R = 6_371_000.0


@pytest.mark.parametrize("radar_m", [0.0, 650.0])
def test_the_point_that_it_gives_has_that_range_and_altitude(radar_m):
    slant = np.array([9_000.0, 40_000.0, 120_000.0, 400_000.0])
    altitude = np.array([8_000.0, 11_000.0, 3_000.0, 12_000.0])
    ground, up = ground_from_slant(slant, altitude, radar_m, R)
    np.testing.assert_allclose(np.hypot(ground, up), slant)
    points = np.stack([0.6 * ground, 0.8 * ground, up], axis=1)
    np.testing.assert_allclose(altitude_from_position(points, sphere(R, radar_m)), altitude, atol=1e-6)


def test_how_far_the_flat_formula_is_off():
    ground, _ = ground_from_slant(np.array([100_000.0]), np.array([10_000.0]), 0.0, R)
    assert ground[0] - np.sqrt(100_000.0**2 - 10_000.0**2) == pytest.approx(75, abs=1)


def test_a_range_that_does_not_reach_the_altitude_and_no_altitude():
    ground, up = ground_from_slant(np.array([5_000.0, 5_000.0]), np.array([9_000.0, np.nan]), 0.0)
    assert np.isnan(ground).all()
    assert (up[0] > 5_000, np.isnan(up[1])) == (True, True)
