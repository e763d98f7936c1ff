"""Symmetric matrices as packed lower triangles: element (i, j), i >= j, stands at i (i + 1) / 2 + j."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.kernels import kernel

Floats = NDArray[np.float64]


def pack(full: Floats) -> Floats:
    """(n, n, ...) symmetric -> (n (n + 1) / 2, ...) lower triangle, row by row."""
    rows, columns = np.tril_indices(full.shape[0])
    return np.ascontiguousarray(full[rows, columns])


def unpack(packed: Floats, axis: int = 0) -> Floats:
    """Undo `pack`: the packed axis becomes two axes of length n at the same place."""
    packed = np.moveaxis(packed, axis, 0)
    n = int((np.sqrt(8 * packed.shape[0] + 1) - 1) / 2)
    full = np.empty((n, n, *packed.shape[1:]))
    rows, columns = np.tril_indices(n)
    full[rows, columns] = packed
    full[columns, rows] = packed
    return np.moveaxis(full, (0, 1), (axis, axis + 1))


@kernel
def position_block(p, n_axis, lane, out):
    """Copy the six position elements of one lane's packed covariance (positions at 0, n_axis, 2 n_axis)."""
    k = 0
    for a in range(3):
        i = a * n_axis
        for b in range(a + 1):
            out[k] = p[i * (i + 1) // 2 + b * n_axis, lane]
            k += 1


@kernel
def solve3(s, b, out):
    """Solve S x = b for a packed symmetric positive definite 3 x 3 matrix by Cholesky; False where it is not."""
    l00 = s[0]
    if not l00 > 0.0:
        return False
    l00 = np.sqrt(l00)
    l10 = s[1] / l00
    d = s[2] - l10 * l10
    if not d > 0.0:
        return False
    l11 = np.sqrt(d)
    l20 = s[3] / l00
    l21 = (s[4] - l20 * l10) / l11
    d = s[5] - l20 * l20 - l21 * l21
    if not d > 0.0:
        return False
    l22 = np.sqrt(d)
    y0 = b[0] / l00
    y1 = (b[1] - l10 * y0) / l11
    y2 = (b[2] - l20 * y0 - l21 * y1) / l22
    out[2] = y2 / l22
    out[1] = (y1 - l21 * out[2]) / l11
    out[0] = (y0 - l10 * out[1] - l20 * out[2]) / l00
    return True


@kernel
def invert3(s, out):
    """Invert a packed symmetric positive definite 3 x 3 matrix; False where it is not."""
    c00 = s[2] * s[5] - s[4] * s[4]
    c10 = s[3] * s[4] - s[1] * s[5]
    c20 = s[1] * s[4] - s[2] * s[3]
    det = s[0] * c00 + s[1] * c10 + s[3] * c20
    scale = s[0] * s[2] * s[5]
    if not (s[0] > 0.0 and det > 1e-14 * scale):
        return False
    out[0] = c00 / det
    out[1] = c10 / det
    out[2] = (s[0] * s[5] - s[3] * s[3]) / det
    out[3] = c20 / det
    out[4] = (s[1] * s[3] - s[0] * s[4]) / det
    out[5] = (s[0] * s[2] - s[1] * s[1]) / det
    return True
