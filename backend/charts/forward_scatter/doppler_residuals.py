"""Dopplers minus what the last estimate of their pass gives, and chi2 of all data so far."""

from __future__ import annotations

import numpy as np

from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve, thin
from backend.charts.figure import (
    ChartNote,
    Trace,
    counted,
    figure,
    hollow_marker_of,
    line_of,
    marker_of,
    not_applicable,
    time_axis,
    trace,
)
from backend.charts.forward_scatter.panels import axis_number, rows_of, stacked_axes
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Residuals of the Dopplers"
# The first view of chi2 holds this share of the rows, in percent, and 1 in its middle.
VIEW = 90
LEAST_CHI2_VIEW = 3.0


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the residuals; hollow ones were not used. Below, chi2 per degree of freedom: 1 is honest."""
    traces: list[Trace] = []
    picked: list[Picked] = []
    of_chi2: list[Floats] = []
    for entry in view.entries:
        rows = rows_of(entry, "dopplers")
        if rows is None:
            continue
        residual, used = rows.numbers("residual_hz"), rows.numbers("used") > 0
        for role, keep, name in (("series", used, entry.label), ("rejected", ~used, f"{entry.label}, not used")):
            points = thin(np.flatnonzero(np.isfinite(residual) & keep), options.marks)
            if points.of == 0:
                continue
            picked.append(points)
            traces.append(
                trace(
                    "series" if role == "series" else "rejected",
                    points.take(rows.time_s),
                    options.number(points.take(residual)),
                    entry=entry,
                    name=name,
                    showlegend=role == "series",
                    mode="markers",
                    marker=marker_of(entry, 5) if role == "series" else hollow_marker_of(entry),
                    customdata=points.take(rows.row),
                    hovertext=[f"channel {c}" for c in points.take(rows.words("channel")).tolist()],
                    hovertemplate=f"<b>{name}</b>, %{{hovertext}}<br>%{{y:.3f}} Hz<br>%{{x:.3f}} s, "
                    "row %{customdata}<extra></extra>",
                )
            )
        chi2 = rows_of(entry, "crossings")
        if chi2 is None:
            continue
        dof = chi2.numbers("dof")
        value = np.where(dof > 0, chi2.numbers("chi2") / np.maximum(dof, 1), np.nan)
        points = curve(chi2.time_s, (value,), chi2.breaks, options.curve_points)
        if points.of:
            of_chi2.append(value[np.isfinite(value)])
            picked.append(points)
            traces.append(
                trace(
                    "series",
                    points.take(chi2.time_s),
                    options.number(points.take(value)),
                    entry=entry,
                    name=f"{entry.label}, chi2",
                    showlegend=False,
                    yaxis="y2",
                    mode="lines",
                    line=line_of(entry),
                    hovertemplate=f"<b>{entry.label}</b><br>chi2 per degree of freedom %{{y:.3f}}<br>"
                    "%{x:.3f} s<extra></extra>",
                )
            )
    if not traces:
        return not_applicable(TITLE, "no_dopplers")
    titles = ["Residual, Hz", "Chi2 / dof"] if of_chi2 else ["Residual, Hz"]
    axes = stacked_axes(titles)
    notes: list[ChartNote] = []
    if of_chi2:
        together = np.concatenate(of_chi2)
        # The first fits of a pass have hardly any degrees of freedom; one false value then makes hundreds.
        most = max(LEAST_CHI2_VIEW, 1.3 * float(np.percentile(together, VIEW)))
        if (together > most).any():
            axes["yaxis2"]["range"] = [0.0, most]
            text = f"Chi2 of {counted(int((together > most).sum()), 'row')} lies above the first view."
            notes.append(ChartNote("chi2_above_view", text))
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(view.recording, anchor=f"y{axis_number(len(titles) - 1)}"),
        **axes,
    )


CHART = Chart(
    name="doppler_residuals",
    title=TITLE,
    source="run",
    needs=("dopplers", "crossings"),
    draw=draw,
    kinds=("doppler_pairs",),
)
