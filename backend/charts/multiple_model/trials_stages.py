"""How many times the first algorithm's vertical error another one makes, stage by stage, on the same draws."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts import theme
from backend.charts.columns import Ints, numbers, texts, words
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, trace
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView, swept_columns

TITLE = "Vertical error of each stage against the first algorithm"
POSITION, VELOCITY = "rms_up_m", "rms_velocity_up_mps"
WORDS = {POSITION: "position", VELOCITY: "velocity"}
# How far apart the algorithms of a stage stand.
ROOM = 0.7


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw ratios with their 95 % intervals: position as filled markers, velocity as hollow ones."""
    if len(view.entries) < 2:
        return not_applicable(TITLE, "nothing_to_compare")
    first = view.entries[0]
    stages = _stages(view)
    traces: list[Trace] = []
    for entry in view.entries[1:]:
        for metric in WORDS:
            found = [_ratio(first, entry, metric, stage) for stage in stages]
            known = [k for k, one in enumerate(found) if one is not None]
            if known:
                traces.append(_markers(entry, len(view.entries), metric, stages, known, [found[k] for k in known]))
    if not traces:
        return not_applicable(TITLE, "no_reference")
    ends = np.array([-0.5, len(stages) - 0.5])
    one = {"color": theme.BOUND, "dash": "dot", "width": 1}
    traces.append(trace("bound", ends, np.ones(2), name="as large", mode="lines", line=one))
    text = f"Root mean square error over that of {first.label}, on the same draws: below 1 it is smaller."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        notes=[ChartNote("stages", text)],
        # Lines stand between the stages; their names are written above, as those of legs over time are.
        xaxis=axis(
            "Stage", tickvals=(ends[0] + np.arange(1, len(stages))).tolist(), showticklabels=False, range=ends.tolist()
        ),
        yaxis=axis("Ratio of errors", type="log", range=_range(traces)),
        annotations=[
            {"x": k, "y": 1, "xref": "x", "yref": "paper", "text": stage, "showarrow": False, "yanchor": "top"}
            for k, stage in enumerate(stages)
        ],
    )


def _range(traces: list[Trace]) -> list[float]:
    """Logarithms that hold all ratios and the names above them."""
    values = np.log10(np.concatenate([np.asarray(t["y"], float) for t in traces]))
    room = max(float(values.max() - values.min()), 0.02)
    return [float(values.min()) - 0.2 * room, float(values.max()) + 0.35 * room]


def _stages(view: RunView) -> list[str]:
    """Names of the stages that were compared, in the order of the table."""
    names = [words(entry.table("comparisons"), "segment") for entry in view.entries]
    return list(dict.fromkeys(name for name in np.concatenate(names).tolist() if name))


def _ratio(first: Entry, entry: Entry, metric: str, stage: str) -> tuple[float, float, float] | None:
    """Ratio of the entry's error to the first one's, and its interval; the table has each pair once."""
    for owner, against, turned in ((entry, first, False), (first, entry, True)):
        table = owner.table("comparisons")
        rows = _rows(table, metric, stage, against.label)
        if rows.size == 1:
            value, low, high = (float(numbers(table, n)[rows[0]]) for n in ("ratio", "ratio_low", "ratio_high"))
            if not np.isfinite(value) or value <= 0:
                return None
            return (1 / value, 1 / high, 1 / low) if turned else (value, low, high)
    return None


def _rows(table: Table, metric: str, stage: str, against: str) -> Ints:
    if swept_columns(table):
        return np.empty(0, np.int64)
    keep = np.ones(len(table), np.bool_)
    for name, wanted in (("metric", metric), ("segment", stage), ("against", against), ("target", "")):
        keep &= texts(table, name).are(wanted)
    return np.flatnonzero(keep)


def _markers(entry: Entry, entries: int, metric: str, stages: list[str], known: list[int], found: list[Any]) -> Trace:
    value, low, high = (np.array(part, float) for part in zip(*found, strict=True))
    step = ROOM / (2 * (entries - 1))
    shift = -ROOM / 2 + step * (2 * (entry.index - 1) + 0.5 + (metric == VELOCITY))
    color = theme.series_color(entry.index)
    symbol = "circle" if metric == POSITION else "circle-open"
    return trace(
        "series",
        np.array(known) + shift,
        value,
        entry=entry,
        name=f"{entry.label}, {WORDS[metric]}",
        mode="markers",
        marker={"color": color, "size": 7, "symbol": symbol},
        error_y={"type": "data", "symmetric": False, "array": high - value, "arrayminus": value - low, "color": color,
                 "thickness": 1, "width": 3},
        text=[stages[k] for k in known],
        hovertemplate=f"<b>{entry.label}</b>, {WORDS[metric]}<br>%{{text}}: %{{y:.3f}} times<extra></extra>",
    )  # fmt: skip


CHART = Chart(name="trials_stages", title=TITLE, source="run", needs=("comparisons",), draw=draw,
              kinds=("antenna_plots",))  # fmt: skip
