"""Altitude on sphere and ellipsoid, against pymap3d, finite differences and the specification's numbers."""

import numpy as np
import pymap3d
import pytest

from algorithms.errors import FrameError
from algorithms.site import Origin
from algorithms.toolbox.frames import earth as e

RNG = np.random.default_rng(5)
POINTS = np.column_stack([RNG.uniform(-4e5, 4e5, (200, 2)), RNG.uniform(-5e3, 4e4, 200)])


@pytest.mark.parametrize("latitude", [-89.9, -33.0, 0.0, 47.0, 70.0])
def test_ellipsoid_agrees_with_pymap3d(latitude: float) -> None:
    origin = Origin(latitude_deg=latitude, longitude_deg=37.6, height_m=310.0)
    expected = pymap3d.enu2geodetic(*POINTS.T, latitude, 37.6, 310.0)[2]
    np.testing.assert_allclose(e.altitude_from_position(POINTS, e.wgs84(origin)), expected, atol=1e-6)


@pytest.mark.parametrize(
    "earth", [e.sphere(), e.sphere(6_371_000, 500), e.wgs84(Origin(latitude_deg=47, longitude_deg=8, height_m=200))]
)
def test_gradient_and_inverse(earth: np.ndarray) -> None:
    step = np.eye(3)
    numeric = np.stack(
        [(e.altitude_from_position(POINTS + d, earth) - e.altitude_from_position(POINTS - d, earth)) / 2 for d in step],
        axis=-1,
    )
    np.testing.assert_allclose(e.up_from_position(POINTS, earth), numeric, atol=1e-7)
    h = e.altitude_from_position(POINTS, earth)
    np.testing.assert_allclose(e.z_from_altitude(POINTS[:, 0], POINTS[:, 1], h, earth), POINTS[:, 2], atol=1e-6)


def test_height_above_the_plane() -> None:
    """h - z is 0.78 km at 100 km and 3.1 km at 200 km (specification 2)."""
    h = e.altitude_from_position(np.array([[1e5, 0, 0], [2e5, 0, 0]]), e.sphere())
    assert h == pytest.approx([784.7, 3138.5], abs=1.0)


def test_local_radius() -> None:
    assert e.local_radius_m(55.75) == pytest.approx(6_385_960, abs=10)


def test_beyond_the_horizon_plane() -> None:
    with pytest.raises(FrameError, match="check the unit"):
        e.z_from_altitude(np.array(7e6), np.array(0.0), np.array(1e4), e.sphere())
