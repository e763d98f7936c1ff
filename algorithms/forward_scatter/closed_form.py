"""The paper's closed form: crossing times and angular velocity to distance and velocity, and their errors.

With D = tau_2 - tau_1, gamma = (c_11 + c_12) / 2 and omega = -(lambda / b) df (3):

    (14)  s = b / (omega D + b / a)                 v_y = omega s (15)
    (17)  omega = -(lambda / b) (c_12 tau_2 - c_11 tau_1), then (14)
    (18)  omega = -(lambda / b) gamma D, then (14)
    (19)  s = a lambda gamma / (lambda gamma - a omega^2)

(14) is in (0, a) if and only if omega D > 0. (17) as printed depends on the origin of time: it drops the term
(c_11 - c_12) t, so the caller chooses from where its times count. Errors follow from those of tau_1, tau_2, omega,
c_11 and c_12 by linearisation.

References
----------
scatter2014, eqs. (3), (10), (14)-(19); specification 4. Differences from the paper: predicted errors, origin of (17).
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import strict

FORMULAS = (14, 17, 18, 19)


@strict
def distance(formula, tau1, tau2, omega, slope1, slope2, origin, a, b, wavelength, out):
    """Put s, m, and the angular velocity that goes with it into `out` (2,); NaN where there is no such target.

    `origin` is the instant from which (17) counts.
    """
    gamma = 0.5 * (slope1 + slope2)
    between = tau2 - tau1
    if formula == 18:
        omega = -(wavelength / b) * gamma * between
    elif formula == 17:
        omega = -(wavelength / b) * (slope2 * (tau2 - origin) - slope1 * (tau1 - origin))
    if formula == 19:
        below = wavelength * gamma - a * omega * omega
        s = a * wavelength * gamma / below if gamma < 0.0 else np.nan
    else:
        below = omega * between + b / a
        s = b / below if below != 0.0 else np.nan
    out[0] = s
    out[1] = omega


@strict
def errors_of_answer(formula, value, covariance, origin, a, b, wavelength, answer):
    """Covariance of (tau, s, v_y) into `answer` (3, 3) from that of `value` = (tau_1, tau_2, omega, c_11, c_12)."""
    gradient = np.zeros((3, 5))
    high = np.empty(2)
    low = np.empty(2)
    moved = value.copy()
    gradient[0, 0] = 0.5
    gradient[0, 1] = 0.5
    for i in range(5):
        step = 1e-4 * np.sqrt(covariance[i, i])
        if step <= 0.0:
            continue
        moved[i] = value[i] + step
        distance(formula, moved[0], moved[1], moved[2], moved[3], moved[4], origin, a, b, wavelength, high)
        moved[i] = value[i] - step
        distance(formula, moved[0], moved[1], moved[2], moved[3], moved[4], origin, a, b, wavelength, low)
        moved[i] = value[i]
        gradient[1, i] = (high[0] - low[0]) / (2.0 * step)
        gradient[2, i] = (high[0] * high[1] - low[0] * low[1]) / (2.0 * step)
    for p in range(3):
        for q in range(p + 1):
            total = 0.0
            for i in range(5):
                for j in range(5):
                    total += gradient[p, i] * covariance[i, j] * gradient[q, j]
            answer[p, q] = total
            answer[q, p] = total
