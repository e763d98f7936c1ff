"""Cramer-Rao bound of one mark over many places at once: what a site can say, where, and with which of its stations.

The rows of a mark, whitened and freed of the unknown emission time, are

    D = W^(1/2) (U - 1 w^T U / w^T 1),   w = 1 / sigma^2,   U = rows (p - s_i) / r_i,

so that D^T D is the information I = U^T (W - W 1 1^T W / 1^T W 1) U. The map takes D apart by Gram-Schmidt, column by
column in the order z, x, y, over all places together, D = Q R: the last two rows of R alone give the bound in the plan,

    DRMS^2 = (1 + r_xy^2 / r_yy^2) / r_xx^2 + 1 / r_yy^2,

and nothing is squared, so that what is not observable is told from what is hardly observable (I loses half of the
digits: three receptions in space would get a finite number). An altitude of sigma_h is one row more, grad h / sigma_h;
a known one confines the position to the surface and leaves two columns, D (1, 0, -gx/gz)^T and D (0, 1, -gy/gz)^T.

A clock that is late by one nanosecond moves the fix by R^-1 Q^T b, b = W^(1/2) e_j c 1 ns: Q stands in the same pass.

References
----------
chugunov2023, eq. (27); specification 8.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.toolbox.frames.earth import up_from_position, z_from_altitude
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]
Altitude = Literal["none", "measured", "known"]
Variant = Literal["space", "altitude_measured", "altitude_known", "altitude_gain", "clock"]

C_M_PER_NS = 1e-9 * SPEED_OF_LIGHT_MPS
# Of a column of R against the longest: the root of the condition number 1e14 beyond which nothing is observable.
LEAST = 1e-7
# All subsets of so many stations are worth a look; of more, those that leave out one or two.
ALL_SUBSETS_UP_TO = 6


@dataclass(frozen=True)
class Places:
    """Where the map is computed.

    Attributes
    ----------
    position_m : (3, P) east, north, up.
    up : (3, P) gradient of the altitude.
    """

    position_m: Floats
    up: Floats


@dataclass(frozen=True)
class PlanBound:
    """What one mark can say in the plan.

    Attributes
    ----------
    drms_m : (P,) root of the summed variances of east and north, m; NaN where the position is not observable.
    clock_m_per_ns : (S, P) how far the fix moves for a nanosecond of each station's clock; NaN where not observable.
    """

    drms_m: Floats
    clock_m_per_ns: Floats | None


@dataclass(frozen=True)
class Summary:
    """A map in numbers.

    Attributes
    ----------
    observable_share : of its places
    median, quantile_90, largest : over the observable ones; None where there is none.
    """

    observable_share: float
    median: float | None
    quantile_90: float | None
    largest: float | None


def places_at(east_m: Floats, north_m: Floats, altitude_m: float, earth: Floats) -> Places:
    """Points of equal altitude over a plan; east and north have the same shape (P,).

    Raises
    ------
    FrameError
        Where a place lies farther out than the Earth is wide.
    """
    up_m = z_from_altitude(east_m, north_m, np.asarray(altitude_m), earth)
    position = np.stack([east_m, north_m, up_m])
    return Places(position, np.moveaxis(up_from_position(np.moveaxis(position, 0, -1), earth), -1, 0))


def subsets(count: int) -> list[tuple[int, ...]]:
    """Sets of stations to compare: all of three and more of up to six stations, else all, without one, without two."""
    if count <= ALL_SUBSETS_UP_TO:
        sizes: Sequence[int] = range(count, 2, -1)
    else:
        sizes = (count, count - 1, count - 2)
    return [chosen for size in sizes for chosen in combinations(range(count), size)]


def plan_bound(
    places: Places,
    stations_m: Floats,
    sigma_m: Floats,
    altitude: Altitude = "none",
    sigma_altitude_m: float = 1.0,
    *,
    clocks: bool = False,
) -> PlanBound:
    """Bound in the plan of one mark received by all the stations.

    Parameters
    ----------
    places : P places.
    stations_m : (S, 3) positions in the same frame, m.
    sigma_m : (S,) standard deviations of the arrivals as distances, m.
    altitude : `none` gives the position in space, `measured` with an error of `sigma_altitude_m`, `known` exactly.
    clocks : also how far a clock error moves the fix.

    Notes
    -----
    At a station itself a unit vector has no direction; the place counts as not observable.
    """
    rows = _rows(places, stations_m, sigma_m)
    gx, gy, gz = places.up
    if altitude == "known":
        columns = [rows[0] - rows[2] * (gx / gz), rows[1] - rows[2] * (gy / gz)]
    else:
        if altitude == "measured":
            rows = np.concatenate([rows, (places.up / sigma_altitude_m)[:, None]], axis=1)
        columns = [rows[2], rows[0], rows[1]]
    q, diagonal, r_xy, longest = _gram_schmidt(columns)
    r_xx, r_yy = diagonal[-2:]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        drms = np.sqrt((1.0 + (r_xy / r_yy) ** 2) / r_xx**2 + 1.0 / r_yy**2)
        # A NaN, which a place at a station is made of, compares as not observable.
        observable = np.min(diagonal, axis=0) > LEAST * longest
        drms = np.where(observable, drms, np.nan)
        if not clocks:
            return PlanBound(drms, None)
        late = (C_M_PER_NS / np.asarray(sigma_m, float))[:, None]
        north = q[-1][: len(late)] * late / r_yy
        east = (q[-2][: len(late)] * late - r_xy * north) / r_xx
        return PlanBound(drms, np.where(observable, np.hypot(east, north), np.nan))


def plan_values(
    places: Places,
    stations_m: Floats,
    sigma_m: Floats,
    variant: Variant,
    sigma_altitude_m: float,
    *,
    as_gdop: bool = False,
) -> Floats:
    """(P,) what a map shows.

    Parameters
    ----------
    variant : the bound `space`, `altitude_measured`, `altitude_known`, m; `altitude_gain`, how many times the first is
        the third; `clock`, how far the fix with a measured altitude moves for the worst station's clock, m/ns.
    as_gdop : bounds over the rms error of the arrivals; the other two have no such quotient and stay.
    """
    if variant == "clock":
        moved = plan_bound(places, stations_m, sigma_m, "measured", sigma_altitude_m, clocks=True).clock_m_per_ns
        assert moved is not None
        return np.asarray(moved.max(axis=0))
    kinds: dict[str, Altitude] = {"space": "none", "altitude_measured": "measured"}
    found = plan_bound(places, stations_m, sigma_m, kinds.get(variant, "known"), sigma_altitude_m).drms_m
    if variant == "altitude_gain":
        return np.asarray(plan_bound(places, stations_m, sigma_m).drms_m / found)
    return np.asarray(found / np.sqrt(np.mean(np.square(sigma_m)))) if as_gdop else found


def summary_of(values: Floats) -> Summary:
    """Put a map, or the ratio of two, into numbers; NaN is what is not observable."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Summary(0.0, None, None, None)
    median, ninety = np.quantile(known, (0.5, 0.9))
    return Summary(known.size / values.size, float(median), float(ninety), float(known.max()))


