"""The curve with constant acceleration and curvature through a track's plots, and what is taken where it is absurd.

Differences from the paper: its two systems of eight equations in eight unknowns are singular (`base_points` shows it);
fitted are the six parameters directly, by Levenberg and Marquardt's method from two starts.

References
----------
plots2006, section 3; specification 4.1; more1978.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from algorithms.plot_tracking.curve_descent import descend
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.window import Bools, Fit, Ints, Window, moments, solved, sum_of_squares
from algorithms.toolbox.motion.curvature import Floats, from_three_positions

# With so many plots and a cost within so many of its standard deviations the minimum is the lowest.
ONE_MINIMUM_PLOTS, COST_SIGMAS = 7, 3.0
# Speeds below this give no direction to start from.
LEAST_SPEED_MPS = 1.0
LEAST_PRIOR_SPEED_MPS = 30.0
# So many plots determine six parameters and leave two equations for a test.
CURVE_PLOTS = 4

LINE, FREE, HELD, LINE_INSTEAD = range(4)
"""How a window was fitted: two or three plots; ML6; MAP6; a line in place of an absurd MAP6."""


@dataclass(frozen=True)
class Limits:
    """What an aircraft of this class can do, and how far the penalised fit expects it to go."""

    max_speed_mps: float = 1000.0
    max_acceleration_mps2: float = 10.0
    max_normal_mps2: float = 15.0
    sd_acceleration_mps2: float = 1.5
    sd_normal_mps2: float = 3.0


def fit_curve(window: Window, limits: Limits, *, penalised: bool = False) -> Fit:
    """Curve with constant acceleration and curvature (ML6), or the same with a penalty on both (MAP6).

    From two starts, a weighted quadratic and the curve through the first, the middle and the newest plot; the lower
    minimum wins. Many plots with residuals as large as their errors have no second minimum, and need no second start.
    The penalty is (a / sd_a)^2 + (K Vp^2 / sd_n)^2, Vp the speed of the straight line, at least 30 m/s.
    A window needs four plots.
    """
    prior = np.zeros((2, window.rho.shape[1]))
    if penalised:
        speed = np.maximum(fit_line(window).p[3], LEAST_PRIOR_SPEED_MPS)
        prior[0] = 1.0 / limits.sd_acceleration_mps2
        prior[1] = speed**2 / limits.sd_normal_mps2
    first = _descend(window, quadratic_start(window), prior)
    doubtful = np.flatnonzero(_may_be_another(window, first))
    if doubtful.size:
        part = window.take(doubtful)
        second = _descend(part, three_point_start(part), prior[:, doubtful])
        other = np.flatnonzero(_total(second, prior[:, doubtful]) < _total(first, prior)[doubtful])
        first.put(doubtful[other], second.take(other))
    return first


def _may_be_another(window: Window, found: Fit) -> Bools:
    """Whether a lower minimum is to be looked for: few plots, no convergence, or residuals larger than errors are."""
    equations = 2.0 * window.plots
    plausible = found.cost < equations + COST_SIGMAS * np.sqrt(2.0 * equations)
    out: Bools = ~found.converged | (window.plots < ONE_MINIMUM_PLOTS) | ~plausible
    return out


def fit(window: Window, limits: Limits, *, penalised: bool = False) -> tuple[Fit, Ints]:
    """Fit each window as its number of plots allows, and fall back where the outcome is absurd.

    Returns
    -------
    fit : of each window
    how : (W,) `LINE`, `FREE` (asked for), `HELD` (asked for, or in place of an absurd free fit), `LINE_INSTEAD`
    """
    count = window.plots.size
    out = Fit(np.empty((6, count)), np.empty((6, 6, count)), np.empty(count), np.empty(count, bool))
    how = np.full(count, LINE)
    left = np.flatnonzero(window.plots >= CURVE_PLOTS)
    for kind in (HELD,) if penalised else (FREE, HELD):
        if not left.size:
            break
        part = window.take(left)
        found = fit_curve(part, limits, penalised=kind == HELD)
        sound = is_sound(part, found, limits)
        out.put(left[sound], found.take(np.flatnonzero(sound)))
        how[left[sound]] = kind
        left = left[~sound]
    how[left] = LINE_INSTEAD
    straight = np.flatnonzero((how == LINE) | (how == LINE_INSTEAD))
    if straight.size:
        out.put(straight, fit_line(window.take(straight)))
    return out, how


def is_sound(window: Window, found: Fit, limits: Limits) -> Bools:
    """Whether a curve can be an aircraft's: converged, within the limits, less than one full turn in the window."""
    _, _, _, b, a, curvature = found.p
    span = window.span_s
    speed = np.maximum(np.abs(b), np.abs(b - a * span))
    out: Bools = (
        found.converged
        & np.isfinite(found.p).all(axis=0)
        & (np.abs(a) <= limits.max_acceleration_mps2)
        & (np.abs(curvature) * b**2 <= limits.max_normal_mps2)
        & (speed <= limits.max_speed_mps)
        & (np.abs(curvature * b) * span <= 2.0 * np.pi)
    )
    return out


