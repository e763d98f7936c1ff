"""Paths of single trials across the base line, a few of them, with the true one (the paper's figure 4)."""

from __future__ import annotations

import json

import numpy as np
from numpy.typing import NDArray

from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, counted, figure, not_applicable, trace
from backend.charts.forward_scatter.panels import since_begin
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Paths of single trials"
TRIALS = 5
# So many paths can be told apart; of more entries and swept values fewer trials are drawn.
MOST_PATHS = 20
# The first answers of a pass jump by kilometres.
FIRST_S = 6.0
# A true place so many steps further belongs to another target.
JUMP_STEPS = 5.0
# The first view leaves out this share of the wildest places on each side.
OUTSIDE = 2


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the first trials of every entry and swept value, and the true path of each scenario once."""
    traces: list[Trace] = []
    true: dict[str, Trace] = {}
    shown: list[NDArray[np.float64]] = []
    found = [(entry, cell) for entry in view.entries for cell in _cells(entry)]
    most = min(TRIALS, max(MOST_PATHS // max(len(found), 1), 1))
    for entry, (words, variant, variants, paths, path) in found:
        trials = min(most, paths.shape[2])
        own = paths[:, :, :trials]
        shown.append(own.reshape(2, -1))
        # One line for all trials of a cell, broken between them.
        gap = np.full((2, 1, trials), np.nan)
        along, across = np.concatenate([own, gap], axis=1).transpose(0, 2, 1).reshape(2, -1)
        name = f"{entry.label}{words}"
        traces.append(
            trace(
                "series",
                along,
                options.number(across),
                entry=entry,
                name=name,
                mode="lines",
                line=line_of_variant(entry, variant, variants) | {"width": 1},
                hovertemplate=f"<b>{name}</b><br>x %{{x:.3f}} km, y %{{y:.3f}} km<extra></extra>",
            )
        )
        if path is not None and words not in true:
            true[words] = trace(
                "truth",
                path[0],
                path[1],
                name=f"true path{words}",
                showlegend=not true,
                mode="lines",
                line={"color": theme.TRUTH, "width": 1.5, "dash": "dash"},
                hovertemplate=f"<b>true path{words}</b><br>x %{{x:.3f}} km, y %{{y:.3f}} km<extra></extra>",
            )
    if not traces:
        return not_applicable(TITLE, "no_single_trials")
    together = np.concatenate([*shown, *(np.stack([t["x"], t["y"]]) for t in true.values())], axis=1)
    ranges = [np.nanpercentile(values, [OUTSIDE, 100 - OUTSIDE]) for values in together]
    text = (
        f"The first {counted(most, 'trial')} of each, from {FIRST_S:g} s after the first instant of a pass on; the "
        "scale across the base line is larger than along it."
    )
    return figure(
        TITLE,
        [*traces, *true.values()],
        recording=view.recording,
        notes=[ChartNote("single_trials", text)],
        xaxis=axis("Along the base line, km", range=_widened(ranges[0])),
        yaxis=axis("Across the base line, km", range=_widened(ranges[1])),
    )


def _widened(ends: NDArray[np.float64]) -> list[float]:
    margin = 0.1 * float(ends[1] - ends[0]) + 1e-3
    return [float(ends[0]) - margin, float(ends[1]) + margin]


def _cells(
    entry: Entry,
) -> list[tuple[str, int, int, NDArray[np.float64], NDArray[np.float64] | None]]:
    """Of each cell: swept values in words, its place among them, paths (2, instant, trial) km, true path or None."""
    arrays = entry.arrays()
    if "trials/cells" not in arrays:
        return []
    cells = json.loads(bytes(arrays["trials/cells"]).decode())
    out = []
    for i, swept in enumerate(cells):
        found = {}
        for name in ("place_along_m", "place_across_m", "true_place_along_m", "true_place_across_m"):
            array = arrays.get(f"trials/{name}/{i}")
            if array is None and f"trials/{name}" in arrays:
                array = arrays[f"trials/{name}"][i]
            if array is not None:
                found[name] = np.asarray(array, np.float64) / 1000
        if not {"place_along_m", "place_across_m"} <= set(found) or not found["place_along_m"].size:
            continue
        paths = np.stack([found["place_along_m"], found["place_across_m"]])
        true = None
        begins = np.zeros(1, np.int64)
        if "true_place_along_m" in found:
            true = np.stack([found["true_place_along_m"][:, 0], found["true_place_across_m"][:, 0]])
            begins = _begins(true)
        time = np.asarray(arrays.get(f"trials/kept_time_s/{i}", arrays.get("trials/kept_time_s", [])), np.float64)
        if time.size == paths.shape[1]:
            since = since_begin(time, np.isin(np.arange(time.size), begins))
            if since.max(initial=0.0) > FIRST_S:
                paths = np.where((since >= FIRST_S)[None, :, None], paths, np.nan)
        # A line must not run from one target to the next.
        paths = np.insert(paths, begins[1:], np.nan, axis=1)
        true = None if true is None else np.insert(true, begins[1:], np.nan, axis=1)
        words = "".join(f", {key.rpartition('.')[2]} = {_word(value)}" for key, value in swept.items())
        out.append((words, i, len(cells), paths, true))
    return out


def _begins(true: NDArray[np.float64]) -> NDArray[np.int64]:
    """Where the true places (2, instant) of another target begin: they jump by much more than one flies."""
    step = np.hypot(*np.diff(true, axis=1))
    usual = float(np.nanmedian(step)) if np.isfinite(step).any() else 0.0
    return np.append(0, np.flatnonzero(step > JUMP_STEPS * max(usual, 1e-9)) + 1)


def _word(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float) else str(value)


CHART = Chart(name="trials_paths", title=TITLE, source="run", needs=("curves",), draw=draw, kinds=("doppler_pairs",))
