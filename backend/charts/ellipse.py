"""Error ellipses in the plane."""

from __future__ import annotations

import numpy as np

from backend.charts.columns import Floats


def error_ellipses(
    east_m: Floats,
    north_m: Floats,
    sigma_east_m: Floats,
    sigma_north_m: Floats,
    covariance_m2: Floats,
    *,
    probability: float = 0.95,
    corners: int = 36,
) -> tuple[Floats, Floats]:
    """Outline the regions that hold the true position with the given probability.

    For a Gaussian error in the plane the squared Mahalanobis distance follows the chi-square law with 2 degrees of
    freedom, whose quantile is -2 ln(1 - probability). The outline is scale * P^(1/2) applied to the unit circle, the
    square root being the triangular one: the same ellipse, and defined for a covariance of rank one too.

    Returns
    -------
    (k * (corners + 2),) float, m, twice: east and north of the closed outlines, NaN after each. A covariance that is
    not positive semidefinite gives no outline.
    """
    scale = np.sqrt(-2 * np.log1p(-probability))
    angle = np.linspace(0, 2 * np.pi, corners + 1)
    with np.errstate(divide="ignore", invalid="ignore"):
        lower = np.where(sigma_east_m > 0, covariance_m2 / sigma_east_m, 0.0)
        rest = sigma_north_m**2 - lower**2
    # Rounding of a correlation of one must not take the ellipse away.
    rest = np.where((rest < 0) & (rest > -1e-9 * sigma_north_m**2), 0.0, rest)
    sound = np.isfinite(east_m + north_m + sigma_east_m + lower) & (sigma_east_m >= 0) & (rest >= 0)
    keep = np.flatnonzero(sound)
    cos, sin = scale * np.cos(angle), scale * np.sin(angle)
    east = east_m[keep, None] + sigma_east_m[keep, None] * cos
    north = north_m[keep, None] + lower[keep, None] * cos + np.sqrt(rest[keep, None]) * sin
    gap = np.full((keep.size, 1), np.nan)
    return np.hstack((east, gap)).ravel(), np.hstack((north, gap)).ravel()
