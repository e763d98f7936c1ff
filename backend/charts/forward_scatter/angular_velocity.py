"""Difference of the Dopplers and angular velocity over time, and for one receiver the azimuths with their fit."""

from __future__ import annotations

import numpy as np

from algorithms.recording import DopplerPairs, Recording
from algorithms.toolbox.frames.forward_scatter import scatter_frame
from algorithms.toolbox.sensors.doppler import doppler_hz
from backend.charts import theme
from backend.charts.columns import Floats
from backend.charts.decimate import Picked, curve
from backend.charts.figure import Trace, figure, line_of, not_applicable, time_axis, trace
from backend.charts.forward_scatter.panels import axis_number, broken, rows_of, stacked_axes
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Angular velocity"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw what the closed forms found; the exact value where the truth is known."""
    found = [(entry, rows) for entry in view.entries if (rows := rows_of(entry, "crossings")) is not None]
    found = [(entry, rows) for entry, rows in found if np.isfinite(rows.numbers("omega_rad_s")).any()]
    if not found:
        return not_applicable(TITLE, "no_angular_velocity")
    traces: list[Trace] = []
    picked: list[Picked] = []
    panels: list[tuple[str, str, float]] = [("omega_rad_s", "ω, deg/s", float(np.degrees(1)))]
    if any(np.isfinite(rows.numbers("difference_hz")).any() for _, rows in found):
        panels.append(("difference_hz", "f1 - f2, Hz", 1.0))
    for i, (name, _, scale) in enumerate(panels):
        key = f"y{axis_number(i)}"
        for entry, rows in found:
            value = scale * rows.numbers(name)
            points = curve(rows.time_s, (value,), rows.breaks, options.curve_points)
            if points.of == 0:
                continue
            picked.append(points)
            traces.append(
                trace(
                    "series",
                    points.take(rows.time_s),
                    options.number(points.take(value)),
                    entry=entry,
                    name=entry.label,
                    showlegend=i == 0,
                    yaxis=key,
                    mode="lines",
                    line=line_of(entry),
                    customdata=points.take(rows.row),
                    hovertemplate=f"<b>{entry.label}</b><br>%{{y:.4~r}}<br>%{{x:.3f}} s, "
                    "row %{customdata}<extra></extra>",
                )
            )
        exact = _exact(view.recording, name)
        if exact is not None:
            time = view.recording.time_s
            step = np.diff(time)
            flights = (
                np.append(True, step > 5 * np.median(step))[: time.size] if step.size else np.ones(time.size, bool)
            )
            traces.append(
                trace(
                    "truth",
                    broken(time, flights),
                    broken(scale * exact, flights),
                    name="exact, seen from the receivers",
                    showlegend=i == 0,
                    yaxis=key,
                    mode="lines",
                    line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
                )
            )
    last = f"y{axis_number(len(panels) - 1)}"
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        xaxis=time_axis(view.recording, anchor=last),
        **stacked_axes([title for _, title, _ in panels]),
    )


def _exact(recording: Recording, name: str) -> Floats | None:
    """(x v_y - y v_x) / (x^2 + y^2), rad/s, or the difference of the two Dopplers, Hz, of the true flight."""
    site = recording.site
    if not isinstance(recording, DopplerPairs) or not recording.has_truth or site is None or not site.transmitters:
        return None
    places = site.terminal_positions()
    count = len(site.transmitters)
    frame = scatter_frame(places[:count], places[count:])
    place, speed = frame.from_enu(recording.truth_m), frame.turned_from_enu(recording.truth_velocity_mps)
    if name == "omega_rad_s":
        square = place[:, 0] ** 2 + place[:, 1] ** 2
        exact = (place[:, 0] * speed[:, 1] - place[:, 1] * speed[:, 0]) / square
    elif (count, len(places)) == (1, 3) and site.wavelength_m is not None:
        transmitter, *receivers = frame.from_enu(places)
        # f1 - f2: of the receiver at the smaller y minus that at the larger.
        lower, upper = (
            doppler_hz(place, speed, transmitter, receiver, site.wavelength_m)
            for receiver in sorted(receivers, key=lambda r: float(r[1]))
        )
        exact = lower - upper
    else:
        return None
    return exact if np.isfinite(exact).any() else None


CHART = Chart(
    name="angular_velocity", title=TITLE, source="run", needs=("crossings",), draw=draw, kinds=("doppler_pairs",)
)
