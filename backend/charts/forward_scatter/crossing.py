"""Distance, velocity and time of the crossing as each row gives them, with bands of two standard deviations."""

from __future__ import annotations

import numpy as np

from algorithms.forward_scatter.truth import true_crossings
from algorithms.recording import DopplerPairs, Recording
from algorithms.toolbox.frames.forward_scatter import scatter_frame
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve
from backend.charts.figure import Trace, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import DOUBTFUL, Rows, axis_number, band_of, rows_of, stacked_axes
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "What is known of the crossing"
PANELS = (
    ("distance_m", "Distance, km", 1e-3, "km"),
    ("across_mps", "Velocity across, m/s", 1.0, "m/s"),
    ("crossing_s", "Crossing time, s", 1.0, "s"),
)
# The first view holds the middle of the answers; the first rows of a pass are wild.
VIEW = (10, 90)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw a panel for each quantity."""
    found = [(entry, rows) for entry in view.entries if (rows := rows_of(entry, "crossings")) is not None]
    if not found:
        return not_applicable(TITLE, "no_crossings")
    traces: list[Trace] = []
    picked: list[Picked] = []
    ranges: dict[str, list[Floats]] = {}
    for i, (name, _, scale, unit) in enumerate(PANELS):
        key = f"y{axis_number(i)}"
        for entry, rows in found:
            value = scale * np.where(_answered(rows), rows.numbers(name), np.nan)
            sd = scale * rows.numbers(f"sigma_{name}")
            with np.errstate(invalid="ignore"):
                wild = ~(sd < 3 * np.nanstd(value) + abs(np.nanmedian(value))) if np.isfinite(value).any() else sd > 0
            sd = np.where(wild, np.nan, sd)
            traces += band_of(
                entry, rows.time_s, value - 2 * sd, value + 2 * sd, f"{entry.label}, 2 sigma", rows.breaks, yaxis=key
            )
        for entry, rows in found:
            value = scale * np.where(_answered(rows), rows.numbers(name), np.nan)
            ranges.setdefault(key, []).append(value[np.isfinite(value)])
            traces += _curve(entry, rows, value, unit, key, i == 0, options, picked)
        true = _true(view.recording)
        if true is not None:
            values = scale * true[name]
            ranges[key].append(values[np.isfinite(values)])
            traces.append(
                trace(
                    "truth",
                    view.recording.time_s,
                    values,
                    name="true",
                    showlegend=i == 0,
                    yaxis=key,
                    mode="lines",
                    line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
                    hovertemplate=f"<b>true</b><br>%{{y:.4~r}} {unit}<extra></extra>",
                )
            )
    axes = stacked_axes([title for _, title, _, _ in PANELS])
    for key, shown in ranges.items():
        together = np.concatenate(shown)
        if together.size:
            low, high = np.percentile(together, VIEW)
            margin = 0.6 * (high - low) + 0.02 * abs(high) + 1e-6
            axes[f"yaxis{key[1:]}"]["range"] = [float(low - margin), float(high + margin)]
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording, anchor=f"y{axis_number(len(PANELS) - 1)}"),
        **axes,
    )


def _answered(rows: Rows) -> np.ndarray:
    status = rows.words("status")
    return np.isin(status, ("fallback", "extrapolated", "crossed", "fitted", "held"))


def _curve(
    entry: Entry, rows: Rows, value: Floats, unit: str, key: str, legend: bool, options: ChartOptions,
    picked: list[Picked],
) -> list[Trace]:  # fmt: skip
    points = curve(rows.time_s, (value,), rows.breaks, options.curve_points)
    if points.of == 0:
        return []
    picked.append(points)
    # Hollow where the crossing still lies ahead, or where something took the answer's place.
    status = points.take(rows.words("status"))
    symbols = [theme.series_symbol(entry.index) + ("-open" if word in DOUBTFUL else "") for word in status.tolist()]
    return [
        trace(
            "series",
            points.take(rows.time_s),
            options.number(points.take(value)),
            entry=entry,
            name=entry.label,
            showlegend=legend,
            yaxis=key,
            mode="lines+markers",
            line=line_of(entry),
            marker={"color": theme.series_color(entry.index), "symbol": symbols, "size": 5},
            customdata=points.take(rows.row),
            hovertext=[str(word) for word in status.tolist()],
            hovertemplate=f"<b>{entry.label}</b>, %{{hovertext}}<br>%{{y:.5~r}} {unit}<br>%{{x:.3f}} s, "
            "row %{customdata}<extra></extra>",
        )
    ]


def _true(recording: Recording) -> dict[str, Floats] | None:
    site = recording.site
    if not isinstance(recording, DopplerPairs) or not recording.has_truth or site is None or not site.transmitters:
        return None
    places = site.terminal_positions()
    count = len(site.transmitters)
    frame = scatter_frame(places[:count], places[count:])
    crossing = true_crossings(recording, frame)
    if not np.isfinite(crossing).any():
        return None
    speed = frame.turned_from_enu(recording.truth_velocity_mps)
    return {"distance_m": crossing[:, 1], "crossing_s": crossing[:, 0], "across_mps": speed[:, 1]}


CHART = Chart(name="crossing", title=TITLE, source="run", needs=("crossings",), draw=draw, kinds=("doppler_pairs",))
