"""Cramer-Rao bound of one mark at one place, by inverting its information: the other route to the accuracy map.

Information of N receptions with unknown emission time, I = U^T (W - W 1 1^T W / 1^T W 1) U with W = diag(1/sigma^2)
and U the rows u_i = (p - s_i) / r_i; an altitude adds grad h grad h^T / sigma_h^2; a known altitude confines the
position to the surface: reduce with B = [[1, 0], [0, 1], [-gx/gz, -gy/gz]].

References
----------
chugunov2023, eq. (27); specification 8.5.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.frames.earth import up_from_position

Floats = NDArray[np.float64]

# Beyond this condition number the position is not observable: the bound is then None, not a large number.
LARGEST_CONDITION = 1e14


def information(position_m: Floats, stations_m: Floats, sigma_m: Floats) -> Floats:
    """(3, 3) 1/m^2: information of the receptions at stations (S, 3) with errors (S,) m about a position (3,)."""
    d = position_m - stations_m
    u = d / np.linalg.norm(d, axis=1)[:, None]
    w = 1.0 / np.asarray(sigma_m, float) ** 2
    mean = (w @ u) / w.sum()
    return np.einsum("s,si,sj->ij", w, u - mean, u - mean)


def one_mark_covariance(
    position_m: Floats,
    stations_m: Floats,
    sigma_m: Floats,
    *,
    earth: Floats | None = None,
    sigma_altitude_m: float | None = None,
    altitude_known: bool = False,
) -> Floats | None:
    """(3, 3) m^2: bound of an unbiased one-mark estimate; None where the position is not observable.

    `earth` is needed where an altitude takes part: `sigma_altitude_m` as an observation, or `altitude_known` exactly.
    """
    info = information(position_m, stations_m, sigma_m)
    if not altitude_known and sigma_altitude_m is None:
        return _inverse(info)
    assert earth is not None, "an altitude needs an Earth"
    g = up_from_position(position_m, earth)
    if altitude_known:
        b = np.array([[1.0, 0.0], [0.0, 1.0], [-g[0] / g[2], -g[1] / g[2]]])
        plan = _inverse(b.T @ info @ b)
        return None if plan is None else np.asarray(b @ plan @ b.T)
    assert sigma_altitude_m is not None
    return _inverse(info + np.outer(g, g) / sigma_altitude_m**2)


def _inverse(info: Floats) -> Floats | None:
    if np.linalg.cond(info) > LARGEST_CONDITION:
        return None
    return np.asarray(np.linalg.inv(info), np.float64)
