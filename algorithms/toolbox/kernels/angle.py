"""The angle of a point as a rational function, which the compiler puts side by side in a loop over lanes.

The quotient of the smaller coordinate by the larger one lies within 0 to 1, and above 0.66 is counted from 45 degrees.
The error stays below two units in the last place of a quarter turn. The coefficients are those of Cephes (atan.c).
"""

from __future__ import annotations

import numpy as np

from algorithms.toolbox.kernels import bare
from algorithms.toolbox.kernels.fused import fma

QUARTER = float(np.pi / 4)


@bare
def arctangent2(y, x):
    """Return the angle of the point (x, y) from the first axis, -pi to pi; 0 at the origin."""
    ax, ay = abs(x), abs(y)
    long = max(ax, ay)
    t = min(ax, ay) / (long if long > 0.0 else 1.0)
    turned = t > 0.66
    t = (t - 1.0) / (t + 1.0) if turned else t
    z = t * t
    p = fma(-8.750608600031904122785e-1, z, -1.615753718733365076637e1)
    p = fma(p, z, -7.500855792314704667340e1)
    p = fma(p, z, -1.228866684490136173410e2)
    p = fma(p, z, -6.485021904942025371773e1)
    q = z + 2.485846490142306297962e1
    q = fma(q, z, 1.650270098316988542046e2)
    q = fma(q, z, 4.328810604912902668951e2)
    q = fma(q, z, 4.853903996359136964868e2)
    q = fma(q, z, 1.945506571482613964425e2)
    angle = fma(t, z * p / q, t) + (QUARTER if turned else 0.0)
    angle = 2.0 * QUARTER - angle if ay > ax else angle
    angle = 4.0 * QUARTER - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle
