"""What each row says of the crossing: distance with its 95 % interval, velocity and time with two sigma."""

from __future__ import annotations

import numpy as np

from algorithms.forward_scatter.truth import true_crossings
from algorithms.recording import DopplerPairs, Recording
from algorithms.toolbox.frames.forward_scatter import scatter_frame
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve
from backend.charts.figure import Trace, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import DOUBTFUL, Rows, axis_number, band_of, broken, rows_of, stacked_axes
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "What is known of the crossing"
# Short titles: three panels share the height of a chart. The time counts from the last answer of its pass, because
# passes are minutes apart and the answers hundredths of a second.
PANELS = (
    ("distance_m", "s, km", 1e-3, "km"),
    ("across_mps", "v, m/s", 1.0, "m/s"),
    ("crossing_s", "Δτ, s", 1.0, "s"),
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
            value = scale * _values(rows, name)
            sd = scale * rows.numbers(f"sigma_{name}")
            with np.errstate(invalid="ignore"):
                wild = ~(sd < 3 * np.nanstd(value) + abs(np.nanmedian(value))) if np.isfinite(value).any() else sd > 0
            low, high, words = value - 2 * sd, value + 2 * sd, "2 sigma"
            if name == "distance_m" and np.isfinite(rows.numbers("distance_low_m")).any():
                # Of a distance that is uncertain the likelihood knows that it errs further to one side.
                low, high, words = (
                    scale * rows.numbers("distance_low_m"),
                    scale * rows.numbers("distance_high_m"),
                    "95 %",
                )
            low, high = np.where(wild, np.nan, low), np.where(wild, np.nan, high)
            traces += band_of(entry, rows.time_s, low, high, f"{entry.label}, {words}", rows.breaks, yaxis=key)
        for entry, rows in found:
            value = scale * _values(rows, name)
            ranges.setdefault(key, []).append(value[np.isfinite(value)])
            traces += _curve(entry, rows, value, unit, key, i == 0, options, picked)
        true = _true(view.recording)
        if true is not None and name in true:
            values = scale * true[name]
            ranges[key].append(values[np.isfinite(values)])
            flights = np.append(True, np.diff(true["crossing"]) != 0)[: values.size]
            traces.append(
                trace(
                    "truth",
                    broken(view.recording.time_s, flights),
                    broken(values, flights),
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


def _values(rows: Rows, name: str) -> Floats:
    """What the rows with an answer say; times count from the last answer of their pass."""
    answered = np.isin(rows.words("status"), ("fallback", "extrapolated", "crossed", "fitted", "held"))
    value = np.where(answered, rows.numbers(name), np.nan)
    if name == "crossing_s":
        for piece in np.split(np.arange(value.size), np.flatnonzero(rows.breaks)[1:]):
            known = piece[np.isfinite(value[piece])]
            if known.size:
                value[piece] -= value[known[-1]]
    return value


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
    return {"distance_m": crossing[:, 1], "crossing": np.nan_to_num(crossing[:, 0]), "across_mps": speed[:, 1]}


CHART = Chart(name="crossing", title=TITLE, source="run", needs=("crossings",), draw=draw, kinds=("doppler_pairs",))
