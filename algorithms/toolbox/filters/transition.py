"""How model probabilities change over any interval: P(dt) = P^(dt / dt0) of a Markov chain given for dt0.

Inside, P[j, i] is the probability **from i to j** and columns sum to 1 (the paper prints it so); at the interface
`transition` is its transpose, row = from, as libraries have it.

Whole powers are repeated squarings. Others come from the eigenvalues, P^s = V diag(lambda^s) V^-1, or, without a full
set of eigenvectors, from the generator. A chain need not have a stochastic root: entries down to -1e-4 are clipped to
zero, and how much that was is returned; the columns are then scaled to 1.

References
----------
trudymai2023, eq. (8), which gives whole powers only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.toolbox.kernels import LANES, bare, kernel
from algorithms.toolbox.kernels.flat import woven

Floats = NDArray[np.float64]

SUM_TOLERANCE = 1e-9
LARGEST_CLIP = 1e-4
LN_ZERO = -1e30
"""Logarithm of a probability of exactly zero."""


class Chains(NamedTuple):
    """Markov chains over the same N models, one for each region and, last, for everywhere else."""

    base: Floats
    """(C, N, N) P of the base interval, column = from"""
    values: Floats
    """(C, N) its eigenvalues"""
    vectors: Floats
    inverse: Floats
    generator: Floats
    """(C, N, N) ln P, where it has no full set of eigenvectors; else zeros"""
    diagonal: NDArray[np.int64]
    """(C,) 1 = the eigenvectors are used"""
    rooted: NDArray[np.int64]
    """(C,) 1 = powers that are not whole exist"""
    step_s: float


def check_rows(transition: Sequence[Sequence[float]], models: int, pointer: str = "/transition") -> Floats:
    """Check a matrix given row = from and return it column = from.

    Raises
    ------
    ParameterError
        Wrong size, an entry outside 0 to 1, a row that does not sum to one (and whether the matrix looks transposed).
    """
    if len(transition) != models or any(len(row) != models for row in transition):
        sizes = "x".join(str(n) for n in (len(transition), max((len(row) for row in transition), default=0)))
        raise ParameterError(
            f"The transition matrix is {sizes} for {models} models.",
            pointer=pointer,
            remedy="Give one row and one column for each model, in their order.",
            code="transition_size",
        )
    rows = np.array(transition, float).reshape(models, models)
    bad = np.argwhere(~((rows >= 0) & (rows <= 1)))
    if bad.size:
        i, j = (int(n) for n in bad[0])
        raise ParameterError(
            f"The transition probability from model {i + 1} to model {j + 1} is {rows[i, j]:g}.",
            pointer=f"{pointer}/{i}/{j}",
            remedy="Probabilities lie between 0 and 1.",
            code="transition_entry",
        )
    wrong = np.flatnonzero(np.abs(rows.sum(axis=1) - 1) > SUM_TOLERANCE)
    if wrong.size:
        i = int(wrong[0])
        turned = bool((np.abs(rows.sum(axis=0) - 1) <= SUM_TOLERANCE).all())
        hint = "Its columns sum to 1: it looks transposed; a row says where to go from its model." if turned else ""
        raise ParameterError(
            f"Row {i + 1} of the transition matrix sums to {rows[i].sum():.12g}, not to 1.",
            pointer=f"{pointer}/{i}",
            remedy=hint or "Change the row so that its probabilities sum to 1.",
            code="transition_transposed" if turned else "transition_sum",
        )
    return np.ascontiguousarray(rows.T)


def chains_of(columns: Sequence[Floats], step_s: float) -> Chains:
    """Prepare chains, each (N, N) with column = from, for powers."""
    base = np.stack(columns)
    n = base.shape[1]
    values, vectors, inverse, generator = (np.zeros((len(base), n)), *(np.zeros(base.shape) for _ in range(3)))
    diagonal, rooted = np.zeros(len(base), np.int64), np.zeros(len(base), np.int64)
    for c, p in enumerate(base):
        lam, v = np.linalg.eig(p)
        if (np.abs(np.imag(lam)) > 1e-9).any() or (np.real(lam) <= 0).any():
            continue
        rooted[c] = 1
        v = np.real(v)
        if np.linalg.cond(v) < 1e8:
            diagonal[c] = 1
            values[c], vectors[c], inverse[c] = np.real(lam), v, np.linalg.inv(v)
        else:
            from scipy.linalg import logm

            generator[c] = np.real(logm(p))
    return Chains(base, values, vectors, inverse, generator, diagonal, rooted, float(step_s))


def check_times(chains: Chains, intervals_s: Floats, pointer: str = "/transition") -> float:
    """Refuse intervals that a chain has no power for, before anything is filtered; return the largest clip.

    Raises
    ------
    ParameterError
        A chain without a real root meets an interval that is no whole multiple of the base interval, or a power has an
        entry below -1e-4.
    """
    largest = 0.0
    out = np.empty(chains.base.shape[1:])
    for dt in np.unique(np.round(intervals_s / chains.step_s, 9)) * chains.step_s:
        for c in range(len(chains.base)):
            clip = float(transition_power(chains, c, dt, out))
            if np.isnan(clip) or clip > LARGEST_CLIP:
                raise ParameterError(
                    "This transition matrix cannot be used with irregular times: "
                    f"its power {dt / chains.step_s:g} holds no probabilities.",
                    pointer=pointer,
                    remedy="Make the chance to stay larger than one half, or choose a base interval that divides "
                    "all intervals between measurements.",
                    code="transition_root",
                )
            largest = max(largest, clip)
    return largest


def transition_over(columns: Floats, ratio: float) -> tuple[Floats, float]:
    """P^ratio of a chain (N, N), column = from, and how much was clipped (NaN: it has no such power)."""
    out = np.empty(columns.shape)
    clip = float(transition_power(chains_of([columns], 1.0), 0, ratio, out))
    return out, clip


@bare
def _matrix_product(a, b, out):
    """Write a b of two (N, N) matrices."""
    n = a.shape[0]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += a[i, k] * b[k, j]
            out[i, j] = total


@bare
def _copy_matrix(source, target):
    """Copy (N, N) numbers: without a slice, which costs the compiler seconds."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            target[i, j] = source[i, j]


