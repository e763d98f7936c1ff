"""How late each receiver seems over time: the test of receivers, interval by interval.

A receiver without fault scatters about zero within its band; a clock that drifts makes a slope, one that jumps a step,
a receiver that stands elsewhere a curve that follows the traffic. What is named by the table `receivers` is strong.
"""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from backend.charts import theme
from backend.charts.columns import numbers, words
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, time_axis, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Delay of each receiver"
# Two standard deviations.
REACH = 2.0
# Of more receivers those that are not named are drawn alike.
MOST_COLOURED = 6


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the delays that the first entry's marks show; every entry has the same marks."""
    if not isinstance(view.recording, ToaMarks):
        return not_applicable(TITLE, "other_kind")
    found = [entry for entry in view.entries if len(entry.table("receiver_delays"))]
    if not found:
        return not_applicable(TITLE, "no_delays")
    traces, notes = _lines(view.recording, found[0], options)
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=notes,
        legend=True,
        xaxis=time_axis(view.recording),
        yaxis=axis("Later than the others say, m", zeroline=True, zerolinecolor=theme.AXIS),
    )


def _lines(recording: ToaMarks, entry: Entry, options: ChartOptions) -> tuple[list[Trace], list[ChartNote]]:
    table, judged = entry.table("receiver_delays"), entry.table("receivers")
    reasons = dict(zip(words(judged, "station"), words(judged, "reason"), strict=True))
    suspects = set(words(judged, "station")[numbers(judged, "suspect") == 1.0])
    station, time = words(table, "station"), numbers(table, "time_s")
    late, sd, count = numbers(table, "late_m"), numbers(table, "late_sd_m"), numbers(table, "receptions")
    heard = [name for name in recording.stations if (station == name).any()]
    traces: list[Trace] = []
    notes = [ChartNote("two_sd", "Bars are two standard deviations; about zero within them is as it should be.")]
    coloured = suspects if len(heard) > MOST_COLOURED else set(heard)
    place = {name: i for i, name in enumerate(sorted(coloured, key=heard.index))}
    for name in sorted(heard, key=lambda n: (n in suspects, heard.index(n))):
        rows = np.flatnonzero(station == name)
        color = theme.series_color(place[name]) if name in place else theme.MEASUREMENT
        bad = name in suspects
        marker = {"color": color, "size": 7 if bad else 4, "symbol": theme.series_symbol(place.get(name, 0))}
        traces.append(
            trace(
                "series" if name in place else "measurement",
                time[rows],
                options.number(late[rows]),
                name=f"station {name}",
                mode="lines+markers",
                # Names of twenty grey lines would tell none from another, and take half of the chart.
                showlegend=name in place,
                line={"color": color, "width": 2.5 if bad else 1, "dash": theme.series_dash(place.get(name, 0))},
                marker=marker,
                error_y={
                    "type": "data",
                    "array": options.number(REACH * sd[rows]),
                    "color": color,
                    "thickness": 1,
                    "width": 2,
                },
                hovertext=[f"{n:.0f} receptions" for n in count[rows]],
                hovertemplate=f"<b>station {name}</b><br>%{{x:.0f}} s, %{{y:.3~g}} m<br>%{{hovertext}}<extra></extra>",
            )
        )
        if bad:
            text = f"Station {name} disagrees with the others: {reasons[name]}."
            notes.append(ChartNote("suspect_receiver", text, entry.label))
    return traces, notes


CHART = Chart(
    name="receiver_delays", title=TITLE, source="run", needs=("receivers", "receiver_delays"), draw=draw,
    kinds=("toa_marks",),
)  # fmt: skip
