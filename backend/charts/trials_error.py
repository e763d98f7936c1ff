"""Horizontal error over trials at each instant: actual with its 95 % interval, claimed, and the Cramer-Rao bound."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, counted, figure, log_axis, not_applicable, time_axis, trace
from backend.charts.trial_curves import Series, band, bands_left_out, leg_shapes, line, means_over_targets, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Horizontal error over trials"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw root mean squares over the trials; the claim of the algorithm dashed beside them."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers("rms_horizontal_m")).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        traces += band(series, series.numbers("rms_horizontal_m_low"), series.numbers("rms_horizontal_m_high"))
    for series in found:
        for column, word, look in (
            ("rms_horizontal_m", "actual", {"width": 2}),
            ("claimed_horizontal_m", "claimed", {"width": 1, "dash": "dot"}),
        ):
            values = series.numbers(column)
            if np.isfinite(values).any():
                name = f"{series.name}, {word}"
                traces.append(line(series, name, values, options, picked, "rms %{y:,.3~r} m", **look))
        _add_bound(series, traces)
    trials = counted(min(s.trials for s in found), "trial")
    notes = [ChartNote("trials", f"Root mean square over {trials}; bands are 95 % intervals; dotted is the claim.")]
    notes += means_over_targets(found)
    for entry in view.entries:
        notes += bands_left_out(entry, found, "rms_horizontal_m_low", "rms_horizontal_m_high")
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(view.recording),
        yaxis=log_axis("Horizontal error (rms), m", [t for t in traces if t["meta"]["role"] == "series"]),
        **leg_shapes(view.legs),
    )


def _add_bound(series: Series, traces: list[Trace]) -> None:
    """The bound once for each different one: filters with the same model share it."""
    bound = series.numbers("bound_horizontal_m")
    if not np.isfinite(bound).any():
        return
    known = [t for t in traces if t["meta"]["role"] == "bound"]
    if any(len(t["y"]) == bound.size and np.allclose(t["y"], bound, rtol=1e-6, equal_nan=True) for t in known):
        return
    traces.append(
        trace(
            "bound",
            series.time_s,
            bound,
            name=f"bound of {series.name}",
            mode="lines",
            line={"color": theme.BOUND, "dash": "dot", "width": 1},
        )
    )


CHART = Chart(name="trials_error", title=TITLE, source="run", needs=("curves",), draw=draw, overlay="time")
