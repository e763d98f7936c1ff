"""What is asked of a tracker against what it did: a row for each target, segment and requirement, with a verdict.

Segments are the whole life of a target from ten scans after its appearance on; its straight flight; its manoeuvres (the
true velocity changes by more than 0.5 m/s2); and the 40 s after each. Position errors count from the first estimate
on. A requirement without a threshold is given with its value and no verdict.

References
----------
Specification 8 for the segments.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.parameters import REQUIREMENTS
from algorithms.plot_tracking.scoring import FALSE_BELOW, manoeuvres, settled, switches, track_shares
from algorithms.plot_tracking.truth import Matched
from algorithms.result import Setting, Table

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SEGMENTS = ("whole", "straight", "manoeuvre", "recovery")
RECOVERY_S = 40.0
NOT_ASKED, NO_DATA, PASSED, FAILED = "not asked", "no data", "passed", "failed"


def thresholds_of(settings: dict[str, Setting]) -> dict[str, float]:
    """Thresholds that the run was given, by requirement."""
    given = {name: settings.get(parameter) for name, parameter in REQUIREMENTS.items()}
    return {name: float(s.value) for name, s in given.items() if s is not None and s.value is not None}


def requirements(m: Matched, a: dict[str, Any], asked: dict[str, float]) -> Table:
    """Return columns target, segment, requirement, value, threshold, unit, verdict, n; a null target is all of them."""
    rows: list[tuple[str | None, str, str, float | None, str, int]] = []
    inside = _segments(m, a["scan_time_s"])
    error = np.hypot(m.error_m[:, 0], m.error_m[:, 1])
    switched = switches(m, a["estimate_track"])
    has = m.estimate >= 0
    squared = np.where(has, error[np.maximum(m.estimate, 0)] ** 2, 0.0) if error.size else np.zeros(has.shape)
    for name, k in [(None, slice(None)), *((n or None, slice(i, i + 1)) for i, n in enumerate(m.truth.names))]:
        if name is not None and len(m.truth.names) == 1:
            continue
        for segment in SEGMENTS:
            here = inside[segment][:, k, None] & np.ones(has.shape[2], bool)
            n, with_track = int(here.sum()), int((here & has[:, k]).sum())
            mean_square = float(squared[:, k][here].sum()) / with_track if with_track else None
            rows += [
                (name, segment, "rms_horizontal_m", None if mean_square is None else mean_square**0.5, "m", with_track),
                (name, segment, "tracked_share", with_track / n if n else None, "1", n),
                (name, segment, "switches", float(switched[:, k][here].sum()) if n else None, "1", n),
            ]
    _, _, _, share = track_shares(m, a)
    rows.append((None, "whole", "false_tracks", float((share < FALSE_BELOW).sum()), "1", int(share.size)))
    return Table(
        {
            "target": [row[0] for row in rows],
            "segment": [row[1] for row in rows],
            "requirement": [row[2] for row in rows],
            "value": np.array([np.nan if row[3] is None else row[3] for row in rows]),
            "threshold": np.array([asked.get(row[2], np.nan) for row in rows]),
            "unit": [row[4] for row in rows],
            "verdict": [_verdict(row[2], row[3], asked.get(row[2])) for row in rows],
            "n": np.array([row[5] for row in rows], float),
        }
    )


def _verdict(requirement: str, value: float | None, asked: float | None) -> str:
    if asked is None:
        return NOT_ASKED
    if value is None:
        return NO_DATA
    good = value >= asked if requirement == "tracked_share" else value <= asked
    return PASSED if good else FAILED


def _segments(m: Matched, time_s: Floats) -> dict[str, Bools]:
    """(S, K) of each segment whether a scan lies in it."""
    whole = settled(m)
    turning, after = np.zeros(whole.shape, bool), np.zeros(whole.shape, bool)
    for k, begin, end in manoeuvres(m, time_s):
        same = m.radar == m.radar[begin]
        turning[:, k] |= same & (time_s > time_s[begin]) & (time_s <= time_s[end])
        after[:, k] |= same & (time_s > time_s[end]) & (time_s <= time_s[end] + RECOVERY_S)
    turning &= whole
    after &= whole & ~turning
    return {"whole": whole, "straight": whole & ~turning & ~after, "manoeuvre": turning, "recovery": after}
