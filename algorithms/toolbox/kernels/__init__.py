"""Compiled small-matrix arithmetic over many trials side by side.

A filter works on a *block* of `LANES` trials: states have the shape `(n, LANES)`, covariances are packed lower
triangles `(n (n + 1) / 2, LANES)`, the trial index innermost and contiguous, so that the compiler turns each
arithmetic line into vector instructions. A short block is padded with idle lanes; one uploaded recording is a block
with one busy lane. One compiled length means that results do not depend on how trials are cut into blocks.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import numba

from algorithms.toolbox.kernels.cache import KernelCache

LANES = 16
"""Trials side by side: 16 keep a nine-state filter inside the first-level cache."""


def _compiled(**options: Any) -> Callable[[Any], Any]:
    """Return numba's decorator with `options`, whose machine code is kept on disk under the key of its sources."""

    def decorate(function: Any) -> Any:
        dispatcher = numba.njit(nogil=True, error_model="numpy", **options)(function)
        # A read-only home is no reason not to run: numba then compiles anew in each process.
        with contextlib.suppress(OSError):
            dispatcher._cache = KernelCache(function)
        return dispatcher

    return decorate


# `contract` alone (fused multiply-add): the other fast-math flags change results with the surroundings.
kernel = _compiled(fastmath={"contract"}, _nrt=True)
inlined = _compiled(fastmath={"contract"}, inline="always")
# For functions that create no array (the compiler refuses one that does): without the counting of references, which is
# atomic and took a third of a multiple-model step, a slice or an argument costs nothing. Nothing is fused here: the
# compiler cuts the loop over lanes into pieces and fused differently in each, so that a last digit hung on the lane.
bare = _compiled(_nrt=False)
# Where an iteration ends by comparing numbers, a last digit can decide: here no two operations may be fused, so that
# the result does not depend on how the compiler cut the code that surrounds it.
strict = _compiled()

__all__ = ["LANES", "bare", "inlined", "kernel", "strict"]