@bare
def power_of(chains, dt):
    """Dt over the base interval, to the ninth digit: instants that rounding moved apart have the same power."""
    return np.floor(dt / chains.step_s * 1e9 + 0.5) / 1e9


@kernel
def transition_power(chains, c, dt, out):
    """Write P^(dt / dt0) of chain c into `out`, column = from; return the largest clip, NaN where there is no power."""
    n = out.shape[0]
    s = power_of(chains, dt)
    whole = np.floor(s + 0.5)
    if s == whole:
        square, keep = np.empty((n, n)), np.empty((n, n))
        for i in range(n):
            for j in range(n):
                square[i, j] = chains.base[c, i, j]
                out[i, j] = 1.0 if i == j else 0.0
        left = int(whole)
        while left > 0:
            if left % 2 == 1:
                _matrix_product(square, out, keep)
                _copy_matrix(keep, out)
            left //= 2
            if left > 0:
                _matrix_product(square, square, keep)
                _copy_matrix(keep, square)
                _scale_columns(square)
    elif chains.rooted[c] == 0:
        return np.nan
    elif chains.diagonal[c] == 1:
        for i in range(n):
            for j in range(n):
                total = 0.0
                for k in range(n):
                    total += chains.vectors[c, i, k] * chains.values[c, k] ** s * chains.inverse[c, k, j]
                out[i, j] = total
    else:
        _exponential(chains.generator[c], s, out)
    clip = 0.0
    for i in range(n):
        for j in range(n):
            # What rounding leaves of a zero in a sum over eigenvalues is no clip, and no probability either.
            if s != whole and out[i, j] < 1e-15:
                if out[i, j] < -1e-12:
                    clip = max(clip, -out[i, j])
                out[i, j] = 0.0
    _scale_columns(out)
    return clip


@bare
def _scale_columns(p):
    """Scale the columns to sums of 1."""
    n = p.shape[0]
    for j in range(n):
        total = 0.0
        for i in range(n):
            total += p[i, j]
        for i in range(n):
            p[i, j] /= total


@kernel
def _exponential(g, s, out):
    """Write exp(s g) by scaling, the series, and squaring."""
    n = g.shape[0]
    norm = 0.0
    for i in range(n):
        for j in range(n):
            norm = max(norm, abs(s * g[i, j]) * n)
    halvings = 0
    while norm > 0.5:
        norm *= 0.5
        halvings += 1
    scaled, term, keep = np.empty((n, n)), np.empty((n, n)), np.empty((n, n))
    for i in range(n):
        for j in range(n):
            scaled[i, j] = g[i, j] * (s / 2.0**halvings)
            term[i, j] = 1.0 if i == j else 0.0
            out[i, j] = term[i, j]
    for k in range(1, 19):
        _matrix_product(scaled, term, keep)
        for i in range(n):
            for j in range(n):
                term[i, j] = keep[i, j] / k
                out[i, j] += term[i, j]
    for _ in range(halvings):
        _matrix_product(out, out, keep)
        _copy_matrix(keep, out)


@woven
def transitions(chains, region, dt, work):
    """Bring P(dt) and ln P(dt), (N, N, LANES), up to date for each lane; return the largest clip of what was computed.

    Of `work` (`multiple_model.Work`) `known_power` and `known_region` say for what each lane's part was computed.
    """
    n = work.transition.shape[0]
    clip = 0.0
    last = -1
    for lane in range(LANES):
        power = power_of(chains, dt[lane])
        if power == work.known_power[lane] and region[lane] == work.known_region[lane]:
            continue
        work.known_power[lane] = power
        work.known_region[lane] = region[lane]
        if last >= 0 and power == work.known_power[last] and region[lane] == region[last]:
            for i in range(n):
                for j in range(n):
                    work.transition[i, j, lane] = work.transition[i, j, last]
                    work.log_transition[i, j, lane] = work.log_transition[i, j, last]
            continue
        found = transition_power(chains, region[lane], dt[lane], work.matrix)
        clip = found if np.isnan(found) else max(clip, found)
        for i in range(n):
            for j in range(n):
                p = work.matrix[i, j]
                work.transition[i, j, lane] = p
                work.log_transition[i, j, lane] = np.log(p) if p > 0.0 else LN_ZERO
        last = lane
    return clip
