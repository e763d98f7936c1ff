"""Tracks of one radar from converted plots: a constant-velocity Kalman filter, trials side by side.

State x = (x, vx, y, vy), per axis F = [[1, T], [0, 1]] and Q = q [[T^3/3, T^2/2], [T^2/2, T]]. The first two plots
start it: position z2, velocity (z2 - z1)/T, Pxx = R2, Pxv = R2/T, Pvv = (R1 + R2)/T^2 + (q T/3) I. Updates are in the
Joseph form. With `ducm` a plot's covariance comes from the prediction, which does not contain the plot; with `ekf`
nothing is converted after the start, and range and azimuth are linearised at the prediction.

References
----------
barshalom2001, chapter 5 and section 10.3; bordonaro2014; specification 7 E.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.pairs import Side
from algorithms.identification.parameters import TrackConversion
from algorithms.toolbox.frames.polar_conversion import Prediction, plane_components, wrapped

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

X, VX, Y, VY = range(4)
PLACE = (X, Y)
LEAST_RANGE_M = 1e-6


def product(a: Floats, b: Floats) -> Floats:
    """(n, k, L) times (k, m, L): sums in a fixed order, so that a trial's bytes do not depend on the others."""
    out: Floats = a[:, 0, None] * b[None, 0]
    for k in range(1, a.shape[1]):
        out = out + a[:, k, None] * b[None, k]
    return out


def transposed(a: Floats) -> Floats:
    """Swap rows and columns of (n, m, L)."""
    return np.swapaxes(a, 0, 1)


def transition(period: Floats) -> Floats:
    """(4, 4, L) F for periods (L,) s."""
    f = np.zeros((4, 4, period.size))
    for i in range(4):
        f[i, i] = 1.0
    f[X, VX] = f[Y, VY] = period
    return f


def process_noise(period: Floats, density: float) -> Floats:
    """(4, 4, L) Q for periods (L,) s and a density in m2/s3."""
    q = np.zeros((4, 4, period.size))
    for a, b in ((X, VX), (Y, VY)):
        q[a, a] = density * period**3 / 3
        q[a, b] = q[b, a] = density * period**2 / 2
        q[b, b] = density * period
    return q


@dataclass
class Step:
    """One instant of a track: state (4, L) and covariance (4, 4, L) after it, gain (4, 2, L), zero where no plot."""

    time_s: float
    state: Floats
    covariance: Floats
    gain: Floats
    started: Bools


@dataclass
class Track:
    """A track of one radar over L trials.

    Attributes
    ----------
    rows : positions of its plots in the recording
    steps : one for each row; state and covariance are NaN in trials with fewer than two plots so far
    """

    rows: NDArray[np.int64]
    steps: list[Step] = field(default_factory=list)

    def at(self, time_s: float, density: float) -> tuple[Floats, Floats]:
        """State and covariance predicted from the last instant not after `time_s`."""
        last = None
        for step in self.steps:
            if step.time_s <= time_s:
                last = step
        if last is None:
            lanes = self.steps[0].state.shape[1]
            return np.full((4, lanes), np.nan), np.full((4, 4, lanes), np.nan)
        return predicted(last.state, last.covariance, np.full(last.state.shape[1], time_s - last.time_s), density)


def predicted(state: Floats, covariance: Floats, period: Floats, density: float) -> tuple[Floats, Floats]:
    """State and covariance a period (L,) s later."""
    f = transition(period)
    x = product(f, state[:, None])[:, 0]
    return x, product(product(f, covariance), transposed(f)) + process_noise(period, density)