def _rows(places: Places, stations_m: Floats, sigma_m: Floats) -> Floats:
    """(3, S, P) the rows D by component, whitened and freed of the emission time."""
    stations, sigma = np.asarray(stations_m, float), np.asarray(sigma_m, float)
    u = places.position_m[:, None, :] - stations.T[:, :, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        u /= np.sqrt(np.einsum("csp,csp->sp", u, u))
    w = 1.0 / sigma**2
    u -= (np.einsum("s,csp->cp", w, u) / w.sum())[:, None]
    u /= sigma[:, None]
    return u


def _gram_schmidt(columns: list[Floats]) -> tuple[list[Floats], Floats, Floats, Floats]:
    """Columns (K of (R, P)) -> orthonormal ones, diagonal of R (K, P), its entry right of the last but one, longest."""
    q: list[Floats] = []
    diagonal, lengths = [], []
    corner = np.zeros(columns[0].shape[1])
    with np.errstate(divide="ignore", invalid="ignore"):
        for column in columns:
            rest = column
            lengths.append(np.sqrt(np.einsum("rp,rp->p", column, column)))
            for done in q:
                corner = np.einsum("rp,rp->p", done, rest)
                rest = rest - done * corner
            length = np.sqrt(np.einsum("rp,rp->p", rest, rest))
            diagonal.append(length)
            q.append(rest / length)
    return q, np.stack(diagonal), corner, np.max(lengths, axis=0)
