"""How good position estimates are, and how honest: errors against truth, claims against errors.

`nees` and `nis` are given per degree of freedom: 1 is honest, above 1 the filter claims too much. A single recording
gives no confidence interval, because its errors are correlated from mark to mark.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Metric

Floats = NDArray[np.float64]

OVER_M = 5_000.0


def error_metrics(errors_m: Floats, target: str = "") -> list[Metric]:
    """Metrics of errors (n, 3) east, north, up in metres; rows with NaN are left out."""
    known = np.isfinite(errors_m).all(axis=1)
    # Of a long recording the copy is a part of the memory that a worker has.
    e = errors_m if known.all() else errors_m[known]
    n = len(e)
    horizontal = np.hypot(e[:, 0], e[:, 1])

    def row(metric: str, value: Callable[[], float], unit: str = "m") -> Metric:
        return Metric(metric, float(value()) if n else None, unit, n, target=target)

    def rms(values: Floats) -> float:
        return float(np.sqrt(np.mean(values**2)))

    p75, p90, p99 = np.percentile(horizontal, (75, 90, 99)).tolist() if n else (np.nan,) * 3

    return [
        row("rms_horizontal_m", lambda: rms(horizontal)),
        row("median_horizontal_m", lambda: float(np.median(horizontal))),
        row("p75_horizontal_m", lambda: p75),
        row("p90_horizontal_m", lambda: p90),
        row("p99_horizontal_m", lambda: p99),
        row("max_horizontal_m", lambda: float(horizontal.max())),
        row("rms_position_m", lambda: rms(np.sqrt(e[:, 0] ** 2 + e[:, 1] ** 2 + e[:, 2] ** 2))),
        row("rms_east_m", lambda: rms(e[:, 0])),
        row("rms_north_m", lambda: rms(e[:, 1])),
        row("rms_up_m", lambda: rms(e[:, 2])),
        row("over_5km_share", lambda: float(np.mean(horizontal > OVER_M)), "1"),
    ]


def nees(errors_m: Floats, covariance_m2: Floats, target: str = "") -> Metric:
    """Mean normalised position error squared per degree of freedom of errors (n, 3) and covariances (n, 3, 3)."""
    return mean_nees(normalised_squares(errors_m, covariance_m2), target)


def normalised_squares(errors_m: Floats, covariance_m2: Floats) -> Floats:
    """(n,): e' P^-1 e of errors (n, 3) and covariances (n, 3, 3); NaN where either is unknown."""
    known = np.isfinite(errors_m).all(axis=1) & np.isfinite(covariance_m2).all(axis=(1, 2))
    e, p = errors_m[known], covariance_m2[known]
    out = np.full(len(errors_m), np.nan)
    out[known] = np.einsum("ni,ni->n", e, np.linalg.solve(p, e[:, :, None])[:, :, 0])
    return out


def mean_nees(squares: Floats, target: str = "") -> Metric:
    """NEES per degree of freedom of normalised squares (n,) of position errors; NaN does not count."""
    known = squares[~np.isnan(squares)]
    value = float(np.mean(known) / 3) if known.size else None
    return Metric("nees", value, "1", int(known.size), target=target)


def claim_metrics(
    answered: NDArray[np.bool_], drms_m: Floats, nis: Floats, dof: NDArray[np.int64], target: str = ""
) -> list[Metric]:
    """What a filter says of itself at each mark (n,): answers, claimed error, innovations.

    Marks whose innovation must not count (their noise was scaled up) come with a NIS of NaN.
    """
    n = len(answered)
    drms = drms_m[np.isfinite(drms_m)]
    tested = np.isfinite(nis) & (dof > 0)
    first = int(np.argmax(answered)) if answered.any() else n
    after = answered[first:]
    return [
        Metric("answered_share", float(answered.mean()) if n else None, "1", n, target=target),
        Metric("lost_share", float(1 - after.mean()) if after.size else None, "1", int(after.size), target=target),
        Metric(
            "claimed_horizontal_m",
            float(np.sqrt(np.mean(drms**2))) if drms.size else None,
            "m",
            int(drms.size),
            target=target,
        ),
        Metric(
            "nis",
            float(nis[tested].sum() / dof[tested].sum()) if tested.any() else None,
            "1",
            int(tested.sum()),
            target=target,
        ),
    ]
