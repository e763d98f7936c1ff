"""What is counted of windows against the truth, and their Cramer-Rao bound."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.plot_tracking.bound import seen_of
from algorithms.plot_tracking.radars import feeds_of
from algorithms.plot_tracking.scoring import Floats, Ints, instants, score_result
from algorithms.plot_tracking.truth import Matched, matched, truth_of
from algorithms.plot_tracking.window import Window
from algorithms.plot_tracking.window_fit import bound_m
from algorithms.plot_tracking.window_parameters import WindowParameters
from algorithms.plot_tracking.window_rows import numbers_of
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.scores import Scores, Tally

SHARES = ("converged", "lowest", "bends")
KEPT = ("rms_horizontal_m", "rms_velocity_mps", "rms_speed_mps", "rms_course_deg", "claimed_horizontal_m", "nees")


def score_windows(recording: PolarPlots, parameters: WindowParameters, result: Result) -> Scores:
    """Errors as the trackers have them, one period ahead, the bound, and how the descents went."""
    scores = score_result(recording, result)
    a: dict[str, Any] = dict(result.arrays)
    m = matched(recording, a, recording.range_m.shape[1])
    if m is None:
        return scores
    number = a["window_track"]
    known = _targets(recording, m)
    of = np.where(number < known.size, known[np.minimum(number, known.size - 1)], -1)
    at = _at(m, a, of, recording.range_m.shape[1])
    has = at >= 0

    def tally(name: str, unit: str, values: Floats, *, root: bool = False) -> Tally:
        """Over the windows whose value is a number."""
        here = np.where(has, values[np.maximum(at, 0)], np.nan) if values.size else np.full(at.shape, np.nan)
        real = np.isfinite(here)
        sums = np.where(real, here**2 if root else here, 0.0)
        return Tally(name, unit, sums, real.astype(float), root=root, compared=True, share=name.endswith("_share"))

    tallies = [t for t in scores.tallies if t.metric in KEPT]
    tallies += [tally(f"{name}_share", "1", a[f"window_{name}"]) for name in SHARES]
    tallies.append(tally("rms_ahead_m", "m", _ahead(m, a, of), root=True))
    tallies.append(tally("rms_series_m", "m", a["window_series_error_m"], root=True))
    limit = bound(recording, parameters)
    if limit is not None:
        inside = has & np.isfinite(limit)[:, None]
        squared = np.where(inside, np.nan_to_num(limit)[:, None] ** 2, 0.0)
        tallies.append(Tally("bound_horizontal_m", "m", squared, inside.astype(float), root=True))
    return Scores(tuple(tallies), scores.samples[:1], scores.time_s, scores.target, scores.targets)


def bound(recording: PolarPlots, parameters: WindowParameters) -> Floats | None:
    """(T,) m: Cramer-Rao bound of a window of six free parameters on the true path.

    NaN where the path manoeuvres inside the window, or a plot is missing in some trial.
    """
    feeds, _, _ = feeds_of(recording, parameters)
    if len(feeds) != 1 or parameters.trajectory != "ml6":
        return None
    (feed,) = feeds
    time = np.array([scan.time_s for scan in feed.plots.scans])
    truth = truth_of(recording, time)
    if truth is None:
        return None
    n = parameters.window_plots
    there = np.isfinite(truth.position_m[:, :, 0])
    usable = there & (seen_of(recording, feed.plots.scans, truth.names) > 1 - 1e-9)
    out = np.full(there.shape, np.nan)
    back = np.arange(1 - n, 1)
    for k in range(len(truth.names)):
        newest = np.arange(n - 1, time.size)
        newest = newest[usable[newest[:, None] + back, k].all(axis=1)]
        if not newest.size:
            continue
        scans = newest[None] + back[:, None]
        east, north = np.moveaxis(truth.position_m[scans, k] - feed.origin, -1, 0)
        rho = np.hypot(east, north)
        sigma_th = np.maximum(feed.sigma_th, feed.across_m / np.maximum(rho, 1.0))
        t, known = time[scans] - time[newest], np.ones(rho.shape, bool)
        out[newest, k] = bound_m(
            Window(rho, np.arctan2(east, north), t, known, np.full(rho.shape, feed.sigma_r), sigma_th)
        )
    found: Floats = out[there]
    return found


def _targets(recording: PolarPlots, m: Matched) -> Ints:
    """Place among the true targets of each number, -1 = has no truth."""
    _, by_name = numbers_of(recording)
    if not by_name:
        alone = len(m.truth.names) == 1 and not (recording.address >= 0).any()
        return np.array([-1, 0 if alone else -1])
    out = np.full(max(by_name.values()) + 1, -1)
    for k, name in enumerate(m.truth.names):
        if name in by_name:
            out[by_name[name]] = k
    return out


def _at(m: Matched, a: dict[str, Any], of: Ints, lanes: int) -> Ints:
    """(T, L) position of the window of every scan of every true target, -1 = none."""
    place = np.full((*m.truth.position_m.shape[:2], lanes), -1)
    w = np.flatnonzero(of >= 0)
    place[a["window_scan"][w], of[w], a["window_trial"][w]] = w
    found: Ints = place[instants(m)]
    return found


def _ahead(m: Matched, a: dict[str, Any], of: Ints) -> Floats:
    """(W,) m, error of the place one period ahead, where the next scan has a truth of the target."""
    scan = a["window_scan"]
    after = np.minimum(scan + 1, a["scan_time_s"].size - 1)
    same = (of >= 0) & (after > scan) & (a["scan_radar"][after] == a["scan_radar"][scan])
    off = a["window_ahead"] - m.truth.position_m[after, np.maximum(of, 0)]
    out: Floats = np.where(same, np.hypot(*off.T), np.nan)
    return out
