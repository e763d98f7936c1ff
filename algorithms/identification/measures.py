"""Metrics of one recording: how many plots found a partner, and, with truth, how many the right one."""

from __future__ import annotations

import numpy as np

from algorithms.identification.instants import truth_at
from algorithms.identification.outputs import ACCEPTED, MISSING, NOT_COMPARED, SEVERAL, UNDECIDED, UNUSABLE
from algorithms.identification.scenario import CLUTTER
from algorithms.recording import PolarPlots
from algorithms.result import Metric, Result


def dof_of(result: Result) -> int:
    """Degrees of freedom of a pair: of two places, or of two tracks with their velocities."""
    return 4 if "track" in result.arrays else 2


def measure(recording: PolarPlots, result: Result) -> list[Metric]:
    """Return the shares of plots, the agreement of the accepted pairs and, with named targets, how many are right."""
    a = result.arrays
    decision = a["decision"]
    usable = ~np.isin(decision, (MISSING, NOT_COMPARED, UNUSABLE))
    count = int(usable.sum())

    def share(metric: str, hits: int, of: int) -> Metric:
        return Metric(metric, hits / of if of else None, "1", of)

    out = [
        share("accepted_share", int((decision[usable] == ACCEPTED).sum()), count),
        share("undecided_share", int(np.isin(decision[usable], (UNDECIDED, SEVERAL)).sum()), count),
    ]
    accepted = a["pair_decision"] == ACCEPTED
    statistic = a["pair_statistic"][accepted]
    n = statistic.size
    out.append(Metric("nis", float(statistic.mean()) / dof_of(result) if n else None, "1", n))
    return out + _against_truth(recording, result) + _errors(recording, result)


def _against_truth(recording: PolarPlots, result: Result) -> list[Metric]:
    """Recall and precision of the pairs, where targets have names."""
    a = result.arrays
    known = np.array([name not in ("", CLUTTER) for name in recording.targets])
    judged = np.array([name != "" for name in recording.targets])
    if not known.any():
        return []
    place = {int(row): k for k, row in enumerate(a["row"])}
    pairs = a["pair_row"]
    first, second = (np.array([place[int(r)] for r in pairs[:, s]], np.int64) for s in (0, 1))
    t1, t2 = recording.target[first], recording.target[second]
    same = ((t1 == t2) & known[t1])[:, None]
    here = np.isfinite(a["pair_statistic"])
    accepted = (a["pair_decision"] == ACCEPTED) & (judged[t1] & judged[t2])[:, None]
    exist, right, made = int((same & here).sum()), int((same & accepted).sum()), int(accepted.sum())
    rejected = int((same & here & (a["pair_statistic"] > a["threshold"][0])).sum())
    return [
        Metric("recall", right / exist if exist else None, "1", exist),
        Metric("precision", right / made if made else None, "1", made),
        Metric("false_rejection", rejected / exist if exist else None, "1", exist),
    ]


def _errors(recording: PolarPlots, result: Result) -> list[Metric]:
    """Errors of the fused positions, where the truth is known."""
    if not recording.has_truth:
        return []
    a = result.arrays
    anchors = a["group"] == a["row"][:, None]
    error = a["fused_m"] - truth_at(recording, a["instant_s"])[:, :, None]
    squared = (error * error).sum(axis=1)
    keep = anchors & np.isfinite(squared)
    n = int(keep.sum())
    claim = (a["fused_covariance_m2"][:, 0] + a["fused_covariance_m2"][:, 1])[keep]
    return [
        Metric("rms_horizontal_m", float(np.sqrt(squared[keep].mean())) if n else None, "m", n),
        Metric("median_horizontal_m", float(np.sqrt(np.median(squared[keep]))) if n else None, "m", n),
        Metric("claimed_horizontal_m", float(np.sqrt(claim.mean())) if n else None, "m", n),
    ]
