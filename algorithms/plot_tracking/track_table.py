"""All living tracks of all trials side by side: their last plots, their trajectory, and where they are in life.

References
----------
Specification 6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.window import Window

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass
class TrackTable:
    """T tracks; arrays (T,), (H, T) or (6, ..., T), the track last.

    Attributes
    ----------
    lane : trial
    number : of the track within its trial, from 1; 0 until its third plot
    plots : how many plots its history holds
    rho, theta, t : (H, T) m, rad, s; the newest last, NaN before the oldest
    q : the counter
    hits, misses : plots taken in all, scans missed in a row
    confirmed : whether it ever had as many plots as confirm it
    p, information : (6, T), (6, 6, T) its trajectory, epoch at its newest plot
    how : how that was fitted (`curve_fit`)
    seen_s : s, instant of the scan of its newest plot
    first, second : rows in the recording of its first two plots, which it took before it had a number; -1 = none
    """

    lane: Ints
    number: Ints
    plots: Ints
    rho: Floats
    theta: Floats
    t: Floats
    q: Ints
    hits: Ints
    misses: Ints
    confirmed: NDArray[np.bool_]
    p: Floats
    information: Floats
    how: Ints
    first: Ints
    second: Ints
    seen_s: Floats

    def __len__(self) -> int:
        """Return the number of tracks."""
        return int(self.lane.size)

    @classmethod
    def starting_from(cls, scan: Scan, which: Ints, history: int) -> TrackTable:
        """One track from each of these plots."""
        count = which.size
        rows = {name: np.full((history, count), np.nan) for name in ("rho", "theta", "t")}
        for name, row in rows.items():
            row[-1] = getattr(scan, name)[which]
        return cls(
            lane=scan.lane[which],
            number=np.zeros(count, np.int64),
            plots=np.ones(count, np.int64),
            q=np.full(count, 2),
            hits=np.ones(count, np.int64),
            misses=np.zeros(count, np.int64),
            confirmed=np.zeros(count, bool),
            p=np.full((6, count), np.nan),
            information=np.full((6, 6, count), np.nan),
            how=np.zeros(count, np.int64),
            first=scan.position[which],
            second=np.full(count, -1),
            seen_s=np.full(count, scan.time_s),
            **rows,
        )

    @property
    def last_s(self) -> Floats:
        """(T,) s, instant of the newest plot."""
        out: Floats = self.t[-1]
        return out

    def take(self, which: NDArray[np.bool_] | Ints) -> TrackTable:
        """Some of the tracks."""
        return TrackTable(**{f.name: getattr(self, f.name)[..., which] for f in fields(self)})

    def joined(self, other: TrackTable) -> TrackTable:
        """Both, the other's tracks last: tracks of a trial keep their order, whatever other trials do."""
        return TrackTable(
            **{f.name: np.concatenate([getattr(self, f.name), getattr(other, f.name)], axis=-1) for f in fields(self)}
        )

    def append(self, which: Ints, scan: Scan, plot: Ints) -> None:
        """Put a plot at the end of each of these tracks' histories; the oldest leaves a full one."""
        for name in ("rho", "theta", "t"):
            history = getattr(self, name)
            history[:-1, which] = history[1:, which]
            history[-1, which] = getattr(scan, name)[plot]
        self.plots[which] = np.minimum(self.plots[which] + 1, self.rho.shape[0])
        self.hits[which] += 1
        self.misses[which] = 0
        self.seen_s[which] = scan.time_s

    def keep_newest(self, which: Ints, plots: Ints | int) -> None:
        """Forget all but the newest plots of these tracks."""
        size = self.rho.shape[0]
        kept = np.minimum(self.plots[which], plots)
        forgotten = np.arange(size)[:, None] < size - kept[None, :]
        for name in ("rho", "theta", "t"):
            history = getattr(self, name)
            history[:, which] = np.where(forgotten, np.nan, history[:, which])
        self.plots[which] = kept

    def window(self, which: Ints, sigma_r: float, sigma_theta: Callable[[Floats], Floats]) -> Window:
        """Windows of these tracks' plots; `sigma_theta` gives an azimuth's error at a range."""
        rho, theta, t = self.rho[:, which], self.theta[:, which], self.t[:, which]
        known = np.isfinite(rho)
        safe = np.where(known, rho, 1.0)
        return Window(
            rho=safe,
            theta=np.where(known, theta, 0.0),
            t=np.where(known, t - t[-1], 0.0),
            known=known,
            sigma_r=np.full(rho.shape, sigma_r),
            sigma_th=sigma_theta(safe),
        )
