"""The paper's trajectory alone: fitted to the last plots of a target that is known, with what it is compared with.

No gates, no memory that a manoeuvre cuts: each plot, with so many before it, gives an estimate. So it can be seen how
accurate a window is, in which parameters the descent finds its minimum, and what the paper's power series would cost.

References
----------
plots2006, section 3; specification 3 and 4.

Differences from the paper
--------------------------
The two systems of eight equations are singular (`base_points`), and what stands in their place is chosen by `descent`.
The series is for show: the chord form is exact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.plot_tracking import outputs
from algorithms.plot_tracking.history import Estimates, History, Ints
from algorithms.plot_tracking.measures import measure as measure_tracks
from algorithms.plot_tracking.radars import Feed, feeds_of
from algorithms.plot_tracking.tables import tabulate as tabulate_tracks
from algorithms.plot_tracking.tables import trial_of
from algorithms.plot_tracking.window_fit import Found, found_of
from algorithms.plot_tracking.window_parameters import WindowParameters
from algorithms.plot_tracking.window_rows import Rows, numbers_of, rows_of
from algorithms.plot_tracking.window_scoring import SHARES, bound, score_windows
from algorithms.recording import PolarPlots
from algorithms.result import Metric, Output, Result, Setting, Table
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.tracks import life_cycle

# Windows that are fitted before somebody is asked whether to go on.
CHUNK = 500
NUMBERS = ("chi2", "series_error_m")
WINDOW_OUTPUTS = (
    Output("window_trial", ("window",), "", "trial"),
    Output("window_track", ("window",), "", "number of the target"),
    Output("window_scan", ("window",), "", "position of its newest plot's scan in scan_time_s"),
    Output("window_ahead", ("window", "element"), "m", "east and north one period after the newest plot"),
    Output("window_chi2", ("window",), "1", "sum of the squared residuals, each over its error; NaN = no fit"),
    Output("window_converged", ("window",), "", "1 = the last step of the descent was short"),
    Output("window_lowest", ("window",), "", "1 = no other way found a lower minimum; NaN = not looked for"),
    Output("window_bends", ("window",), "", "1 = the curvature changes its sign inside the window"),
    Output("window_series_error_m", ("window",), "m", "of the series, cut and so far ahead; NaN = has none"),
)


def run(recording: PolarPlots, parameters: WindowParameters, context: RunContext) -> Result:
    """Fit a window for each plot of a known target that has enough plots before it."""
    feeds, settings, notes = feeds_of(recording, parameters)
    history = History(*recording.range_m.shape)
    number, _ = numbers_of(recording)
    windows: list[dict[str, Any]] = []
    context.check_cancelled()
    for i, feed in enumerate(feeds):
        history.begin(feed)
        rows = rows_of(feed, number, parameters.window_plots)
        parts = []
        for begin in range(0, rows.lane.size, CHUNK):
            context.check_cancelled()
            context.progress((i + begin / max(rows.lane.size, 1)) / len(feeds))
            part = slice(begin, begin + CHUNK)
            parts.append(found_of(rows.window(part, feed), parameters, feed.period_s))
        found = Found(*(np.concatenate(part) for part in zip(*parts, strict=True))) if parts else None
        windows.append(_written(feed, rows, found, number, history, sum(len(f.plots.scans) for f in feeds[:i])))
    context.progress(1.0)
    settings |= {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in settings and getattr(parameters, name) is not None
    }
    of_windows = {
        name: np.concatenate([w[name] for w in windows]) if windows else array for name, array in _none().items()
    }
    return Result(history.arrays(recording.row) | of_windows, tuple(notes), settings)


def _none() -> dict[str, Any]:
    whole = ("window_trial", "window_track", "window_scan")
    return {
        o.name: np.empty((0, 2) if len(o.axes) > 1 else 0, np.int64 if o.name in whole else float)
        for o in WINDOW_OUTPUTS
    }


def _written(
    feed: Feed, rows: Rows, found: Found | None, number: Ints, history: History, before: int
) -> dict[str, Any]:
    """Write a radar's scans and estimates down; return its arrays of windows."""
    at = np.searchsorted(rows.scan, np.arange(len(feed.plots.scans) + 1))
    for s, scan in enumerate(feed.plots.scans):
        history.begin_scan(feed, scan.time_s)
        none = np.full(scan.rho.size, np.nan)
        of = number[scan.position]
        history.take(
            scan, decision=np.where(of > 0, outputs.UPDATED, outputs.STARTED), gate=np.full(of.size, outputs.NO_GATE),
            number=of, distance=none, threshold=none, rivals=np.zeros(of.size, np.int64),
        )  # fmt: skip
        if found is not None:
            which = np.arange(at[s], at[s + 1])
            which = which[found.sound[which]]
            history.estimates(feed, _estimates(rows, found, which))
    if found is None:
        return _none()
    ahead = np.stack(feed.to_site(found.ahead[:, 0], found.ahead[:, 1]), axis=1)
    return {
        "window_trial": rows.lane,
        "window_track": rows.number,
        "window_scan": rows.scan + before,
        "window_ahead": ahead,
        "window_chi2": found.cost,
        "window_converged": found.converged,
        "window_lowest": found.lowest,
        "window_bends": found.bends,
        "window_series_error_m": found.series_error,
    }


