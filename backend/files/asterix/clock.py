"""Instants of records from times of day: over midnight, from truncated times, from the clock of a capture.

A time of day repeats after 24 hours and a truncated one (CAT 001) after 512 s, so a record's instant is the one
nearest to that of the record before it in the file. All categories and radars share one count of days: a radar that
is heard again after midnight is not thought to be a day late.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from algorithms.recording import Floats, Ints
from backend.files.report import Findings

DAY_S = 86_400.0
TRUNCATED_S = 512.0
# Records of one radar are some seconds out of order; beyond a minute somebody set a clock, or part is missing.
_JUMP_S = 60.0
# Clocks of one system agree within a second or two.
_APART_S = 5.0
_LONGEST_DELAY_S = 3600.0
_FEWEST_NEIGHBOURS = 3


@dataclass(frozen=True)
class Stream:
    """What one radar sent in one category: words for it, places of its records among all timed ones."""

    name: str
    places: Ints


def unfold(time_s: Floats, period_s: float = DAY_S) -> Floats:
    """Add whole periods so that each time is the nearest possible to the one before it."""
    steps = np.diff(time_s)
    return np.asarray(time_s + period_s * np.concatenate([[0.0], np.cumsum(-np.round(steps / period_s))]))


def near_receipt(time_s: Floats, received_s: Floats) -> Floats:
    """Instants of the epoch from times of day and the instants at which the records were captured."""
    return np.asarray(time_s + DAY_S * np.round((received_s - time_s) / DAY_S))


def complete(truncated_s: Floats, full_s: Floats) -> Floats:
    """Truncated times of day made whole by full instants near them.

    What is truncated is the time of day, which begins anew at midnight, and a day is no multiple of 512 s: near
    midnight the days before and after are tried too.

    Parameters
    ----------
    truncated_s : (M,) float, s, from 0 to 512
    full_s : (M,) float, s, an instant within 256 s of each, counted from some midnight
    """
    best = np.full(len(full_s), np.inf)
    day = np.floor(full_s / DAY_S)
    for midnight in (DAY_S * (day - 1), DAY_S * day, DAY_S * (day + 1)):
        whole = truncated_s + TRUNCATED_S * np.round((full_s - midnight - truncated_s) / TRUNCATED_S)
        instant = np.where((whole >= 0) & (whole < DAY_S), midnight + whole, np.inf)
        best = np.where(np.abs(instant - full_s) < np.abs(best - full_s), instant, best)
    return np.where(np.isfinite(best), best, np.nan)


def carried_on(values: Floats) -> Floats:
    """Fill NaN with the last value before it, at the beginning with the first value."""
    known = np.flatnonzero(np.isfinite(values))
    if not known.size:
        return values
    last = np.searchsorted(known, np.arange(len(values)), side="right") - 1
    return np.asarray(values[known[np.maximum(last, 0)]])


def look_at_clocks(time_s: Floats, number: Ints, streams: list[Stream], findings: Findings) -> set[str]:
    """Report jumps within a stream, and streams whose clock differs from that of the largest; return those.

    Parameters
    ----------
    time_s, number : (M,) instants and numbers of all timed records, in the order of the file
    """
    jumps: list[tuple[float, int, str]] = []
    for stream in streams:
        steps = np.diff(time_s[stream.places])
        far = np.flatnonzero(np.abs(steps) > _JUMP_S)
        jumps += [(float(steps[i]), int(number[stream.places[i + 1]]), stream.name) for i in far]
    if jumps:
        step, where, name = max(jumps, key=lambda j: abs(j[0]))
        findings.warn(
            "time_jumps",
            f"Records whose time is more than a minute away from that of the one before them; the farthest is record "
            f"{where} of {name}, by {step:+.6g} s.",
            len(jumps),
        )
    if len(streams) < 2:
        return set()
    first, *rest = sorted(streams, key=lambda s: -len(s.places))
    apart: dict[str, float] = {}
    for stream in rest:
        among = stream.places[(stream.places > first.places[0]) & (stream.places < first.places[-1])]
        if len(among) < _FEWEST_NEIGHBOURS:
            continue
        beside = np.interp(among, first.places, time_s[first.places])
        difference = float(np.median(time_s[among] - beside))
        if abs(difference) > _APART_S:
            apart[stream.name] = difference
    if apart:
        words = ", ".join(f"{name} ({s:+.6g} s)" for name, s in apart.items())
        findings.warn(
            "clocks_differ",
            f"Clocks differ from that of {first.name}, as neighbouring records tell: {words}. Nothing was moved.",
            len(apart),
        )
    return set(apart)


def look_at_receipt(time_s: Floats, received_s: Floats, findings: Findings) -> None:
    """Report times of day that are hours away from the clock of the capture, which gives the date."""
    late = received_s - time_s
    late = late[np.isfinite(late)]
    if late.size and abs(float(np.median(late))) > _LONGEST_DELAY_S:
        findings.warn(
            "capture_clock_differs",
            f"The records were captured {float(np.median(late)):+.6g} s after their own times: one of the clocks is "
            "no UTC. The date is that of the capture.",
        )
