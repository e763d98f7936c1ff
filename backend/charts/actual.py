"""What the error of each estimate really was."""

from __future__ import annotations

import numpy as np

from backend.charts.columns import Floats, Ints, numbers, row_numbers
from backend.charts.estimates import Estimates
from backend.charts.view import Entry


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


def _keys(row: Ints, trial: Floats) -> Ints:
    return np.nan_to_num(trial, nan=0.0).astype(np.int64) * 2**40 + row
