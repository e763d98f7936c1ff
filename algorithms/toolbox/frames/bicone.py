"""Bicone coordinates of a flat fixed antenna: range and two angles, each measured from a plane of the aperture.

Antenna axes, in the local East-North-Up frame, for azimuth az (clockwise from north) and elevation el of the boresight:

    boresight  X_A = ( ce sa,  ce ca, se)
    aperture up Y_A = (-se sa, -se ca, ce)          ca = cos az, ce = cos el, ...
    right      Z_A = ( ca, -sa, 0)

With X_ant = A (X - d), A having these rows and d the phase centre, a point is r, eps, alpha:

    x_A = r c,  y_A = r sin eps,  z_A = r sin alpha,  c = sqrt(1 - sin^2 eps - sin^2 alpha),

in the half-space before the antenna: sin^2 eps + sin^2 alpha < 1. Antennas may be many: `axes` and `centre` then have
the shape of the points in front.

References
----------
alekseev2023, eq. (10) and the conversion after it.

Differences from the paper
--------------------------
The paper works in north-up-east; here everything is east-north-up. Its shift by the phase centre must come before the
rotation, and its inverse and domain are not given.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def antenna_axes(azimuth_rad: float, elevation_rad: float) -> Floats:
    """(3, 3): boresight, up in the aperture and right, as rows of east, north, up."""
    ca, sa, ce, se = np.cos(azimuth_rad), np.sin(azimuth_rad), np.cos(elevation_rad), np.sin(elevation_rad)
    return np.array([[ce * sa, ce * ca, se], [-se * sa, -se * ca, ce], [ca, -sa, 0.0]])


def within_domain(range_m: ArrayLike, elevation_rad: ArrayLike, azimuth_rad: ArrayLike) -> NDArray[np.bool_]:
    """Whether coordinates name a point before the antenna; False for what is not finite."""
    r, eps, alpha = (np.asarray(a, float) for a in (range_m, elevation_rad, azimuth_rad))
    angles = (np.abs(eps) < np.pi / 2) & (np.abs(alpha) < np.pi / 2)
    inside: NDArray[np.bool_] = (r > 0) & np.isfinite(r) & angles & (np.sin(eps) ** 2 + np.sin(alpha) ** 2 < 1)
    return inside


def position_from_bicone(
    range_m: ArrayLike, elevation_rad: ArrayLike, azimuth_rad: ArrayLike, axes: Floats, centre_m: Floats
) -> Floats:
    """(..., 3) m east, north, up; NaN outside the domain."""
    r, eps, alpha = (np.asarray(a, float) for a in (range_m, elevation_rad, azimuth_rad))
    inside = within_domain(r, eps, alpha)
    u, w = np.sin(eps), np.sin(alpha)
    c = np.sqrt(np.where(inside, 1 - u * u - w * w, np.nan))
    out: Floats = np.stack([r * (c * axes[0, i] + u * axes[1, i] + w * axes[2, i]) for i in range(3)], axis=-1)
    return out + centre_m


def bicone_from_position(position_m: Floats, axes: Floats, centre_m: Floats) -> tuple[Floats, Floats, Floats]:
    """Range, elevation and azimuth of points (..., 3); NaN at the antenna and behind it."""
    away = position_m - centre_m
    x, y, z = (away[..., 0] * axes[i, 0] + away[..., 1] * axes[i, 1] + away[..., 2] * axes[i, 2] for i in range(3))
    r = np.sqrt(x * x + y * y + z * z)
    before = np.where(x > 0, r, np.nan)
    return before, np.arcsin(y / before), np.arcsin(z / before)


def bicone_jacobian(range_m: ArrayLike, elevation_rad: ArrayLike, azimuth_rad: ArrayLike) -> Floats:
    """(..., 3, 3): derivative of the antenna coordinates (x_A, y_A, z_A) by (r, eps, alpha)."""
    r, eps, alpha = np.broadcast_arrays(*(np.asarray(a, float) for a in (range_m, elevation_rad, azimuth_rad)))
    u, w = np.sin(eps), np.sin(alpha)
    c = np.sqrt(1 - u * u - w * w)
    out = np.zeros((*r.shape, 3, 3))
    out[..., 0, 0] = c
    out[..., 0, 1] = -r * u * np.cos(eps) / c
    out[..., 0, 2] = -r * w * np.cos(alpha) / c
    out[..., 1, 0] = u
    out[..., 1, 1] = r * np.cos(eps)
    out[..., 2, 0] = w
    out[..., 2, 2] = r * np.cos(alpha)
    return out


def covariance_from_bicone(
    range_m: ArrayLike,
    elevation_rad: ArrayLike,
    azimuth_rad: ArrayLike,
    sd: tuple[float, float, float],
    axes: Floats,
) -> Floats:
    """(..., 3, 3) m2, of a converted mark to first order; sd of range (m), elevation and azimuth (rad)."""
    turned = np.swapaxes(axes, -1, -2) @ bicone_jacobian(range_m, elevation_rad, azimuth_rad)
    scaled = turned * np.asarray(sd)
    covariance: Floats = scaled @ np.swapaxes(scaled, -1, -2)
    return (covariance + np.swapaxes(covariance, -1, -2)) / 2


def conversion_bias(
    range_m: float, elevation_rad: ArrayLike, azimuth_rad: ArrayLike, sd_elevation_rad: float, sd_azimuth_rad: float
) -> Floats:
    """(3, ...) m, second-order bias of a converted mark along the antenna's axes."""
    elevation, azimuth = np.asarray(elevation_rad, float), np.asarray(azimuth_rad, float)
    u, w = np.sin(elevation), np.sin(azimuth)
    c = np.sqrt(1 - u * u - w * w)

    def bend(angle: Floats) -> Floats:
        bent: Floats = -np.cos(2 * angle) / c - (np.sin(angle) * np.cos(angle)) ** 2 / c**3
        return bent

    return np.array(
        [
            (sd_elevation_rad**2 * bend(elevation) + sd_azimuth_rad**2 * bend(azimuth)) * range_m / 2,
            -range_m * sd_elevation_rad**2 * u / 2,
            -range_m * sd_azimuth_rad**2 * w / 2,
        ]
    )


def conversion_index(range_m: ArrayLike, sd_range_m: float, sd_angle_rad: float) -> Floats:
    """R s^2 / sigma_r: the bend of the error arc in units of the range error; above 0.5 the conversion is poor."""
    index: Floats = np.asarray(range_m, float) * sd_angle_rad**2 / sd_range_m
    return index