def _estimates(rows: Rows, found: Found, which: Ints) -> Estimates:
    size = which.size
    plots = np.full(size, float(len(rows.mark)))
    none = np.full(size, np.nan)
    return Estimates(
        lane=rows.lane[which],
        number=rows.number[which],
        time_s=rows.t[-1, which],
        mark=rows.mark[-1, which],
        outside=np.full(size, -1),
        status=np.full(size, life_cycle.CONFIRMED),
        misses=np.zeros(size, np.int64),
        state=found.state[which],
        covariance=found.covariance[which],
        motion=np.stack([*found.motion[which].T, none, plots], axis=1),
        nis=none,
        weights=np.empty((size, 0)),
    )


def tabulate(recording: PolarPlots, result: Result) -> dict[str, Table]:
    """Return states, tracks, decisions and, with truth, errors as the trackers do; and windows."""
    all_tables = tabulate_tracks(recording, result)
    a: dict[str, Any] = dict(result.arrays)
    scan = a["window_scan"]
    columns = {
        "trial": trial_of(a["window_trial"], a),
        "track": a["window_track"].astype(float),
        "time_s": a["scan_time_s"][scan],
        "east_ahead_m": a["window_ahead"][:, 0],
        "north_ahead_m": a["window_ahead"][:, 1],
        **{name: a[f"window_{name}"] for name in (*NUMBERS, *SHARES)},
    }
    names = ("states", "tracks", "decisions", "errors")
    return {name: all_tables[name] for name in names if name in all_tables} | {"windows": Table(columns)}


def measure(recording: PolarPlots, result: Result) -> list[Metric]:
    """Return errors as the trackers have them, and how the descents went."""
    kept = ("rms_horizontal_m", "median_horizontal_m", "rms_velocity_mps")
    out = [m for m in measure_tracks(recording, result) if m.metric in kept]
    for name in SHARES:
        values = np.asarray(result.arrays[f"window_{name}"])
        known = values[np.isfinite(values)]
        if known.size:
            out.append(Metric(f"{name}_share", float(known.mean()), "1", int(known.size)))
    series = np.asarray(result.arrays["window_series_error_m"])
    series = series[np.isfinite(series)]
    if series.size:
        out.append(Metric("rms_series_m", float(np.sqrt(np.mean(series**2))), "m", int(series.size)))
    return out


def score(recording: PolarPlots, parameters: WindowParameters, context: RunContext) -> Scores:
    """Fit the trials side by side and count against the truth."""
    return score_windows(recording, parameters, run(recording, parameters, context))


ALGORITHM = Algorithm(
    name="window_estimator",
    title="Trajectory through the last plots",
    summary="The curve of constant acceleration and curvature alone, fitted to the last plots of a known target: its "
    "accuracy, whether the descent finds the lowest minimum, and what a cut power series would cost.",
    family="plot_tracking",
    takes=("polar_plots",),
    parameters=WindowParameters,
    outputs=(*outputs.TRACK_OUTPUTS, *WINDOW_OUTPUTS),
    charts=(
        "plan",
        "track_scope",
        "track_motion",
        "radial_error",
        "drms",
        "trials_error",
        "trials_sweep",
        "trials_windows",
        "trials_series",
        "trials_consistency",
    ),
    references=(Reference("plots2006", "section 3"), Reference("more1978")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