def filtered(rows: NDArray[np.int64], time_s: Floats, side: Side, conversion: TrackConversion, density: float) -> Track:
    """Filter the plots of one target: side holds (n, L) plots in the order of time."""
    n, lanes = side.range_m.shape
    track = Track(rows)
    x = np.full((4, lanes), np.nan)
    p = np.full((4, 4, lanes), np.nan)
    first = np.full((5, lanes), np.nan)
    first_time = np.full(lanes, np.nan)
    count = np.zeros(lanes, np.int64)
    for k in range(n):
        here = np.isfinite(side.range_m[k])
        if k:
            x, p = predicted(x, p, np.full(lanes, time_s[k] - time_s[k - 1]), density)
        plain = _converted(side, k, "mucm" if conversion in ("ducm", "polar", "ekf") else conversion)
        z = plain
        if conversion == "ducm":
            z = np.where(count >= 2, _converted(side, k, conversion, _reference(side, x, p)), plain)
        started_x, started_p = _two_points(first, plain, time_s[k] - first_time, density)
        updated_x, updated_p, gain = _updated_polar(x, p, side, k) if conversion == "ekf" else _updated(x, p, z)
        running, starting = here & (count >= 2), here & (count == 1)
        x = np.where(running, updated_x, np.where(starting, started_x, x))
        p = np.where(running, updated_p, np.where(starting, started_p, p))
        first = np.where(here & (count == 0), plain, first)
        first_time = np.where(here & (count == 0), time_s[k], first_time)
        count = count + here
        track.steps.append(Step(float(time_s[k]), x, p, np.where(running, gain, 0.0), count >= 2))
    return track


def _converted(side: Side, k: int, conversion: TrackConversion, reference: Prediction | None = None) -> Floats:
    """(5, L): x, y in the common plane, xx, yy, xy of one plot."""
    assert conversion != "polar"
    assert conversion != "ekf"
    b = side.angle_rad[k]
    x, y, *covariance = plane_components(
        side.range_m[k], np.cos(b), np.sin(b), side.sigma_range, side.sigma_angle, conversion, reference
    )
    return np.stack([x + side.site[0], y + side.site[1], *covariance])


def _reference(side: Side, x: Floats, p: Floats) -> Prediction:
    """Range and angle of the prediction with the projections of its covariance."""
    dx, dy = x[X] - side.site[0], x[Y] - side.site[1]
    r = np.hypot(dx, dy)
    ux, uy = dx / r, dy / r
    along = ux * ux * p[X, X] + 2 * ux * uy * p[X, Y] + uy * uy * p[Y, Y]
    across = uy * uy * p[X, X] - 2 * ux * uy * p[X, Y] + ux * ux * p[Y, Y]
    return Prediction(r, np.arctan2(dy, dx), along, across / (r * r))


def _two_points(first: Floats, second: Floats, period: Floats, density: float) -> tuple[Floats, Floats]:
    x1, y1, xx1, yy1, xy1 = first
    x2, y2, xx2, yy2, xy2 = second
    x = np.stack([x2, (x2 - x1) / period, y2, (y2 - y1) / period])
    p = np.empty((4, 4, x2.size))
    for i, j, r1, r2, own in ((X, X, xx1, xx2, 1.0), (Y, Y, yy1, yy2, 1.0), (X, Y, xy1, xy2, 0.0)):
        p[i, j] = p[j, i] = r2
        p[i, j + 1] = p[j + 1, i] = r2 / period
        p[i + 1, j] = p[j, i + 1] = r2 / period
        p[i + 1, j + 1] = p[j + 1, i + 1] = (r1 + r2) / period**2 + own * density * period / 3
    return x, p


def _updated(x: Floats, p: Floats, z: Floats) -> tuple[Floats, Floats, Floats]:
    """State, covariance and gain after a converted plot z (5, L), Joseph form."""
    lanes = x.shape[1]
    r = np.empty((2, 2, lanes))
    r[0, 0], r[1, 1] = z[2], z[3]
    r[0, 1] = r[1, 0] = z[4]
    s = p[np.ix_(PLACE, PLACE)] + r
    determinant = s[0, 0] * s[1, 1] - s[0, 1] * s[1, 0]
    inverse = np.empty_like(s)
    inverse[0, 0], inverse[1, 1] = s[1, 1] / determinant, s[0, 0] / determinant
    inverse[0, 1], inverse[1, 0] = -s[0, 1] / determinant, -s[1, 0] / determinant
    gain = product(p[:, PLACE], inverse)
    innovation = np.stack([z[0] - x[X], z[1] - x[Y]])
    a = without(gain)
    after = product(product(a, p), transposed(a)) + product(product(gain, r), transposed(gain))
    return x + product(gain, innovation[:, None])[:, 0], (after + transposed(after)) / 2, gain


