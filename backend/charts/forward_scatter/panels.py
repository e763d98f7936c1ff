"""What the charts of forward scatter share: panels under each other, and the rows of `crossings` pass by pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Floats, Ints, codes, numbers, row_numbers, words
from backend.charts.figure import Trace, axis, trace
from backend.charts.view import Entry

GAP = 0.05
# A silence of more intervals than these parts two targets; irregular instants are up to 1.5 of them apart.
SILENCE_STEPS = 2.5
# Statuses of rows with an answer that should be read with care.
DOUBTFUL = ("extrapolated", "fallback", "held")


@dataclass(frozen=True)
class Rows:
    """Rows of a table in the order of trial, pass and time; `breaks` begins each pass."""

    table: Table
    order: Ints
    breaks: NDArray[np.bool_]

    def numbers(self, name: str) -> Floats:
        """A column of floats."""
        return numbers(self.table, name)[self.order]

    def words(self, name: str) -> NDArray[Any]:
        """A column of words."""
        return words(self.table, name)[self.order]

    @property
    def time_s(self) -> Floats:
        """Instants."""
        return self.numbers("time_s")

    @property
    def row(self) -> Ints:
        """Row numbers of the recording."""
        return row_numbers(self.table)[self.order]


def rows_of(entry: Entry, name: str) -> Rows | None:
    """Rows of an entry's table that belong to a pass; None where there are none."""
    table = entry.table(name)
    if not len(table):
        return None
    track = numbers(table, "track")
    known = np.flatnonzero(np.isfinite(track))
    if not known.size:
        return None
    key = codes(table, "trial", "track")
    order = known[np.lexsort((numbers(table, "time_s")[known], key[known]))]
    ordered = key[order]
    return Rows(table, order, np.append(True, ordered[1:] != ordered[:-1]))


def passes_begin(time_s: Floats) -> NDArray[np.bool_]:
    """Where a curve over the instants of trials begins anew: at first, and after a silence between two targets."""
    step = np.diff(time_s)
    usual = float(np.median(step)) if step.size else 0.0
    return np.append(np.ones(min(time_s.size, 1), np.bool_), step > SILENCE_STEPS * usual)


def since_begin(time_s: Floats, begins: NDArray[np.bool_]) -> Floats:
    """Seconds since the pass of each instant began."""
    first = np.flatnonzero(begins)
    return time_s - time_s[first][np.cumsum(begins) - 1] if time_s.size else time_s


def broken(values: Floats, breaks: NDArray[np.bool_]) -> Floats:
    """Values with a NaN before each pass, so that a line does not run from one to the next."""
    return np.insert(values.astype(np.float64), np.flatnonzero(breaks)[1:], np.nan)


def broken_rows(rows: Ints, breaks: NDArray[np.bool_]) -> Ints:
    """Row numbers beside `broken` values; -1 at the gaps."""
    return np.insert(rows, np.flatnonzero(breaks)[1:], -1)


def stacked_axes(titles: Sequence[str], **properties: Any) -> dict[str, Any]:
    """Axes of panels under each other, the first on top: yaxis, yaxis2, ..."""
    height = (1 - GAP * (len(titles) - 1)) / len(titles)
    out = {}
    for i, title in enumerate(titles):
        top = 1 - i * (height + GAP)
        domain = [max(top - height, 0), top]
        out[f"yaxis{axis_number(i)}"] = axis(title, domain=domain, **properties)
    return out


def axis_number(panel: int) -> str:
    """The number in the name of a panel's axis."""
    return "" if panel == 0 else str(panel + 1)


def band_of(
    entry: Entry, x: Floats, low: Floats, high: Floats, name: str, breaks: NDArray[np.bool_], **more: Any
) -> list[Trace]:
    """Filled outlines between two curves, one for each unbroken piece."""
    out: list[Trace] = []
    fill = theme.faint(theme.series_color(entry.index), theme.INTERVAL_OPACITY)
    for piece in np.split(np.arange(x.size), np.flatnonzero(breaks)[1:]):
        known = piece[np.isfinite(low[piece]) & np.isfinite(high[piece])]
        if known.size > 1:
            out.append(
                trace(
                    "interval",
                    np.concatenate([x[known], x[known][::-1]]),
                    np.concatenate([high[known], low[known][::-1]]).astype(np.float32),
                    entry=entry,
                    name=name,
                    mode="lines",
                    line={"width": 0},
                    fill="toself",
                    fillcolor=fill,
                    showlegend=False,
                    hoverinfo="skip",
                    **more,
                )
            )
    return out
