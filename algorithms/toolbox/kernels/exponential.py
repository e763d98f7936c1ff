"""Exponential and logarithm as polynomials, which the compiler puts side by side in a loop over lanes.

The mathematics library takes one number at a time, which cost a multiple-model step more than its mixing. Errors stay
below two units in the last place. The reductions and the logarithm's polynomial are those of fdlibm (e_exp.c, e_log.c).
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import LANES, bare
from algorithms.toolbox.kernels.fused import fma

LOG2_E = 1.4426950408889634
LN2_HIGH = 6.93147180369123816490e-01
LN2_LOW = 1.90821492927058770002e-10
# Below this the exponential counts as zero: no double is smaller than e^-708 without losing digits.
SMALLEST = -700.0


@bare
def exponential(x):
    """Return exp(x), x <= 700; 0 below `SMALLEST`."""
    small = x < SMALLEST
    v = SMALLEST if small else x
    n = np.floor(fma(v, LOG2_E, 0.5))
    r = fma(-n, LN2_LOW, fma(-n, LN2_HIGH, v))
    p = 1.0 / 6227020800.0
    p = fma(p, r, 1.0 / 479001600.0)
    p = fma(p, r, 1.0 / 39916800.0)
    p = fma(p, r, 1.0 / 3628800.0)
    p = fma(p, r, 1.0 / 362880.0)
    p = fma(p, r, 1.0 / 40320.0)
    p = fma(p, r, 1.0 / 5040.0)
    p = fma(p, r, 1.0 / 720.0)
    p = fma(p, r, 1.0 / 120.0)
    p = fma(p, r, 1.0 / 24.0)
    p = fma(p, r, 1.0 / 6.0)
    p = fma(p, r, 0.5)
    p = fma(p, r, 1.0)
    p = fma(p, r, 1.0)
    scale = np.int64((np.int64(n) + 1023) << 52).view(np.float64)
    return 0.0 if small else p * scale


@bare
def logarithm(x):
    """Return ln(x) of a positive normal number."""
    b = np.float64(x).view(np.int64)
    # Mantissa within sqrt(1/2) to sqrt(2): what exceeds 1.41421356 goes into the exponent.
    up = ((b & 0xFFFFFFFFFFFFF) + 0x95F6400000000) & 0x10000000000000
    k = np.float64((b >> 52) - 1023 + (up >> 52))
    f = np.int64((b & 0xFFFFFFFFFFFFF) | (up ^ 0x3FF0000000000000)).view(np.float64) - 1.0
    s = f / (2.0 + f)
    z = s * s
    r = fma(z, 1.479819860511658591e-01, 1.531383769920937332e-01)
    r = fma(z, r, 1.818357216161805012e-01)
    r = fma(z, r, 2.222219843214978396e-01)
    r = fma(z, r, 2.857142874366239149e-01)
    r = fma(z, r, 3.999999999940941908e-01)
    r = z * fma(z, r, 6.666666666666735130e-01)
    half = 0.5 * f * f
    return fma(k, LN2_HIGH, f - (half - fma(s, half + r, k * LN2_LOW)))


@bare
def exp_row(x, out):
    """Write exp(x), x <= 700, of a row (LANES,). `out` may be `x`."""
    for lane in range(LANES):
        out[lane] = exponential(x[lane])


@bare
def log_row(x, out):
    """Write ln(x) of a row (LANES,) of positive normal numbers; `out` may be `x`."""
    for lane in range(LANES):
        out[lane] = logarithm(x[lane])
