"""Curves of a Monte Carlo run as the charts of trials draw them: one series for each label and its swept values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Column
from backend.charts import theme
from backend.charts.decimate import Picked, curve, line_starts
from backend.charts.figure import ChartNote, Trace, counted, thousands, trace
from backend.charts.view import ChartOptions, Entry, RunView, swept_columns

Floats = NDArray[np.float64]

# Names of legs stand in rows under each other where they are wider than their legs on a chart of this width.
USUAL_PX, LETTER_PX, ROW_PX, MOST_ROWS = 700, 6, 13, 3
# Curves of more targets than these are a thicket: then their mean is drawn, and one that is chosen by itself.
MOST_TARGETS = 12
# Over targets these are root mean squares, as they are over trials.
_SQUARED = ("rms_", "claimed_", "bound_")
# The last of many swept values is drawn as faintly as this.
FAINTEST = 0.4


@dataclass(frozen=True)
class Series:
    """One line: the label gives the colour, the place among the label's variants shade and dash.

    `name` is the label with the swept values in words.
    """

    name: str
    entry: Entry
    columns: dict[str, NDArray[Any]]
    variant: int = 0
    variants: int = 1
    conditions: tuple[str, ...] = ()
    """Target and swept values of the scenario in words: what it shares with series of other labels."""
    targets: int = 1
    """Over how many targets it is a mean."""

    @property
    def look(self) -> dict[str, Any]:
        """Line of the series."""
        return line_of_variant(self.entry, self.variant, self.variants)

    @property
    def time_s(self) -> Floats:
        """Instants."""
        return self.columns["time_s"]

    @property
    def trials(self) -> int:
        """Of how many trials it tells."""
        return int(self.columns["trials"][0])

    def numbers(self, name: str) -> Floats:
        """A column; NaN throughout where the series has none of this name."""
        found = self.columns.get(name)
        return np.full(self.time_s.size, np.nan) if found is None else found


def series_of(view: RunView) -> list[Series]:
    """Series of a view in the order of labels, swept values and, where there are several and not too many, targets."""
    out: list[Series] = []
    for entry in view.entries:
        table = entry.table("curves")
        if not len(table):
            continue
        keys = swept_columns(table)
        names = _words(table.columns["target"])
        targets = {name for name in names if name}
        if 1 < len(targets) <= MOST_TARGETS:
            keys.append("target")
        groups = list(zip(*(_words(table.columns[name]) for name in keys), strict=True)) if keys else [()] * len(table)
        codes: dict[tuple[Any, ...], int] = {}
        group = np.fromiter((codes.setdefault(g, len(codes)) for g in groups), np.int64, len(groups))
        for values, code in codes.items():
            rows = np.flatnonzero(group == code)
            words = "".join(
                f", {name.rpartition('.')[2]} = {value}" for name, value in zip(keys, values, strict=True) if value
            )
            columns = {n: np.asarray(c)[rows] for n, c in table.columns.items() if isinstance(c, np.ndarray)}
            over = len({names[i] for i in rows}) if len(targets) > MOST_TARGETS else 1
            if over > 1:
                columns = _over_targets(columns)
            shared = tuple(
                f"{name} = {value}"
                for name, value in zip(keys, values, strict=True)
                if name == "target" or name.startswith("scenario.")
            )
            out.append(Series(f"{entry.label}{words}", entry, columns, code, len(codes), shared, over))
    return out


def _over_targets(columns: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    """Means over the targets that are there at an instant; of the mean no interval is known."""
    time_s, place = np.unique(columns["time_s"], return_inverse=True)
    out: dict[str, NDArray[Any]] = {}
    for name, values in columns.items():
        if name.endswith(("_low", "_high")):
            out[name] = np.full(time_s.size, np.nan)
            continue
        power = 2 if name.startswith(_SQUARED) else 1
        known = np.isfinite(values)
        total = np.bincount(place[known], values[known] ** power, time_s.size)
        count = np.bincount(place[known], minlength=time_s.size)
        with np.errstate(invalid="ignore", divide="ignore"):
            out[name] = np.where(count > 0, (total / count) ** (1 / power), np.nan)
    return out | {"time_s": time_s}


def means_over_targets(found: Sequence[Series]) -> list[ChartNote]:
    """Say that curves are means over targets, where they are."""
    most = max((series.targets for series in found), default=1)
    if most == 1:
        return []
    text = f"Mean over {counted(most, 'target')} at most; choose one to see it alone, with its intervals."
    return [ChartNote("mean_over_targets", text)]


def _words(column: Column) -> list[str]:
    """Values as words: numbers short, nothing where there is none."""
    if isinstance(column, np.ndarray):
        return ["" if not np.isfinite(v) else f"{v:g}" for v in column]
    return [value or "" for value in column]


def line_of_variant(entry: Entry, variant: int, variants: int) -> dict[str, Any]:
    """Line of one of an entry's variants: its colour, fainter from the first to the last, each with another dash."""
    opacity = 1 - (1 - FAINTEST) * variant / max(variants - 1, 1)
    color = theme.series_color(entry.index)
    return {
        "color": color if variant == 0 else theme.faint(color, round(opacity, 2)),
        "dash": theme.series_dash(entry.index + variant),
        "width": 1.5,
    }


