"""Start, acquisition and tracking gates, the counter Q, and the cost of giving a plot to a track.

The tracking gate is three nested ellipses in range and azimuth around the predicted point. With the distance

    D^2 = [((rho - rho_c) / sigma_r)^2 + (wrap(theta - theta_c) / sigma_th)^2] / m^2

a plot is of class 0 (inside the first), 1 (inside the second), 2 (in the outermost ring: a manoeuvre) or outside. K_Q
is exactly the variance of an innovation over that of a plot for a straight line through Q equispaced plots, one period
ahead; so m = sqrt(K_Q) is right for a line, while m = K_Q, as the paper prints it, fits the six-parameter predictor of
Q + 1 plots (within 1.5 % for Q >= 7). They must not be mixed.

Differences from the paper: K_conf is the radius of a two-dimensional Gaussian, sqrt(-2 ln(1 - P)); one-dimensional
quantiles hold .354, .853 and .992 of the plots instead of .65, .95 and .998. The likelihood ratio orders plots but
excludes none inside the gate: L > 0 would lose 7 to 25 % of the true ones.

References
----------
plots2006, section 2; specification 5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.motion.curvature import Floats, wrapped

Ints = NDArray[np.int64]

LEAST_Q, MOST_Q = 2, 12
CONFIDENCES = (0.65, 0.95, 0.998)
ACQUISITION_SIGMAS = 15.0
OUTSIDE = 3


def radius_of(probability: Floats) -> Floats:
    """Radius, in standard deviations, of the circle that holds a share of a two-dimensional Gaussian."""
    out: Floats = np.sqrt(-2.0 * np.log1p(-np.asarray(probability, float)))
    return out


def variance_ratio(q: Ints | Floats) -> Floats:
    """K_Q: variance of the innovation over that of a plot, for a line through Q plots, one period ahead."""
    q = np.asarray(q, float)
    out: Floats = (q + 1.0) * (q + 2.0) / (q * (q - 1.0))
    return out


def line_variance_ratio(plots: Ints | Floats, periods: Ints | Floats) -> Floats:
    """The same, any number of periods ahead."""
    n = np.asarray(plots, float)
    out: Floats = 1.0 + 1.0 / n + 12.0 * (0.5 * (n - 1.0) + periods) ** 2 / (n * (n * n - 1.0))
    return out


def start_radius(rho: Floats, period_s: Floats, max_speed_mps: float, sigma_r: Floats, sigma_th: Floats) -> Floats:
    """Radius of the gate of a second plot, m: the larger semi-axis, all around."""
    way = max_speed_mps * period_s
    out: Floats = np.maximum(*start_axes(rho, way, sigma_r, sigma_th))
    return out


def start_axes(rho: Floats, way_m: Floats, sigma_r: Floats, sigma_th: Floats) -> tuple[Floats, Floats]:
    """Semi-axes of the start gate along and across the ray, m."""
    return way_m + 2.0 * sigma_r, way_m + 2.0 * rho * sigma_th


def acquisition_axes(rho: Floats, sigma_r: Floats, sigma_th: Floats) -> tuple[Floats, Floats]:
    """Semi-axes of the gate of a third plot along and across the ray, m."""
    return ACQUISITION_SIGMAS * sigma_r, ACQUISITION_SIGMAS * sigma_th * rho


def squared_distance(
    rho: Floats, theta: Floats, predicted: tuple[Floats, Floats], sigma_r: float, sigma_th: Floats, m: Floats
) -> Floats:
    """D^2 of plots around predicted points, broadcast against each other."""
    along = (rho - predicted[0]) / sigma_r
    across = wrapped(theta - predicted[1]) / sigma_th
    out: Floats = (along**2 + across**2) / np.asarray(m) ** 2
    return out


def classes(d2: Floats, confidences: tuple[float, float, float] = CONFIDENCES) -> Ints:
    """0, 1, 2 by the ellipse a plot lies in, `OUTSIDE` beyond the last."""
    limits = radius_of(np.array(confidences)) ** 2
    return np.searchsorted(limits, d2, side="left")


def log_likelihood_ratio(d2: Floats, q: Ints | Floats) -> Floats:
    """L = ln Q - (D^2 / 2)(1 - 1 / Q): variance 1 against variance Q. The cost of a pair is -L."""
    q = np.asarray(q, float)
    return np.log(q) - 0.5 * d2 * (1.0 - 1.0 / q)


def counted(q: Ints, plot_class: Ints) -> Ints:
    """Q after a plot of a class: one more inside the first ellipse, as it was in the second, 2 after a manoeuvre."""
    more = np.minimum(q + 1, MOST_Q)
    return np.where(plot_class == 0, more, np.where(plot_class == 1, q, LEAST_Q))
