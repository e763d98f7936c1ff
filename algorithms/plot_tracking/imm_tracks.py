"""All living tracks of the recommended tracker, of all trials side by side.

A track with one plot has no filter yet: its bank holds its place alone. With the second it gets one, with the third a
number, and with `confirm_plots` it is confirmed.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.imm_filter import POSITION, STATES, Bank, Motion
from algorithms.plot_tracking.plots import Scan

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass
class ImmTracks:
    """T tracks; arrays (T,) and a bank of filters.

    Attributes
    ----------
    lane : trial
    number : within the trial, from 1; 0 until the third plot
    plots : that it took in all
    last_s : instant of the newest one
    seen_s : instant of its scan: a turn of the antenna lasts a period, so misses are counted from scan to scan
    epoch_s : for which the bank holds: that, or later where plots took part that were probably not its own
    misses : periods gone by without one
    confirmed : for good
    twin : scans in a row in which it was as good as the same as an older track
    first, second : rows of its first two plots
    address, callsign : indices, -1 = none was ever given; altitude_m : the newest one, NaN = none
    begun_r : (T, 2, 2) covariance of a single plot
    """

    lane: Ints
    number: Ints
    plots: Ints
    last_s: Floats
    seen_s: Floats
    epoch_s: Floats
    misses: Ints
    confirmed: NDArray[np.bool_]
    twin: Ints
    first: Ints
    second: Ints
    address: Ints
    callsign: Ints
    altitude_m: Floats
    altitude_s: Floats
    begun_r: Floats
    bank: Bank

    def __len__(self) -> int:
        """Return the number of tracks."""
        return int(self.lane.size)

    def take(self, which: NDArray[np.bool_] | Ints) -> ImmTracks:
        """Some of the tracks."""
        return ImmTracks(
            **{f.name: getattr(self, f.name)[which] for f in fields(self) if f.name != "bank"},
            bank=self.bank.take(which),
        )

    def joined(self, other: ImmTracks) -> ImmTracks:
        """Both, the other's last: tracks of a trial keep their order, whatever other trials do."""
        return ImmTracks(
            **{
                f.name: np.concatenate([getattr(self, f.name), getattr(other, f.name)])
                for f in fields(self)
                if f.name != "bank"
            },
            bank=self.bank.joined(other.bank),
        )

    @classmethod
    def starting_from(cls, scan: Scan, which: Ints, z: Floats, r: Floats, motion: Motion) -> ImmTracks:
        """One track from each of these plots."""
        count = which.size
        x = np.zeros((count, motion.models, STATES))
        x[..., POSITION] = z[which][:, None]
        zero = np.zeros(count, np.int64)
        return cls(
            lane=scan.lane[which],
            number=zero.copy(),
            plots=zero + 1,
            last_s=scan.t[which].astype(float),
            seen_s=np.full(count, scan.time_s),
            epoch_s=scan.t[which].astype(float),
            misses=zero.copy(),
            confirmed=zero > 0,
            twin=zero.copy(),
            first=scan.position[which],
            second=zero - 1,
            address=zero - 1,
            callsign=zero - 1,
            altitude_m=np.full(count, np.nan),
            altitude_s=np.full(count, np.nan),
            begun_r=r[which],
            bank=Bank(x, np.zeros((count, motion.models, STATES, STATES)), np.tile(motion.prior, (count, 1))),
        )
