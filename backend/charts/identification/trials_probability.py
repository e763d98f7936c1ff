"""Correct, wrong and undecided against a swept value: separation, accuracy, base, azimuth of the base, tail."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.recording import PolarPlots
from backend.charts.figure import ChartNote, Trace, axis, figure, marker_of, not_applicable, trace
from backend.charts.identification.samples import Measured, measured, swept_names
from backend.charts.swept import title_of
from backend.charts.trial_curves import line_of_variant
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Probabilities against the swept value"
METRICS = (
    ("probability_correct", "correct", "solid"),
    ("probability_wrong", "wrong", "dot"),
    ("probability_undecided", "undecided", "dash"),
    ("assignment_correct", "most likely matching correct", "longdash"),
    ("false_rejection", "true pairs outside the gate", "dashdot"),
)
MOST_TICKS = 12


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the metrics of every algorithm with their 95 % intervals."""
    traces: list[Trace] = []
    names: list[str] = []
    for entry in view.entries:
        for metric, word, dash in METRICS:
            traces += [line_of_metric(entry, one, word, dash) for one in measured(entry, metric)]
        names += swept_names(entry.table("metrics"))
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    first = names[0]
    x = np.unique(np.concatenate([np.asarray(t["x"], float) for t in traces]))
    notes = [ChartNote("probabilities", "Bars are 95 % intervals over the trials.")]
    ticks = ticks_of(first, x, view)
    if "ticktext" in ticks and any("κ" in text for text in ticks["ticktext"]):
        notes.append(
            ChartNote("nonlinearity", "κ = range times squared azimuth error over range error; from 0.4 on it matters.")
        )
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        xaxis=axis(title_of(first, view), **ticks),
        yaxis=axis("Probability", range=[-0.01, 1.02]),
    )


def line_of_metric(entry: Entry, one: Measured, word: str, dash: str, **more: Any) -> Trace:
    """One metric over the swept values, with intervals."""
    look = line_of_variant(entry, one.variant, one.variants) | {"dash": dash}
    name = f"{one.name}, {word}"
    bars = {
        "type": "data",
        "symmetric": False,
        "array": np.nan_to_num(one.high - one.value),
        "arrayminus": np.nan_to_num(one.value - one.low),
        "width": 3,
        "thickness": 1,
    }
    return trace(
        "series",
        one.x,
        one.value,
        entry=entry,
        name=name,
        mode="lines+markers",
        line=look,
        marker=marker_of(entry, 5) | {"color": look["color"]},
        error_y=bars,
        hovertemplate=f"<b>{name}</b><br>%{{x:g}}: %{{y:.4~g}}<extra></extra>",
        **more,
    )


def ticks_of(name: str, x: np.ndarray, view: RunView) -> dict[str, Any]:
    """A tick at every swept value; with the nonlinearity index where accuracies are swept, and both azimuths."""
    if x.size > MOST_TICKS:
        return {}
    text = [f"{v:g}" for v in x]
    short = name.rpartition(".")[2]
    if short == "base_azimuth_deg":
        text = [f"{v:g}<br>b0 = {90 - v:g}" for v in x]
    elif short == "sigma_azimuth_deg":
        reach = _range_over_error(view)
        if reach is not None:
            text = [f"{v:g}<br>κ {reach * np.radians(v) ** 2:.2g}" for v in x]
    wide = bool((x > 0).all()) and x.size > 1 and x.max() / x.min() >= 5
    return {"tickmode": "array", "tickvals": x.tolist(), "ticktext": text, "type": "log" if wide else "linear"}


def _range_over_error(view: RunView) -> float | None:
    """Range of the first plot over its radar's range error."""
    recording = view.recording
    if not isinstance(recording, PolarPlots) or not len(recording) or recording.site is None:
        return None
    errors = [r.sigma_range_m for r in recording.site.radars]
    if not errors or errors[0] is None or not np.isfinite(recording.truth_m[0]).all():
        return None
    radar = recording.site.radar_positions()[0]
    return float(np.hypot(*(recording.truth_m[0, :2] - radar[:2]))) / errors[0]


CHART = Chart(
    name="trials_probability",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("polar_plots",),
    least_sweeps=1,
)