def line(
    series: Series, name: str, values: Floats, options: ChartOptions, picked: list[Picked], hover: str, **look: Any
) -> Trace:
    """One curve of a series over time."""
    # Where targets come one after another a line over the silence between them would be an error of nobody.
    starts = line_starts(np.zeros(values.size, np.int64), series.time_s)
    positive = np.where(values > 0, values, np.nan)
    points = curve(series.time_s, (np.log(positive),), starts, options.curve_points)
    picked.append(points)
    return trace(
        "series",
        points.take(series.time_s),
        options.number(points.take(values)),
        entry=series.entry,
        name=name,
        mode="lines",
        line=series.look | look,
        hovertemplate=f"<b>{name}</b><br>{hover}<br>%{{x:.5~g}} s<extra></extra>",
    )


def band(series: Series, low: Floats, high: Floats, points: int = 400) -> list[Trace]:
    """95 % interval of a curve on a logarithmic axis as filled outlines; of a long one every k-th instant.

    Where the interval reaches down to 0 there is no band: drawn to the edge of the axis it would hide how wide it is.
    """
    step = max(1, low.size // points)
    rows = np.flatnonzero(np.isfinite(low) & np.isfinite(high))[::step]
    runs = np.split(rows, np.flatnonzero((np.diff(rows) > step) | (np.diff(low[rows] > 0))) + 1)
    runs = [run for run in runs if run.size and low[run[0]] > 0]
    if not runs:
        return []
    fill = theme.faint(theme.series_color(series.entry.index), theme.INTERVAL_OPACITY)
    gap = [np.nan]
    x = np.concatenate([part for r in runs for part in (series.time_s[r], series.time_s[r][::-1], gap)])
    y = np.concatenate([part for r in runs for part in (high[r], low[r][::-1], gap)])
    return [
        trace(
            "interval",
            x,
            y.astype(np.float32),
            entry=series.entry,
            name=f"{series.name}, 95 % interval",
            mode="lines",
            line={"width": 0},
            fill="toself",
            fillcolor=fill,
            showlegend=False,
            hoverinfo="skip",
        )
    ]


def bands_left_out(entry: Entry, found: Sequence[Series], low: str, high: str) -> list[ChartNote]:
    """Say at how many instants of an entry's curves `band` leaves the interval out."""
    out = of = 0
    for series in found:
        if series.entry is entry:
            known = np.isfinite(series.numbers(low)) & np.isfinite(series.numbers(high))
            out += int((known & ~(series.numbers(low) > 0)).sum())
            of += int(known.sum())
    if not out:
        return []
    text = (
        f"No band at {counted(out, 'instant')} of {thousands(of)}: there the interval reaches down to 0, which a "
        "logarithmic axis cannot show. More trials make it narrower."
    )
    return [ChartNote("interval_to_zero", text, entry.label)]


def leg_shapes(legs: Sequence[tuple[str, float, float]]) -> dict[str, Any]:
    """Shading and names of the scenario's legs, as layout properties; those of one interval share their place."""
    together: dict[tuple[float, float], list[str]] = {}
    for name, start, stop in legs:
        together.setdefault((start, stop), []).append(name)
    shapes = [
        {
            "type": "rect",
            "xref": "x",
            "yref": "paper",
            "x0": start,
            "x1": stop,
            "y0": 0,
            "y1": 1,
            "line": {"width": 0},
            "fillcolor": theme.MEASUREMENT,
            "opacity": 0.15 if i % 2 == 0 else 0.05,
            "layer": "below",
        }
        for i, (start, stop) in enumerate(together)
    ]
    words = {span: ", ".join(names) for span, names in together.items()}
    names = [
        {
            "x": (span[0] + span[1]) / 2,
            "y": 1,
            "xref": "x",
            "yref": "paper",
            "yanchor": "top",
            "yshift": -ROW_PX * row,
            "text": words[span],
            "showarrow": False,
            "font": {"size": 10, "color": theme.AXIS},
        }
        for span, row in _rows_of_names(words).items()
    ]
    return {"shapes": shapes, "annotations": names}


def _rows_of_names(words: Mapping[tuple[float, float], str]) -> dict[tuple[float, float], int]:
    """In which row each name finds room beside its neighbours; one that finds none in any row is left out."""
    if not words:
        return {}
    per_px = max(max(stop for _, stop in words) - min(start for start, _ in words), 1e-9) / USUAL_PX
    ends = [-np.inf] * MOST_ROWS
    rows: dict[tuple[float, float], int] = {}
    for span in sorted(words, key=lambda one: one[0] + one[1]):
        middle, half = (span[0] + span[1]) / 2, 0.5 * LETTER_PX * (len(words[span]) + 1) * per_px
        free = [row for row, end in enumerate(ends) if middle - half >= end]
        if free:
            rows[span] = free[0]
            ends[free[0]] = middle + half
    return rows
