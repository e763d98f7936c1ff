"""What the estimator of one window finds: place, motion, what it claims, and how its descent went."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.plot_tracking import descents
from algorithms.plot_tracking.curve_fit import Limits, fit_curve, quadratic_start, three_point_start
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.placed import covariances_of, placed
from algorithms.plot_tracking.polynomials import fit_polynomials
from algorithms.plot_tracking.window import Bools, Fit, Window, covariance_of, sum_of_squares
from algorithms.plot_tracking.window_parameters import WindowParameters
from algorithms.toolbox.motion.curvature import Floats, position, position_by_series, wrapped

DEGREES = {"quadratic": 2, "cubic": 3}
# Two costs are of one minimum where they differ by less, in parts and at all.
SAME_COST = 1e-4
# A fit beyond these is none: no recording has such numbers.
FARTHEST_M, FASTEST_MPS, STRONGEST_MPS2 = 1e7, 1e4, 1e4


class Found(NamedTuple):
    """Of W windows; what is not sound is NaN, and no estimate."""

    sound: Bools
    state: Floats
    """(W, 4) east, north and their velocities"""
    covariance: Floats
    """(W, 4, 4)"""
    motion: Floats
    """(W, 4) acceleration along and across the path, standard deviations of speed and of course in deg"""
    ahead: Floats
    """(W, 2) east and north one period later"""
    cost: Floats
    converged: Floats
    """1 or 0"""
    lowest: Floats
    """1 or 0, NaN = was not looked for"""
    series_error: Floats
    bends: Floats
    """1 where the curvature changes its sign in the window"""


def found_of(window: Window, p: WindowParameters, period_s: float) -> Found:
    """Fit windows and put into words what came out."""
    if p.trajectory in DEGREES:
        return _polynomial(window, DEGREES[p.trajectory], period_s)
    quadratic = quadratic_start(window) if window.rho.shape[0] > 2 else np.empty((6, 0))
    fit = _fit(window, p, quadratic)
    q = np.nan_to_num(fit.p)
    sound = (
        np.isfinite(fit.p).all(axis=0)
        & (np.hypot(fit.p[0], fit.p[1]) < FARTHEST_M)
        & (np.abs(fit.p[3]) < FASTEST_MPS)
        & (np.abs(fit.p[4]) < STRONGEST_MPS2)
        & (np.abs(fit.p[5]) * fit.p[3] ** 2 < STRONGEST_MPS2)
        & np.isfinite(fit.information).all(axis=(0, 1))
    )
    q = np.where(sound, q, 1.0)
    north, east, course, speed, a, curvature = q
    full = covariances_of(np.where(sound, fit.information, np.eye(6)[:, :, None]))
    state = np.stack([east, north, speed * np.sin(course), speed * np.cos(course)], axis=1)
    sd_speed, sd_course = (np.sqrt(np.maximum(full[i, i], 0.0)) for i in (3, 2))
    motion = np.stack([a, curvature * speed**2, sd_speed, np.degrees(sd_course)], axis=1)
    later = position(q, np.array(period_s))
    lowest = np.full(sound.size, np.nan)
    if p.compare_minima and p.trajectory == "ml6":
        free = fit_curve(window, _limits(p))
        best = descents.lowest(window, (fit, free), quadratic)
        lowest = (np.where(np.isfinite(fit.cost), fit.cost, np.inf) < best + SAME_COST * (1.0 + best)).astype(float)
    exact = position(q, np.array(p.series_ahead_s))
    series = position_by_series(q, np.array(p.series_ahead_s), p.series_order)
    return Found(
        sound, _or_nan(sound, state), placed(full, q, np.zeros(sound.size)), _or_nan(sound, motion),
        _or_nan(sound, np.stack([later[1], later[0]], axis=1)), np.where(sound, fit.cost, np.nan),
        fit.converged.astype(float), lowest,
        np.where(sound, np.hypot(series[0] - exact[0], series[1] - exact[1]), np.nan), np.zeros(sound.size),
    )  # fmt: skip


def bound_m(window: Window) -> Floats:
    """(W,) m: Cramer-Rao bound of the place from windows of true places; NaN where their motion is not of the model."""
    found = fit_curve(window, Limits())
    covariance = covariance_of(found.information)
    steady = found.cost < 1e-2
    return np.where(steady, np.sqrt(np.maximum(covariance[0, 0] + covariance[1, 1], 0.0)), np.nan)


def _fit(window: Window, p: WindowParameters, quadratic: Floats) -> Fit:
    if p.trajectory == "line":
        return fit_line(window)
    if p.trajectory == "map6" or p.descent == "damped":
        return fit_curve(window, _limits(p), penalised=p.trajectory == "map6")
    if p.descent == "base_points":
        return descents.by_base_points(window)
    if p.descent == "centre":
        return descents.by_centre_and_radius(window, quadratic)
    start = quadratic if p.descent == "quadratic" else three_point_start(window)
    return descents.by_course_and_speed(window, start)


def _limits(p: WindowParameters) -> Limits:
    return Limits(sd_acceleration_mps2=p.sd_acceleration_mps2, sd_normal_mps2=p.sd_normal_mps2)


def _polynomial(window: Window, degree: int, period_s: float) -> Found:
    """Polynomials say nothing of course and curvature themselves; they follow from the derivatives."""
    found = fit_polynomials(window, degree)
    sound: Bools = np.asarray(np.isfinite(found.x + found.y).all(axis=0))
    x, y = (np.where(sound, part, 1.0) for part in (found.x, found.y))
    speed = np.maximum(np.hypot(x[1], y[1]), 1e-9)
    along, across = (x[1] * x[2] + y[1] * y[2]) / speed, (x[1] * y[2] - y[1] * x[2]) / speed
    covariance = np.zeros((sound.size, 4, 4))
    for i in range(2):
        for j in range(2):
            shared = np.where(sound, found.covariance[i, j], 0.0)
            covariance[:, 2 * i, 2 * j] = covariance[:, 2 * i + 1, 2 * j + 1] = shared
    sd = np.sqrt(covariance[:, 2, 2])
    later = found.at(np.full(sound.size, period_s))
    fitted = found.at(window.t)
    rho, theta = np.hypot(*fitted), np.arctan2(fitted[1], fitted[0])
    residuals = np.concatenate([(window.rho - rho) / window.sigma_r, wrapped(window.theta - theta) / window.sigma_th])
    none = np.full(sound.size, np.nan)
    motion = np.stack([along, across, sd, np.degrees(np.minimum(sd / speed, np.pi))], axis=1)
    return Found(
        sound, _or_nan(sound, np.stack([y[0], x[0], y[1], x[1]], axis=1)), covariance, _or_nan(sound, motion),
        _or_nan(sound, np.stack([later[1], later[0]], axis=1)), np.where(sound, sum_of_squares(residuals), np.nan),
        sound.astype(float), none, none, found.bends_both_ways(window.span_s).astype(float),
    )  # fmt: skip


def _or_nan(sound: Bools, values: Floats) -> Floats:
    out: Floats = np.where(sound[:, None], values, np.nan)
    return out
