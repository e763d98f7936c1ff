"""The table `states` of an entry, sorted into tracks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts.columns import Floats, Ints, codes, numbers, row_numbers, used_marks, words
from backend.charts.decimate import line_starts
from backend.charts.view import Entry


@dataclass(frozen=True)
class Estimates:
    """Rows of `states` in the order of trial, track and time.

    Attributes
    ----------
    starts : (n,) bool, first row of each unbroken piece of a track
    used : (n,) bool, False where the mark did not go into the estimate (a coast, a rejected mark)
    moving : whether the algorithm keeps tracks (it states a velocity); single fixes are not joined by lines
    """

    table: Table
    order: Ints
    time_s: Floats
    row: Ints
    starts: NDArray[np.bool_]
    used: NDArray[np.bool_]
    moving: bool

    def numbers(self, name: str) -> Floats:
        """A column of floats in this order."""
        return numbers(self.table, name)[self.order]

    def words(self, name: str) -> NDArray[Any]:
        """A column of words in this order."""
        return words(self.table, name)[self.order]

    def at_rows(self, table: Table, name: str) -> NDArray[Any]:
        """Words of another table (`decisions`), looked up by the recording's row number; empty where it has none."""
        known = dict(zip(row_numbers(table).tolist(), words(table, name).tolist(), strict=True))
        known.pop(-1, None)
        out = np.full(self.row.size, "", object)
        if known:
            out[:] = [known.get(row, "") for row in self.row.tolist()]
        return out


def estimates_of(entry: Entry) -> Estimates:
    """Sort an entry's states; an entry without any gives an empty object."""
    table = entry.table("states")
    time = numbers(table, "time_s")
    track = codes(table, "trial", "track")
    order = np.lexsort((time, track))
    track = track[order]
    velocity = numbers(table, "velocity_east_mps")
    return Estimates(
        table=table,
        order=order,
        time_s=time[order],
        row=row_numbers(table)[order],
        starts=line_starts(track, time[order]),
        used=used_marks(table)[order],
        moving=bool(np.isfinite(velocity).any()),
    )
