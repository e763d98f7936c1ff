"""The life of a track: tentative, confirmed, coasting, dropped, and the reason of every step from one to the next.

A track is *tentative* from its first place in the table on, *confirmed* as soon as it has enough measurements, for
good; *coasting* while measurements fail to come, and *dropped* after too many failed in a row, counted in periods of
the sensor by time, so that a sensor that stands still ends tracks too.

References
----------
barshalom2001, section 2.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

TENTATIVE, CONFIRMED, COASTING, DROPPED = range(4)
STATES = ("tentative", "confirmed", "coasting", "dropped")
"""Where a track is in its life."""

BEGUN, ENOUGH, MISSED, BACK, TOO_MANY_MISSES, NEVER_CONFIRMED, SENSOR_SILENT, DUPLICATE = range(8)
REASONS = (
    "enough plots to follow it",
    "enough plots to confirm it",
    "no plot in its gate",
    "a plot in its gate again",
    "too many missed in a row",
    "missed before it was confirmed",
    "the sensor was silent for too long",
    "the same as an older track",
)
"""Why it went there."""


def state_of(confirmed: Bools, misses: Ints) -> Ints:
    """Where tracks are in their lives, (T,)."""
    return np.where(~confirmed, TENTATIVE, np.where(misses > 0, COASTING, CONFIRMED))


def periods_missed(time_s: float | Floats, last_s: Floats, period_s: float) -> Ints:
    """(T,) number of periods between the last measurement and now in which another one should have come."""
    return np.maximum(np.round((time_s - last_s) / period_s).astype(np.int64), 0)


@dataclass
class Diary:
    """Steps of lives, in the order in which they were taken; arrays joined at the end."""

    _parts: list[tuple[Ints, Ints, Floats, Ints, Ints]] = field(default_factory=list)

    def note(self, lane: Ints, number: Ints, time_s: float, state: int | Ints, reason: int | Ints) -> None:
        """Tracks of these trials and numbers go to a state."""
        if lane.size:
            size = lane.size
            self._parts.append(
                (
                    lane,
                    number,
                    np.full(size, time_s),
                    np.broadcast_to(np.asarray(state, np.int64), size),
                    np.broadcast_to(np.asarray(reason, np.int64), size),
                )
            )

    def steps(self, lane: Ints, number: Ints, time_s: float, before: Ints, after: Ints) -> None:
        """Write down which tracks changed their state between two moments; `before` is -1 for a new one."""
        for found, state, reason in (
            (before < 0, TENTATIVE, BEGUN),
            ((before < CONFIRMED) & (after >= CONFIRMED), CONFIRMED, ENOUGH),
            ((before != COASTING) & (before >= 0) & (after == COASTING), COASTING, MISSED),
            ((before == COASTING) & (after == CONFIRMED), CONFIRMED, BACK),
        ):
            at = np.flatnonzero(found)
            self.note(lane[at], number[at], time_s, state, reason)

    def joined(self) -> tuple[Ints, Ints, Floats, Ints, Ints]:
        """Trial, number, instant, state, reason."""
        if not self._parts:
            none = np.empty(0, np.int64)
            return none, none, np.empty(0), none, none
        lane, number, time, state, reason = (np.concatenate(part) for part in zip(*self._parts, strict=True))
        return lane, number, time, state, reason
