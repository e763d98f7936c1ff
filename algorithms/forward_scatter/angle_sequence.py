"""One receiver with Doppler and azimuth, epoch by epoch: crossing time and slope, angular velocity, distance by (19).

    gamma = -(omega s)^2 a / (lambda s (a - s))   =>   s (lambda gamma - a omega^2) = a lambda gamma        (19)

omega is the slope of the window's line through phi; or phi_line(t_c) / (t_c - tau) (20), which is singular at the
crossing and is held there; or the regression sum tan(phi) d / sum d^2 over all data, d = t - tau. Doppler alone cannot
tell s from a - s, nor the sign of v_y; omega tells both. With elevations the height is the mean of rho tan(elevation),
rho^2 = s^2 + (v_y d)^2, weighted by 1 / rho^2, and s can be found again with the height known, from

    gamma = -(omega^2 s^2 / lambda) (1 / sqrt((a - s)^2 + H^2) + 1 / sqrt(s^2 + H^2)).

References
----------
scatter2014, eqs. (19), (20); specification 7. Differences from the paper: tan(phi) in a regression in place of phi,
the zone in which (20) is not used, heights.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from algorithms.forward_scatter.freeze import CONFIRMED, FROZEN, KEPT_VARIANCE, MEMORY, NEVER, crossing, forget
from algorithms.forward_scatter.lines import FEWEST_PLAIN, FEWEST_ROBUST, PLAIN, fit_line
from algorithms.forward_scatter.sequence import (
    CROSSED,
    EXTRAPOLATED,
    INVALID,
    NO_CROSSING,
    NO_DATA,
    NO_LINE,
    mean_rate,
    slope_with_rate,
)
from algorithms.toolbox.kernels import strict

SLOPE, ENDS, REGRESSION = range(3)
GAMMA_SLOPE, GAMMA_END = range(2)
BISECTIONS = 60


class AngleOptions(NamedTuple):
    """What the method is told, in SI units and radians."""

    window: int
    rule: int
    delay: int
    confirm: int
    omega: int
    gamma: int
    robust: int
    with_height: bool
    sigma: float
    sigma_rate: float
    sigma_phi: float
    zone: float
    """Half width of the zone round the crossing in which (20), and the slope from the ends, are not used, s."""
    a: float
    wavelength: float


class AngleAnswers(NamedTuple):
    """What comes out: K epochs, L trials. NaN = none."""

    status: np.ndarray
    line: np.ndarray
    """(K, 6, L): t_c s, f_c Hz, slope Hz/s, S_tt s2, values used, zero s."""
    tau: np.ndarray
    frozen: np.ndarray
    gamma: np.ndarray
    omega: np.ndarray
    theta: np.ndarray
    """(K, 3, L): tau, s, v_y."""
    covariance: np.ndarray
    """(K, 3, 3, L)."""
    height: np.ndarray


def angle_answers(epochs: int, lanes: int) -> AngleAnswers:
    """Room for the answers, filled with nothing."""

    def nothing(*shape: int) -> np.ndarray:
        return np.full((epochs, *shape, lanes), np.nan)

    return AngleAnswers(
        status=np.zeros((epochs, lanes), np.int64),
        line=nothing(6),
        tau=nothing(),
        frozen=np.zeros((epochs, lanes), np.bool_),
        gamma=nothing(),
        omega=nothing(),
        theta=nothing(3),
        covariance=nothing(3, 3),
        height=nothing(),
    )


@strict
def distance_at_height(gamma, omega, height, a, wavelength):
    """Solve the slope's equation for s on (1 m, a - 1 m); NaN where there is no root."""
    low = 1.0
    high = a - 1.0
    target = -gamma * wavelength / (omega * omega)
    for _ in range(BISECTIONS):
        s = 0.5 * (low + high)
        value = s * s * (1.0 / np.sqrt((a - s) ** 2 + height * height) + 1.0 / np.sqrt(s * s + height * height))
        if value < target:
            low = s
        else:
            high = s
    s = 0.5 * (low + high)
    return s if s > 1.5 and s < a - 1.5 else np.nan


@strict
def _angular_velocity(time, phi, k, lane, tau, o, t, v, weight, line, held, together):
    """Angular velocity and its variance; `held` where (20) is not to be used.

    `together` (5,) are sums over the azimuths so far: number, times, their squares, tan(phi), tan(phi) times the time,
    each time counted from the first epoch.
    """
    count = 0
    if o.omega == REGRESSION:
        back = tau - time[0]
        along = together[4] - back * together[3]
        square = together[2] - 2.0 * back * together[1] + back * back * together[0]
        if together[0] < 2.0 or square <= 0.0:
            return np.nan, np.nan
        return along / square, o.sigma_phi**2 / square
    for i in range(max(0, k - o.window + 1), k + 1):
        if np.isfinite(phi[i, lane]):
            t[count] = time[i]
            v[count] = phi[i, lane]
            count += 1
    if not fit_line(t, v, count, o.sigma_phi, PLAIN, weight, line):
        return np.nan, np.nan
    if o.omega == SLOPE:
        return line[2], o.sigma_phi**2 / line[3]
    away = line[0] - tau
    if abs(away) < o.zone:
        return held[0], held[1]
    return line[1] / away, o.sigma_phi**2 / (line[4] * away * away)


