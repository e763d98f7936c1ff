"""Tables of receivers: the verdict on each, what leaving it out would change, and how late each seems over time.

How late receiver j seems in an interval of time is the least-squares delay of its receptions there, sum(m_j) /
sum(M_jj), with the variance sigma_j^2 / sum(M_jj) (see `receivers`): the part of its residuals that its own marks can
tell, while receivers that are named do not take part. A clock that drifts makes a slope, one that jumps a step, and a
receiver that stands elsewhere a curve that follows the traffic.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.receiver_faults import FEWEST_RECEPTIONS, LEAST_REDUNDANCY, RATIO_CAP, Left
from algorithms.multilateration.receivers import Judged, judge_receivers
from algorithms.recording import ToaMarks
from algorithms.result import Result, Table
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]

# Intervals into which a recording is cut, fewer where a receiver would have hardly any receptions in one.
INTERVALS = 40
FEWEST_IN_INTERVAL = 5


def receiver_tables(recording: ToaMarks, result: Result) -> dict[str, Table]:
    """Return the tables `receivers` and `receiver_delays`."""
    judged = judge_receivers(recording, _as_used(result))
    return {"receivers": _receivers(recording, result, judged), "receiver_delays": _delays(recording, judged)}


def _as_used(result: Result) -> AltitudeParameters:
    """Return the measurement errors that the run gave; the rest comes from the site again."""
    names = ("sigma_toa_ns", "sigma_altitude_m", "earth")
    return AltitudeParameters(
        **{n: result.settings[n].value for n in names if n in result.settings and result.settings[n].source == "run"}
    )


def _receivers(recording: ToaMarks, result: Result, judged: Judged) -> Table:
    residual = np.where(result.arrays["used"], result.arrays["residual_m"], np.nan)
    names = recording.stations
    mean = np.full(len(names), np.nan)
    sd = np.full(len(names), np.nan)
    for s in range(len(names)):
        values = residual[:, s][np.isfinite(residual[:, s])]
        if values.size:
            mean[s] = values.mean()
        if values.size > 1:
            sd[s] = values.std(ddof=1)
    effects = np.full((7, len(names)), np.nan)
    for s, without in judged.without.items():
        effects[:, s] = _effect(recording, judged, judged.left[s], without)
    solved_with, solved_without, misfit_with, misfit_without, shift, error_with, error_without = effects
    return Table(
        {
            "station": list(names),
            "receptions": np.isfinite(residual).sum(axis=(0, 2)),
            "residual_mean_m": mean,
            "residual_sd_m": sd,
            "suspect": np.array([np.nan if v.suspect is None else float(v.suspect) for v in judged.verdicts]),
            "reason": [v.reason for v in judged.verdicts],
            "fault": [v.kind for v in judged.verdicts],
            "solved_with": solved_with,
            "solved_without": solved_without,
            "misfit_with": misfit_with,
            "misfit_without": misfit_without,
            "shift_without_m": shift,
            "error_with_m": error_with,
            "error_without_m": error_without,
        }
    )


def _effect(recording: ToaMarks, judged: Judged, whole: Left, without: Left) -> tuple[float, ...]:
    """What leaving a receiver out changes: marks solved, misfit, by how far fixes move, their median errors."""
    both, i, j = np.intersect1d(whole.row, without.row, return_indices=True)
    moved = np.linalg.norm(whole.position_m[i, :2] - without.position_m[j, :2], axis=1)
    errors = [np.nan, np.nan]
    if recording.has_truth and both.size:
        truth = judged.truth_m[both, :2]
        for n, place in enumerate((whole.position_m[i, :2], without.position_m[j, :2])):
            off = np.linalg.norm(place - truth, axis=1)
            errors[n] = float(np.nanmedian(off)) if np.isfinite(off).any() else np.nan
    return (
        float(whole.row.size),
        float(without.row.size),
        _misfit(whole, judged),
        _misfit(without, judged),
        float(np.median(moved)) if moved.size else np.nan,
        *errors,
    )


def _misfit(left: Left, judged: Judged) -> float:
    """Root mean square of the residuals in their standard deviations, wild ones counted as ten: 1 is right."""
    ratio = np.minimum(np.abs(left.ratio(judged.conditions)), RATIO_CAP)
    return float(np.sqrt(np.mean(ratio**2))) if ratio.size >= FEWEST_RECEPTIONS else np.nan


def _delays(recording: ToaMarks, judged: Judged) -> Table:
    """How late each receiver seems, interval by interval."""
    stations: list[str] = []
    columns: list[Floats] = []
    begin, end = (float(recording.time_s[0]), float(recording.time_s[-1])) if len(recording) else (0.0, 0.0)
    for s, name in enumerate(recording.stations):
        left = judged.left[s]
        use = left.heard[:, s] & (left.redundancy[:, s] > LEAST_REDUNDANCY)
        count = int(use.sum())
        intervals = min(INTERVALS, count // FEWEST_IN_INTERVAL)
        if not intervals:
            continue
        width = max((end - begin) / intervals, 1e-9)
        which = np.minimum(((left.time_s[use] - begin) / width).astype(np.int64), intervals - 1)
        weight = np.bincount(which, left.redundancy[use, s], intervals)
        total = np.bincount(which, left.residual_m[use, s], intervals)
        number = np.bincount(which, minlength=intervals)
        kept = np.flatnonzero(number >= FEWEST_IN_INTERVAL)
        mean_time = np.bincount(which, left.time_s[use], intervals)[kept] / number[kept]
        late = total[kept] / weight[kept]
        sd = np.sqrt(judged.conditions.variance[s] / weight[kept])
        stations += [name] * kept.size
        columns.append(np.stack([mean_time, number[kept], late, sd]))
    time, number, late, sd = np.concatenate(columns, axis=1) if columns else np.empty((4, 0))
    per_ns = SPEED_OF_LIGHT_MPS * 1e-9
    return Table(
        {
            "station": stations,
            "time_s": time,
            "receptions": number,
            "late_m": late,
            "late_sd_m": sd,
            "late_ns": late / per_ns,
            "late_sd_ns": sd / per_ns,
        }
    )
