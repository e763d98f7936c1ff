"""A straight flight fitted to ranges and angles, without converting anything: the exact test of two tracks.

theta = (x, vx, y, vy) at the last instant minimises the sum of the squared normalised residuals of all plots of one or
several radars, by Gauss-Newton steps that are damped where one makes the sum grow. The minimum over both radars less
the two minima of each radar alone is chi-square with 4 degrees of freedom where both saw one target that does not
manoeuvre.

References
----------
more1978; specification 7 E (track-level likelihood ratio).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.pairs import Side
from algorithms.identification.tracks import VX, VY, X, Y
from algorithms.toolbox.frames.polar_conversion import wrapped

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

STEPS = 25
CONVERGED = 1e-9
LEAST_RANGE_M = 1e-6
# Two plots of a radar are the fewest that have a velocity.
FEWEST_PLOTS = 2


@dataclass(frozen=True)
class Flight:
    """Plots of one radar (T, L) at instants (T,) s."""

    time_s: Floats
    side: Side


def straight_fit(flights: Sequence[Flight], start: Floats, reference_s: float) -> tuple[Floats, Floats]:
    """(L,) least sums of squares and (4, L) flights; NaN where the start is.

    Parameters
    ----------
    flights : of one target, one for each radar
    start : (4, L) at `reference_s`
    """
    theta = start.copy()
    value = _objective(flights, theta, reference_s)
    damping = np.zeros(value.shape)
    active = np.isfinite(value)
    for _ in range(STEPS):
        if not active.any():
            break
        normal, gradient = _normal(flights, theta, reference_s)
        for i in range(4):
            normal[:, i, i] *= 1 + damping
        # Lanes that are done, or were never begun, get a harmless matrix.
        normal[~active] = np.eye(4)
        step = np.linalg.solve(normal, gradient[:, :, None])[:, :, 0].T
        trial = theta + np.where(active, step, 0.0)
        after = _objective(flights, trial, reference_s)
        better = active & (after <= value)
        negligible = active & (np.abs(after - value) <= CONVERGED * (1 + value))
        theta = np.where(better, trial, theta)
        value = np.where(better, after, value)
        damping = np.where(better, damping * 0.1, np.maximum(damping * 10, 1e-3))
        active = active & ~negligible
    return value, theta


def _residuals(flight: Flight, theta: Floats, reference_s: float) -> tuple[Floats, ...]:
    """Offsets, distances and normalised residuals, each (T, L); residuals are 0 where there is no plot."""
    tau = (flight.time_s - reference_s)[:, None]
    dx = theta[X] + tau * theta[VX] - flight.side.site[0]
    dy = theta[Y] + tau * theta[VY] - flight.side.site[1]
    distance = np.maximum(np.hypot(dx, dy), LEAST_RANGE_M)
    here = np.isfinite(flight.side.range_m)
    along = np.where(here, (flight.side.range_m - distance) / flight.side.sigma_range, 0.0)
    across = np.where(here, wrapped(flight.side.angle_rad - np.arctan2(dy, dx)) / flight.side.sigma_angle, 0.0)
    return dx, dy, distance, along, across, here


def _objective(flights: Sequence[Flight], theta: Floats, reference_s: float) -> Floats:
    total = np.zeros(theta.shape[1])
    for flight in flights:
        _, _, _, along, across, _ = _residuals(flight, theta, reference_s)
        for k in range(len(flight.time_s)):
            total = total + along[k] * along[k] + across[k] * across[k]
    return total


def _normal(flights: Sequence[Flight], theta: Floats, reference_s: float) -> tuple[Floats, Floats]:
    """(L, 4, 4) information and (L, 4) gradient."""
    lanes = theta.shape[1]
    info, gradient = np.zeros((lanes, 4, 4)), np.zeros((lanes, 4))
    for flight in flights:
        dx, dy, distance, along, across, here = _residuals(flight, theta, reference_s)
        ux, uy = dx / distance, dy / distance
        wr = here / flight.side.sigma_range
        wb = here / (distance * flight.side.sigma_angle)
        tau = flight.time_s - reference_s
        for k in range(len(tau)):
            for hx, hy, residual in (
                (ux[k] * wr[k], uy[k] * wr[k], along[k]),
                (-uy[k] * wb[k], ux[k] * wb[k], across[k]),
            ):
                row = (hx, tau[k] * hx, hy, tau[k] * hy)
                for i in range(4):
                    gradient[:, i] += row[i] * residual
                    for j in range(4):
                        info[:, i, j] += row[i] * row[j]
    return info, gradient


def straight_track(flight: Flight, start: Floats, reference_s: float) -> tuple[Floats, Floats]:
    """States (4, L) at `reference_s` and covariances (4, 4, L) of one radar's plots; NaN with fewer than two plots."""
    _, theta = straight_fit([flight], start, reference_s)
    info, _ = _normal([flight], theta, reference_s)
    enough = (np.isfinite(flight.side.range_m).sum(axis=0) >= FEWEST_PLOTS) & np.isfinite(theta[0])
    info[~enough] = np.eye(4)
    covariance = np.where(enough, np.moveaxis(np.linalg.inv(info), 0, 2), np.nan)
    return np.where(enough, theta, np.nan), covariance


def likelihood_ratio(a: Flight, b: Flight, starts: tuple[Floats, Floats], reference_s: float) -> Floats:
    """(L,) sum of squares of one common flight less those of two separate ones; NaN with fewer than two plots."""
    enough = np.ones(starts[0].shape[1], np.bool_)
    for flight in (a, b):
        enough &= np.isfinite(flight.side.range_m).sum(axis=0) >= FEWEST_PLOTS
    alone = [straight_fit([f], s, reference_s) for f, s in zip((a, b), starts, strict=True)]
    together, _ = straight_fit([a, b], (alone[0][1] + alone[1][1]) / 2, reference_s)
    out: Floats = np.where(enough, np.maximum(together - alone[0][0] - alone[1][0], 0.0), np.nan)
    return out
