"""Altitude above the Earth of a point in a local ENU frame, and its gradient: sphere or WGS-84.

Sphere of radius R touching the frame's zero, which may itself lie at altitude h0 (R then means R + h0):

    h = (x^2 + y^2 + z^2 + 2 R z) / (sqrt((R + z)^2 + x^2 + y^2) + R) + h0,
    grad h = (x, y, R + z) / sqrt((R + z)^2 + x^2 + y^2),
    z(x, y, h) = (h^2 + 2 R h - x^2 - y^2) / (sqrt((R + h)^2 - x^2 - y^2) + R).

The quotients keep the digits that the differences of large numbers lose. WGS-84: geodetic height by Bowring's
formula, iterated once more (error below a micrometre up to 100 km height), gradient = the ellipsoid's up vector.

Differences from the paper: its gradient (26) prints z where R + z must stand (with the printed form the filter ends
3 500 km away); the ellipsoid and an origin above the sphere are ours.

References
----------
chugunov2023, eqs. (1)-(3), (26); bowring1976.
"""

from __future__ import annotations

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.errors import FrameError
from algorithms.site import Origin
from algorithms.toolbox.kernels import inlined

Floats = NDArray[np.float64]

R_PAPER_M = 6_371_000.0
_A = 6_378_137.0
_F = 1 / 298.257223563
_B = _A * (1 - _F)
_E2 = _F * (2 - _F)
_EP2 = _E2 / (1 - _E2)

SPHERE, WGS84 = 0.0, 1.0


def sphere(radius_m: float = R_PAPER_M, origin_height_m: float = 0.0) -> Floats:
    """Description of a spherical Earth for the kernels, (15,) float."""
    earth = np.zeros(15)
    earth[:3] = SPHERE, radius_m + origin_height_m, origin_height_m
    return earth


def local_radius_m(latitude_deg: float) -> float:
    """sqrt(M N) of the ellipsoid at a latitude: the sphere that fits best there, m."""
    w2 = 1 - _E2 * np.sin(np.radians(latitude_deg)) ** 2
    return float(_A * np.sqrt(1 - _E2) / w2)


def wgs84(origin: Origin) -> Floats:
    """Description of the ellipsoid seen from an origin for the kernels, (15,) float."""
    earth = np.zeros(15)
    earth[0] = WGS84
    earth[1] = local_radius_m(origin.latitude_deg) + origin.height_m
    earth[2] = origin.height_m
    earth[3:6] = pymap3d.geodetic2ecef(origin.latitude_deg, origin.longitude_deg, origin.height_m)
    lat, lon = np.radians(origin.latitude_deg), np.radians(origin.longitude_deg)
    # Rows: ECEF components of east, north, up.
    earth[6:15] = np.array(
        [
            [-np.sin(lon), np.cos(lon), 0.0],
            [-np.sin(lat) * np.cos(lon), -np.sin(lat) * np.sin(lon), np.cos(lat)],
            [np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)],
        ]
    ).ravel()
    return earth


@inlined
def height_and_up(x, y, z, earth):
    """Altitude of a point and its gradient: (h, gx, gy, gz)."""
    if earth[0] == 0.0:
        r = earth[1]
        q = x * x + y * y
        d = np.sqrt((r + z) * (r + z) + q)
        h = (q + z * z + 2.0 * r * z) / (d + r) + earth[2]
        return h, x / d, y / d, (r + z) / d
    ex = earth[3] + earth[6] * x + earth[9] * y + earth[12] * z
    ey = earth[4] + earth[7] * x + earth[10] * y + earth[13] * z
    ez = earth[5] + earth[8] * x + earth[11] * y + earth[14] * z
    rho = np.sqrt(ex * ex + ey * ey)
    sb = _A * ez
    cb = _B * rho
    sp = 0.0
    cp = 1.0
    for _ in range(2):
        n = np.sqrt(sb * sb + cb * cb)
        sb /= n
        cb /= n
        sp = ez + _EP2 * _B * sb * sb * sb
        cp = rho - _E2 * _A * cb * cb * cb
        n = np.sqrt(sp * sp + cp * cp)
        sp /= n
        cp /= n
        sb = (1.0 - _F) * sp
        cb = cp
    h = rho * cp + ez * sp - _A * np.sqrt(1.0 - _E2 * sp * sp)
    ux = cp * ex / rho
    uy = cp * ey / rho
    return (
        h,
        earth[6] * ux + earth[7] * uy + earth[8] * sp,
        earth[9] * ux + earth[10] * uy + earth[11] * sp,
        earth[12] * ux + earth[13] * uy + earth[14] * sp,
    )


def altitude_from_position(points_m: Floats, earth: Floats) -> Floats:
    """(..., 3) m -> (...) m: altitude above the sphere or geodetic height."""
    return _on_arrays(points_m, earth)[0]


def up_from_position(points_m: Floats, earth: Floats) -> Floats:
    """(..., 3) m -> (..., 3): gradient of the altitude."""
    return np.stack(_on_arrays(points_m, earth)[1:], axis=-1)


def _on_arrays(points_m: Floats, earth: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Evaluate the kernels' own formula on whole arrays: nothing is compiled where a server only draws a chart."""
    points = np.asarray(points_m, float)
    h, gx, gy, gz = height_and_up.py_func(points[..., 0], points[..., 1], points[..., 2], earth)
    return h, gx, gy, gz


def z_from_altitude(x: Floats, y: Floats, altitude_m: Floats, earth: Floats) -> Floats:
    """ENU height of a point at (x, y) with a given altitude, m.

    Sphere: the closed form above. Ellipsoid: three Newton steps from the fitting sphere's value.

    Raises
    ------
    FrameError
        Where the point would lie beyond the horizon plane, x^2 + y^2 > (R + h)^2.
    """
    x, y, altitude_m = np.broadcast_arrays(np.asarray(x, float), y, altitude_m)
    r, h = earth[1], altitude_m - earth[2]
    q = x * x + y * y
    inside = (r + h) ** 2 - q
    if np.any(~(inside >= 0)):
        raise FrameError(
            "a point lies farther out than the Earth is wide, so it has no height there",
            remedy="check the unit of the coordinates (metres) and the altitude",
        )
    z = (h * h + 2 * r * h - q) / (np.sqrt(inside) + r)
    if earth[0] == WGS84:
        for _ in range(3):
            p = np.stack([x, y, z], axis=-1)
            z = z - (altitude_from_position(p, earth) - altitude_m) / up_from_position(p, earth)[..., 2]
    return z