@strict
def follow_angle(time, f, rate, phi, elevation, o, out):
    """Go through a pass: time (K,) s; f, rate (K, 1, L); phi, elevation (K, L) rad, phi from the base line."""
    epochs, _, lanes = f.shape
    memory = np.empty((1, MEMORY))
    t = np.empty(o.window)
    v = np.empty(o.window)
    weight = np.empty(o.window)
    line = np.empty(5)
    held = np.empty(2)
    together = np.empty(5)
    fewest = FEWEST_PLAIN if o.robust == PLAIN else FEWEST_ROBUST
    for lane in range(lanes):
        forget(memory)
        raw = np.nan
        variance = np.nan
        gamma = np.nan
        gamma_variance = np.nan
        was_frozen = False
        held[:] = np.nan
        together[:] = 0.0
        for k in range(epochs):
            count = 0
            if np.isfinite(phi[k, lane]):
                since = time[k] - time[0]
                tangent = np.tan(phi[k, lane])
                together[0] += 1.0
                together[1] += since
                together[2] += since * since
                together[3] += tangent
                together[4] += tangent * since
            for i in range(max(0, k - o.window + 1), k + 1):
                if np.isfinite(f[i, 0, lane]):
                    t[count] = time[i]
                    v[count] = f[i, 0, lane]
                    count += 1
            have = fit_line(t, v, count, o.sigma, o.robust, weight, line)
            fresh = have and line[2] < 0.0
            if have:
                for i in range(5):
                    out.line[k, i, lane] = line[i]
            if fresh:
                raw = line[0] - line[1] / line[2]
                out.line[k, 5, lane] = raw
                variance = (o.sigma / line[2]) ** 2 * (1.0 / line[4] + (raw - line[0]) ** 2 / line[3])
            tau = crossing(memory, 0, raw, variance, fresh, raw <= time[k], o.rule, o.delay, o.confirm)
            frozen = memory[0, FROZEN] > 0.0
            out.tau[k, lane] = tau
            out.frozen[k, lane] = frozen
            if not have:
                out.status[k, lane] = NO_LINE if k > 0 or count >= fewest else NO_DATA
                continue
            if not np.isfinite(tau):
                out.status[k, lane] = NO_CROSSING
                continue
            if not was_frozen and fresh:
                measured, n = mean_rate(rate, k, 0, lane, o.window)
                gamma, gamma_variance = slope_with_rate(line[2], line[3], measured, n, o.sigma, o.sigma_rate)
            was_frozen = frozen
            away = line[0] - tau
            if o.gamma == GAMMA_END and abs(away) >= o.zone:
                gamma = line[1] / away
                gamma_variance = (o.sigma / away) ** 2 / line[4]
            fc_count = line[4]
            omega, omega_variance = _angular_velocity(time, phi, k, lane, tau, o, t, v, weight, line, held, together)
            held[0] = omega
            held[1] = omega_variance
            out.gamma[k, lane] = gamma
            out.omega[k, lane] = omega
            below = o.wavelength * gamma - o.a * omega * omega
            s = o.a * o.wavelength * gamma / below
            if not np.isfinite(s) or not gamma < 0.0 or fc_count < fewest:
                out.status[k, lane] = NO_LINE if not np.isfinite(omega) else INVALID
                continue
            total = 0.0
            per = 0.0
            for i in range(k + 1):
                if np.isfinite(elevation[i, lane]):
                    rho = np.sqrt(s * s + (omega * s * (time[i] - tau)) ** 2)
                    total += np.tan(elevation[i, lane]) / rho
                    per += 1.0 / (rho * rho)
            if per > 0.0:
                out.height[k, lane] = total / per
                if o.with_height:
                    corrected = distance_at_height(gamma, omega, total / per, o.a, o.wavelength)
                    s = corrected if np.isfinite(corrected) else s
            out.theta[k, 0, lane] = tau
            out.theta[k, 1, lane] = s
            out.theta[k, 2, lane] = omega * s
            if not (s > 0.0 and s < o.a):
                out.status[k, lane] = INVALID
                continue
            seen = memory[0, CONFIRMED] > 0.0 if o.rule != NEVER else tau <= time[k]
            out.status[k, lane] = CROSSED if seen else EXTRAPOLATED
            # (19): ds/dgamma = -a^2 lambda omega^2 / below^2, ds/domega = 2 a^2 lambda gamma omega / below^2.
            by_gamma = -o.a * o.a * o.wavelength * omega * omega / (below * below)
            by_omega = 2.0 * o.a * o.a * o.wavelength * gamma * omega / (below * below)
            v_omega = s + omega * by_omega
            v_gamma = omega * by_gamma
            out.covariance[k, :, :, lane] = 0.0
            out.covariance[k, 0, 0, lane] = memory[0, KEPT_VARIANCE] if frozen else variance
            out.covariance[k, 1, 1, lane] = by_gamma**2 * gamma_variance + by_omega**2 * omega_variance
            out.covariance[k, 2, 2, lane] = v_gamma**2 * gamma_variance + v_omega**2 * omega_variance
            both = by_gamma * v_gamma * gamma_variance + by_omega * v_omega * omega_variance
            out.covariance[k, 1, 2, lane] = both
            out.covariance[k, 2, 1, lane] = both
