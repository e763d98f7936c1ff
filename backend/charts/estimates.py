"""The table `states` of an entry, sorted into tracks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from algorithms.texts import Texts
from backend.charts.columns import Floats, Ints, by_key_and_time, codes, numbers, row_numbers, used_marks, words
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

    def words_at(self, name: str) -> Callable[[Ints], NDArray[Any]]:
        """The same words, read only where they are asked for: at these positions."""

        def at(positions: Ints) -> NDArray[Any]:
            column = self.table.columns.get(name)
            if column is None:
                return np.full(positions.size, "", object)
            found = column[self.order[positions]]
            return found.words() if isinstance(found, Texts) else np.array([str(v) for v in found.tolist()], object)

        return at

    def at_rows(self, table: Table, name: str) -> NDArray[Any]:
        """Words of another table (`decisions`), looked up by the recording's row number; empty where it has none."""
        rows = row_numbers(table)
        known = np.flatnonzero(rows >= 0)
        known = known[np.argsort(rows[known], kind="stable")]
        out = np.full(self.row.size, "", object)
        if known.size:
            # Of several decisions on one mark the last stands.
            at = np.searchsorted(rows[known], self.row, side="right") - 1
            found = (at >= 0) & (rows[known][at.clip(0)] == self.row)
            out[found] = words(table, name)[known[at[found]]]
        return out


def estimates_of(entry: Entry) -> Estimates:
    """Sort an entry's states; an entry without any gives an empty object."""
    table = entry.table("states")
    time = numbers(table, "time_s")
    track = codes(table, "trial", "track")
    order = by_key_and_time(track, time)
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