def quadratic_start(window: Window) -> Floats:
    """Position, velocity and acceleration of weighted quadratics in X and Y, as parameters (6, W)."""
    x, y = window.cartesian
    weight = window.known / (window.sigma_r**2 + (window.rho * window.sigma_th) ** 2)
    one, once, twice, thrice, fourth = moments(weight, window.t, 4)
    n = np.stack([one, once, 0.5 * twice, once, twice, 0.5 * thrice, 0.5 * twice, 0.5 * thrice, 0.25 * fourth])
    n = n.reshape(3, 3, -1)
    g = np.stack([moments(weight * place, window.t, 2) for place in (x, y)], axis=1)
    g[2] *= 0.5
    (x0, y0), (vx, vy), (ax, ay) = solved(n, g)
    speed = np.maximum(np.hypot(vx, vy), LEAST_SPEED_MPS)
    return np.stack([x0, y0, np.arctan2(vy, vx), speed, (vx * ax + vy * ay) / speed, (vx * ay - vy * ax) / speed**3])


def three_point_plots(window: Window) -> tuple[Floats, Floats, Floats]:
    """Ranges, azimuths and instants, (3, W) each, of the oldest, a middle (nearest to mid-span) and the newest plot."""
    first = np.argmax(window.known, axis=0)
    at = np.arange(window.rho.shape[1])
    start = window.t[first, at]
    # Neither end may be the middle, wherever it is nearest.
    inner = window.known & (window.t > start) & (window.t < 0)
    middle = np.argmin(np.where(inner, np.abs(window.t - 0.5 * start), np.inf), axis=0)
    rows = np.stack([first, middle, np.full(at.size, window.rho.shape[0] - 1)])
    return window.rho[rows, at], window.theta[rows, at], window.t[rows, at]


def three_point_start(window: Window) -> Floats:
    """Parameters of the curve through the oldest, a middle and the newest plot, (6, W)."""
    rho, theta, t = three_point_plots(window)
    return from_three_positions(rho * np.cos(theta), rho * np.sin(theta), t)


def _descend(window: Window, start: Floats, prior: Floats) -> Fit:
    """Levenberg and Marquardt from `start` (6, W), with weights of a and K in `prior` (2, W)."""
    p, count = np.array(start, order="C"), start.shape[1]
    information, cost, converged = np.empty((6, 6, count)), np.empty(count), np.empty(count, bool)
    # One layout of all arrays, so that one version is compiled.
    descend(*map(np.ascontiguousarray, window), p, np.ascontiguousarray(prior), information, cost, converged)
    return Fit(p, information, cost, converged)


def _total(found: Fit, prior: Floats) -> Floats:
    return found.cost + sum_of_squares(prior * found.p[4:])
