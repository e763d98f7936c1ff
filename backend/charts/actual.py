"""What the error of each estimate really was."""

from __future__ import annotations

import numpy as np

from backend.charts.columns import Floats, Ints, numbers, row_numbers
from backend.charts.estimates import Estimates
from backend.charts.figure import ChartNote, counted
from backend.charts.view import Entry

# Up to so many tracks each has its own curve of errors; more are summed up in bins of time.
CURVES = 8
# In a hover: the instant and the mark.
MARK = "%{x:.3f} s, row %{customdata}"


def actual_errors(entry: Entry, states: Estimates) -> Floats:
    """Actual horizontal error of each estimate, m, joined by row number and trial; NaN where unknown."""
    table = entry.table("errors")
    out = np.full(states.time_s.size, np.nan)
    if len(table) == 0:
        return out
    have = _keys(row_numbers(table), numbers(table, "trial"))
    order = np.argsort(have)
    want = _keys(states.row, states.numbers("trial"))
    at = np.searchsorted(have[order], want).clip(max=have.size - 1)
    matched = (have[order][at] == want) & (states.row >= 0)
    out[matched] = numbers(table, "error_horizontal_m")[order][at[matched]]
    return out


def zeros_left_out(entry: Entry, error: Floats) -> list[ChartNote]:
    """Say how many errors a logarithmic axis has no place for."""
    zero = int((error == 0).sum())
    if not zero:
        return []
    text = f"No place on a logarithmic axis: {counted(zero, 'error')} of exactly 0 m."
    return [ChartNote("zero_on_log_axis", text, entry.label)]


def _keys(row: Ints, trial: Floats) -> Ints:
    return np.nan_to_num(trial, nan=0.0).astype(np.int64) * 2**40 + row
