"""Motion with constant tangential acceleration a and constant curvature K in the plane.

Parameters p = (x0, y0, g0, b, a, K) at the epoch t = 0: position in m, course in rad, speed in m/s, acceleration in
m/s^2, curvature in 1/m. X points north, Y east, angles run from X towards Y (clockwise from north), and K > 0 is a
right turn. With the way s = b t + a t^2 / 2 and u = K s / 2,

    X = x0 + s sinc(u) cos(g0 + u),  Y = y0 + s sinc(u) sin(g0 + u),  V = b + a t,  gamma = g0 + 2 u

holds exactly for every K, a and b including 0: course is K times the way, so no series and no integral is needed.
(g0, b, a, K) and (g0 + pi, -b, -a, -K) are the same motion; `with_forward_speed` chooses the one with b >= 0.

All functions take parameters with the axis of the six first and whatever axes behind it.

Differences from the paper: eq. (3), second line, prints y_R + R cos(gamma) where y_R - R cos(gamma) must stand; its
centre form, which has no straight flight, is replaced by the chord form above; its power series (4) is here for
comparison alone; three positions fix the six parameters exactly, the paper takes four.

References
----------
plots2006, eqs. (1)-(5); specification 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Below this the integrals of the Jacobian are taken from their series, whose first left-out term is then 1e-18.
SMALL_ANGLE = 0.01


def sinc(u: Floats) -> Floats:
    """sin(u) / u, 1 at 0."""
    out: Floats = np.sinc(u / np.pi)
    return out


def position(p: Floats, t: Floats) -> tuple[Floats, Floats]:
    """X and Y in m, t s after the epoch; p (6, ...) and t are broadcast against each other."""
    x0, y0, g0, b, a, curvature = p
    s = (b + 0.5 * a * t) * t
    u = 0.5 * curvature * s
    chord = s * sinc(u)
    return x0 + chord * np.cos(g0 + u), y0 + chord * np.sin(g0 + u)


def shifted(p: Floats, t: Floats) -> Floats:
    """The same motion with its epoch t s later: (6, ...)."""
    x, y = position(p, t)
    _, _, g0, b, a, curvature = p
    way = (b + 0.5 * a * t) * t
    return np.stack(np.broadcast_arrays(x, y, g0 + curvature * way, b + a * t, a, curvature))


def position_jacobian(p: Floats, t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """X and Y as `position` gives them, and their derivatives by the six parameters, (6, ...) each."""
    x0, y0, g0, b, a, curvature = p
    x, y = position(p, t)
    s = (b + 0.5 * a * t) * t
    w = curvature * s
    cosine, sine = _moments(w)
    gamma = g0 + w
    zero, one = np.zeros_like(x), np.ones_like(x)
    along, across = np.cos(gamma), np.sin(gamma)
    half = 0.5 * t * t
    to_x = (one, zero, -(y - y0), t * along, half * along, -s * s * (np.sin(g0) * cosine + np.cos(g0) * sine))
    to_y = (zero, one, x - x0, t * across, half * across, s * s * (np.cos(g0) * cosine - np.sin(g0) * sine))
    return x, y, np.stack(np.broadcast_arrays(*to_x)), np.stack(np.broadcast_arrays(*to_y))


def _moments(w: Floats) -> tuple[Floats, Floats]:
    """Integrals of tau cos(w tau) and tau sin(w tau) over 0 < tau < 1."""
    near = np.abs(w) < SMALL_ANGLE
    safe = np.where(near, 1.0, w)
    square = w * w
    cosine = (np.cos(safe) + safe * np.sin(safe) - 1.0) / safe**2
    sine = (np.sin(safe) - safe * np.cos(safe)) / safe**2
    return (
        np.where(near, 0.5 - square / 8.0 + square**2 / 144.0, cosine),
        np.where(near, w / 3.0 - w * square / 30.0 + w * square**2 / 840.0, sine),
    )


def from_three_positions(x: Floats, y: Floats, t: Floats) -> Floats:
    """Parameters of the one motion through three positions, at the epoch of the third: (6, ...).

    Parameters
    ----------
    x, y, t : (3, ...) m, m, s; times rising

    Exact for a turn of less than 360 degrees in all and no reversal of speed. NaN where two of the positions coincide:
    no direction joins them.
    """
    z = x + 1j * y
    d12, d23, d13 = z[1] - z[0], z[2] - z[1], z[2] - z[0]
    h12, h13 = t[1] - t[0], t[2] - t[0]
    apart = (np.abs(d12) > 0) & (np.abs(d23) > 0) & (np.abs(d13) > 0) & (h12 > 0) & (h13 > h12)
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = (np.conj(d12) * d23).imag
        curvature = 2.0 * cross / (np.abs(d12) * np.abs(d23) * np.abs(d13))
        at_third = np.arctan2(cross, (np.conj(d13) * d23).real)
        at_first = np.arctan2(cross, (np.conj(d12) * d13).real)
        s12 = np.abs(d12) / sinc(at_third)
        s13 = s12 + np.abs(d23) / sinc(at_first)
        a = 2.0 * (s13 / h13 - s12 / h12) / (h13 - h12)
        b = s12 / h12 - 0.5 * a * h12
        first = np.stack(np.broadcast_arrays(x[0], y[0], np.angle(d12) - at_third, b, a, curvature))
        out: Floats = np.where(apart, shifted(first, h13), np.nan)
    return out


def with_forward_speed(p: Floats) -> Floats:
    """The same motion with a speed b >= 0 and a course in (-pi, pi]."""
    back = p[3] < 0
    sign = np.where(back, -1.0, 1.0)
    course = wrapped(p[2] + np.where(back, np.pi, 0.0))
    return np.stack([p[0], p[1], course, sign * p[3], sign * p[4], sign * p[5]])


def wrapped(angle: Floats) -> Floats:
    """An angle in (-pi, pi]."""
    out: Floats = -np.remainder(-angle + np.pi, 2.0 * np.pi) + np.pi
    return out


def series_coefficients(p: Floats, order: int) -> NDArray[np.complex128]:
    """c_1 ... c_order of the paper's power series (4), (order, ...): derivatives of X + iY at 0, turned by -g0."""
    _, _, _, b, a, curvature = p
    c = [b + 0j, a + 1j * curvature * b * b]
    for n in range(2, order):
        c.append(1j * curvature * (b * c[n - 1] + n * a * c[n - 2]))
    return np.stack(np.broadcast_arrays(*c[:order]))


def position_by_series(p: Floats, t: Floats, order: int) -> tuple[Floats, Floats]:
    """X and Y by the series (4) cut after `order`; to show what the cut costs."""
    z = np.zeros(np.broadcast(p[0], t).shape, complex)
    term = np.ones_like(z)
    for n, c in enumerate(series_coefficients(p, order), start=1):
        term = term * t / n
        z = z + c * term
    z = p[0] + 1j * p[1] + np.exp(1j * p[2]) * z
    return z.real, z.imag