def _updated_polar(x: Floats, p: Floats, side: Side, k: int) -> tuple[Floats, Floats, Floats]:
    """State, covariance and gain after a range and an azimuth as they are; the gain as of a converted plot."""
    dx, dy = x[X] - side.site[0], x[Y] - side.site[1]
    r = np.maximum(np.hypot(dx, dy), LEAST_RANGE_M)
    ux, uy = dx / r, dy / r
    h = np.stack([np.stack([ux, uy]), np.stack([-uy / r, ux / r])])
    cross = product(p[:, PLACE], transposed(h))
    s = product(h, cross[list(PLACE)])
    variances = (side.sigma_range**2, side.sigma_angle**2)
    s[0, 0] += variances[0]
    s[1, 1] += variances[1]
    determinant = s[0, 0] * s[1, 1] - s[0, 1] * s[1, 0]
    inverse = np.stack([np.stack([s[1, 1], -s[0, 1]]), np.stack([-s[1, 0], s[0, 0]])]) / determinant
    polar_gain = product(cross, inverse)
    innovation = np.stack([side.range_m[k] - r, wrapped(side.angle_rad[k] - np.arctan2(dy, dx))])
    gain = product(polar_gain, h)
    a = without(gain)
    noise = np.stack([polar_gain[:, i] * variances[i] for i in (0, 1)], axis=1)
    after = product(product(a, p), transposed(a)) + product(noise, transposed(polar_gain))
    return x + product(polar_gain, innovation[:, None])[:, 0], (after + transposed(after)) / 2, gain


def without(gain: Floats) -> Floats:
    """(4, 4, L): I - K H."""
    a = np.zeros((4, 4, gain.shape[2]))
    for i in range(4):
        a[i, i] = 1.0
    a[:, X] -= gain[:, 0]
    a[:, Y] -= gain[:, 1]
    return a


def cross_covariance(a: Track, b: Track, time_s: float, density: float) -> Floats:
    """(4, 4, L) covariance of the two tracks' errors, which their target's manoeuvres bring about.

    At the start (q T/3) on the velocities; then P12 <- (I - K1 H)(F P12 F' + Q)(I - K2 H)' at every instant, with a
    gain of zero where a track has no plot.
    """
    lanes = a.steps[0].state.shape[1]
    p = np.zeros((4, 4, lanes))
    begun = np.zeros(lanes, np.bool_)
    before = None
    gains = ({s.time_s: s for s in a.steps}, {s.time_s: s for s in b.steps})
    for now in sorted(t for t in {*gains[0], *gains[1]} if t <= time_s):
        period = 0.0 if before is None else now - before
        steps = [g.get(now) for g in gains]
        if begun.any():
            f = transition(np.full(lanes, period))
            moved = product(product(f, p), transposed(f)) + process_noise(np.full(lanes, period), density)
            for side, step in enumerate(steps):
                if step is not None:
                    w = without(step.gain)
                    moved = product(w, moved) if side == 0 else product(moved, transposed(w))
            p = np.where(begun, moved, p)
        running = _running(a, now) & _running(b, now)
        fresh = running & ~begun
        if fresh.any():
            start = np.zeros((4, 4, lanes))
            start[VX, VX] = start[VY, VY] = density * period / 3
            p = np.where(fresh, start, p)
            begun = begun | fresh
        before = now
    if before is not None and time_s > before:
        f = transition(np.full(lanes, time_s - before))
        p = product(product(f, p), transposed(f)) + process_noise(np.full(lanes, time_s - before), density)
    return np.where(begun, p, 0.0)


def _running(track: Track, time_s: float) -> Bools:
    out = np.zeros(track.steps[0].state.shape[1], np.bool_)
    for step in track.steps:
        if step.time_s <= time_s:
            out = step.started
    return out
