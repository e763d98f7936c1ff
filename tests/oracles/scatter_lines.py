"""The paper's forward-scatter algorithm, word for word from its specification (section 4), slowly: an oracle.

One pass, two receivers, plain least squares; nothing of the project is used. Times are in seconds, Dopplers in hertz,
`f` is (K, 2) with NaN where a receiver missed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass
class Receiver:
    """What is remembered of a receiver's crossing."""

    raw: float = np.nan
    kept: float = np.nan
    before: float = np.nan
    seen: int = 0
    since: int = 0
    first: float = np.nan

    def use(self, crossed: bool, rule: str, delay: int, confirm: int) -> float:
        """Step 4: the crossing time to be used now."""
        if rule == "none" or np.isfinite(self.kept):
            return self.kept if np.isfinite(self.kept) else self.raw
        if self.seen == 0 or self.seen < confirm:
            if crossed:
                self.seen += 1
                self.since = 0 if self.seen == 1 else self.since + 1
            else:
                self.seen, self.first, self.before = 0, np.nan, self.raw
                return self.raw
        else:
            self.since += 1
        if not np.isfinite(self.first) and (self.since >= delay or rule == "b"):
            self.first = self.before if rule == "b" and np.isfinite(self.before) else self.raw
        if np.isfinite(self.first) and self.seen >= confirm:
            self.kept = self.first
        return self.first if np.isfinite(self.first) else self.raw


def lines(
    time: Floats,
    f: Floats,
    *,
    a: float,
    b: float,
    wavelength: float,
    window: int = 10,
    formula: int = 14,
    freeze_rule: str = "a",
    freeze_delay: int = 0,
    confirm: int = 1,
    omega: str = "lines",
    curvature_correction: bool = False,
    formula_17_origin: str = "window",
) -> Floats:
    """(K, 3): tau, s, v_y at each epoch; NaN where there is no estimate, or an invalid one."""
    out = np.full((time.size, 3), np.nan)
    receivers = [Receiver(), Receiver()]
    for k in range(time.size):
        own = slice(max(0, k - window + 1), k + 1)
        fits = [line(time[own], f[own, j]) for j in range(2)]
        fresh = [fit is not None and fit[2] < 0 for fit in fits]
        for receiver, fit, new in zip(receivers, fits, fresh, strict=True):
            if new:
                receiver.raw = fit[0] - fit[1] / fit[2]
        past = [new and r.raw <= time[k] for r, new in zip(receivers, fresh, strict=True)]
        if freeze_rule == "c":
            past = [all(past)] * 2
        tau = [
            r.use(p, freeze_rule, freeze_delay, confirm) if new else (r.kept if np.isfinite(r.kept) else r.raw)
            for r, p, new in zip(receivers, past, fresh, strict=True)
        ]
        if any(fit is None for fit in fits) or not np.isfinite(tau).all():
            continue
        (c1, f1, s1), (c2, f2, s2) = fits
        centre = middle = (c1 + c2) / 2
        if omega == "lines":
            df = f1 + s1 * (centre - c1) - f2 - s2 * (centre - c2)
        else:
            pairs = slice(0, k + 1) if omega == "mean_of_all" else own
            both = np.isfinite(f[pairs]).all(axis=1)
            if not both.any():
                continue
            df = float((f[pairs, 0] - f[pairs, 1])[both].mean())
            middle = float(time[pairs][both].mean())
        w = -(wavelength / b) * df
        if curvature_correction:
            plain = w
            for _ in range(3):
                w = plain * (1 + min((w * (middle - sum(tau) / 2)) ** 2, 0.25)) ** 1.5
        gamma, d = (s1 + s2) / 2, tau[1] - tau[0]
        origin = time[0] if formula_17_origin == "start" else centre
        if formula == 18:
            w = -(wavelength / b) * gamma * d
        elif formula == 17:
            w = -(wavelength / b) * (s2 * (tau[1] - origin) - s1 * (tau[0] - origin))
        s = a * wavelength * gamma / (wavelength * gamma - a * w * w) if formula == 19 else b / (w * d + b / a)
        if 0 < s < a:
            out[k] = sum(tau) / 2, s, w * s
    return out


def line(time: Floats, f: Floats) -> tuple[float, float, float] | None:
    """Mean time, value there and slope of the least-squares line; None with fewer than two values."""
    known = np.isfinite(f)
    if known.sum() < 2:
        return None
    centre = float(time[known].mean())
    slope, value = np.polyfit(time[known] - centre, f[known], 1)
    return centre, float(value), float(slope)
