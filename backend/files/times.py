"""Times of a file: seconds from a start that is relative, or whole seconds of the Unix epoch.

A float64 second of the epoch resolves 238 ns, so the whole seconds are taken off before anything else is done.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats
from backend.files.report import Findings

# 1990-01-01 and 2100-01-01: seconds outside are not taken for the epoch.
EPOCH_FIRST_S, EPOCH_LAST_S = 631_152_000, 4_102_444_800
# About three centuries; a larger relative time is no time of a recording.
_LARGEST_S = 1e10
# MATLAB's datenum of the Unix epoch, days from the year 0.
_DATENUM_EPOCH = 719_529.0
_DAY_S = 86_400.0
_EPOCH_SCALES = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


@dataclass(frozen=True)
class Times:
    """`time_s` from `epoch_s` (whole Unix seconds), or from an unknown start where that is None."""

    time_s: Floats
    epoch_s: int | None
    usable: NDArray[np.bool_]


def epoch_unit(median: float) -> str | None:
    """Unit in which `median` is a time of the Unix epoch, or None."""
    return next((u for u, f in _EPOCH_SCALES.items() if EPOCH_FIRST_S <= median / f <= EPOCH_LAST_S), None)


def resolve_times(raw: Floats, unit: str | None, findings: Findings) -> Times:
    """Turn a column of times into seconds and their start.

    Parameters
    ----------
    raw : (M,) float, finite
    unit : a unit of time, `date` (already seconds of the epoch), `epoch`, `epoch_ms`, ..., `datenum`, or None: seconds,
        unless the values can only be times of the epoch.
    """
    if unit == "datenum":
        raw, unit = (raw - _DATENUM_EPOCH) * _DAY_S, "epoch"
    median = float(np.median(raw)) if raw.size else 0.0
    scale, is_epoch = 1.0, False
    if unit == "date" or (unit or "").startswith("epoch"):
        scale, is_epoch = _EPOCH_SCALES[(unit or "").removeprefix("epoch").removeprefix("date").strip("_") or "s"], True
    elif unit is None and (found := epoch_unit(median)) is not None:
        scale, is_epoch = _EPOCH_SCALES[found], True
        findings.warn("epoch_time", f"The times were read as {found} of the Unix epoch (1970-01-01 UTC).")
    elif unit == "s" and epoch_unit(median) == "s":
        is_epoch = True
    if not is_epoch:
        return Times(raw, None, np.abs(raw) <= _LARGEST_S)
    usable = (raw >= EPOCH_FIRST_S * scale) & (raw <= EPOCH_LAST_S * scale)
    base = int(np.floor(raw[usable].min() / scale)) if usable.any() else 0
    return Times((raw - base * scale) / scale, base, usable)


def utc_text(epoch_s: int) -> str:
    """ISO 8601 with Z."""
    return datetime.fromtimestamp(epoch_s, UTC).isoformat().replace("+00:00", "Z")


def utc_seconds(text: str) -> float:
    """Seconds of the Unix epoch from ISO 8601."""
    return datetime.fromisoformat(text).timestamp()
