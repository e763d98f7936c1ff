"""Metrics of one recording: what became of the plots and, with truth, how good and how steady the tracks are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking.calibration import INNER, MIDDLE_ONE, OUTER, gate_classes
from algorithms.plot_tracking.joined_tables import joined_metrics
from algorithms.plot_tracking.outputs import LEFT_OUT, MANOEUVRE, NOT_DETECTED
from algorithms.plot_tracking.purity import purity_counts, taken_by
from algorithms.plot_tracking.scoring import FALSE_BELOW, manoeuvre_calls, manoeuvres, settled, switches, track_shares
from algorithms.plot_tracking.truth import Matched, matched
from algorithms.recording import PolarPlots
from algorithms.result import Metric, Result

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def measure(recording: PolarPlots, result: Result) -> list[Metric]:
    """Return shares of plots, of the gates' classes, and the metrics against the truth, all and target by target."""
    a: dict[str, Any] = dict(result.arrays)
    decision = a["decision"]
    lanes = decision.shape[1]
    usable = ~np.isin(decision, (NOT_DETECTED, LEFT_OUT))
    confirmed = np.unique(np.stack([a["estimate_trial"], a["estimate_track"]]), axis=1)
    of_confirmed = taken_by(a, confirmed, lanes)
    n = int(usable.sum())
    out = [
        Metric("confirmed_tracks", float(confirmed.shape[1]) / max(lanes, 1), "1", lanes),
        _share("tracked_plots_share", int((of_confirmed & usable).sum()), n),
    ]
    ellipse = gate_classes(a)
    followed = int((ellipse >= 0).sum())
    if followed:
        outside = int((a["estimate_outside"] >= 0).sum())
        for name, code in (("inner_share", INNER), ("middle_share", MIDDLE_ONE), ("outer_share", OUTER)):
            out.append(_share(name, int((ellipse == code).sum()), followed + outside))
        out.append(_share("outside_share", outside, followed + outside))
        out.append(_share("manoeuvre_share", int((decision == MANOEUVRE).sum()), followed))
    own, of_all = purity_counts(recording, a)
    if of_all.any():
        out.append(_share("purity", int(own.sum()), int(of_all.sum())))
    m = matched(recording, a, lanes)
    if len(recording.radars) > 1:
        out += joined_metrics(recording, a, m)
    return out + (_against_truth(m, a) if m is not None else [])


def _share(metric: str, hits: int, of: int) -> Metric:
    return Metric(metric, hits / of if of else None, "1", of)


def _against_truth(m: Matched, a: dict[str, Any]) -> list[Metric]:
    number = a["estimate_track"]
    _, _, _, share = track_shares(m, a)
    later = settled(m)[:, :, None]
    switched = switches(m, number)
    tracked = (m.estimate >= 0) & later
    count = int(later.sum()) * m.estimate.shape[2]
    error = np.hypot(m.error_m[:, 0], m.error_m[:, 1])
    known = np.isfinite(error)
    since = [d for s, d in enumerate(m.distances) if later[s].any()]
    out = [
        _rms("rms_horizontal_m", error[known], "m"),
        Metric("median_horizontal_m", float(np.median(error[known])) if known.any() else None, "m", int(known.sum())),
        _rms("rms_velocity_mps", np.hypot(*m.error_mps.T)[known], "m/s"),
        _share("tracked_share", int(tracked.sum()), count),
        Metric("switches", float(switched.sum()), "1", len(m.truth.names)),
        Metric("false_tracks", float((share < FALSE_BELOW).sum()), "1", int(share.size)),
    ]
    if since:
        out += [
            Metric(name, float(np.mean([getattr(d, name) for d in since])), "m", len(since))
            for name in ("ospa_m", "gospa_m")
        ]
        local = float(np.sqrt(np.mean([d.localisation for d in since])))
        out.append(Metric("gospa_localisation_m", local, "m", len(since)))
        out.append(Metric("gospa_missed", float(np.mean([d.missed for d in since])), "1", len(since)))
        out.append(Metric("gospa_false", float(np.mean([d.false for d in since])), "1", len(since)))
    begun = len(manoeuvres(m, a["scan_time_s"]))
    out.append(Metric("true_manoeuvres", float(begun), "1", begun))
    calls = manoeuvre_calls(m, a)
    delay = calls.delay_s[np.isfinite(calls.delay_s)]
    if begun:
        out.append(_share("manoeuvre_detected", int(calls.detected.sum()), int(calls.onset.sum())))
        median = float(np.median(delay)) if delay.size else None
        out.append(Metric("median_manoeuvre_delay_s", median, "s", int(delay.size)))
    quiet = calls.followed * calls.steady
    out.append(_share("manoeuvre_false_share", int((quiet * calls.called).sum()), int(quiet.sum())))
    if 1 < len(m.truth.names) <= 200:
        for k, name in enumerate(m.truth.names):
            own = known & (m.owner == k)
            there = int(later[:, k].sum()) * m.estimate.shape[2]
            share_k = int(tracked[:, k].sum()) / there if there else None
            out += [
                _rms("rms_horizontal_m", error[own], "m", name),
                Metric("tracked_share", share_k, "1", there, target=name),
                Metric("switches", float(switched[:, k].sum()), "1", 1, target=name),
            ]
    return out


def _rms(metric: str, values: Floats, unit: str, target: str = "") -> Metric:
    value = float(np.sqrt(np.mean(values**2))) if values.size else None
    return Metric(metric, value, unit, int(values.size), target=target)
