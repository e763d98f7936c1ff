"""The parts a figure is made of, and its JSON.

A figure is the plain dictionary that plotly.js takes; arrays of numbers stay NumPy arrays until `figure_json` writes
them as base64 typed arrays. Figures are built without plotly's classes: those check every property of every trace,
which costs more than drawing; the contract test does that once for every chart instead.

Conventions the page relies on:

* every trace has `meta` = `{"role", "label", "index"}`; `label` and `index` are null where no entry is meant;
* a line of several tracks or targets may name its unbroken pieces in `meta.pieces`: a target, or a track's number;
* points that stand for marks carry the recording's row number in `customdata` (-1 = none), and, where x is not
  time, the time in seconds in `text`;
* `layout.meta` holds `notes` (what the reader must know: `code`, `text`, `label`), `decimated` (`shown`, `of`),
  `not_applicable` (a code, with `detail` in words; the figure then has no traces), `start_utc` and `legend` (true
  where the curves need names).
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Recording
from backend.charts import theme
from backend.charts.columns import Ints
from backend.charts.decimate import GAP, Picked
from backend.charts.view import Entry, Figure

Role = Literal["series", "truth", "station", "measurement", "bound", "interval", "rejected"]
Trace = dict[str, Any]

# More points than this in one chart are drawn by WebGL: SVG markers take 0.6 s per 10,000.
SVG_POINTS = 5000
SUMMARY_POINTS = 500
# Words in the hover (target, track, reason) for at most so many points of a trace; texts are heavy.
HOVER_WORDS = 5000
DECADES_WITH_DIGITS = 3.5
# A line of more tracks or targets than the first is drawn faint; of more pieces than the second none is named.
MANY_PIECES, MOST_PIECES = 40, 5000
FAINT = 0.5

REASONS = {
    "no_altitude": "No altitude was decoded, estimated or known.",
    "no_marks": "The recording holds no marks.",
    "no_states": "No algorithm of this run gave an estimate.",
    "no_covariance": "No algorithm of this run states how large its error may be.",
    "no_truth": "The recording holds no true positions.",
    "no_height": "No algorithm of this run keeps tracks with a height, and none is known.",
    "no_curvature": "Altitude and height in the local frame differ by less than a metre here.",
    "no_residuals": "No algorithm of this run gave residuals of receivers.",
    "no_bias": "No algorithm of this run estimates the altitude's bias.",
    "no_delays": "No receiver has enough marks with more data than unknowns.",
    "no_memory": "No tracker of this run keeps a memory of plots.",
    "no_times": "Times of computation are told when the run has ended.",
    "no_curves": "No statistics over trials at each instant: the run has none, or none is finished yet.",
    "nothing_lost": "No track is lost: every instant after the start has an estimate in every trial.",
    "no_sweep": "This run varies no number.",
    "no_reference": "The first algorithm is swept itself: no single one of its values is what the others gain over.",
    "nothing_to_compare": "One algorithm alone: there is nothing to compare it with.",
    "no_models": "No algorithm of this run has several motion models.",
    "no_operations": "No algorithm of this run has its operations counted, or no stage has an error.",
    "no_nis": "No algorithm of this run gave an innovation with its covariance.",
    "no_position": "Nothing in this recording has a place in the plane: it needs a site or true positions.",
    "no_base_line": "This recording has no site with transmitters and receivers.",
    "no_dopplers": "No algorithm of this run gave residuals of Dopplers.",
    "no_crossings": "No algorithm of this run gave a crossing of the base line.",
    "no_angular_velocity": "No algorithm of this run works with an angular velocity.",
    "no_sensitivities": "No pass has an answer for which calibration errors could be computed.",
    "no_base_bounds": "No pass has an answer from which the bound along the base line could be computed.",
    "no_single_trials": "The run keeps no paths of single trials, or none is finished yet.",
    "no_decisions": "No algorithm of this run decides which plots belong together.",
    "too_many_bars": "This run has more combinations of swept values than bars can show.",
    "no_single_values": "This run keeps no single values of pairs, or none is finished yet.",
    "no_probabilities": "No algorithm of this run states probabilities of pairs.",
    "no_pairs": "No algorithm of this run accepted a pair.",
    "no_second_sweep": "The map needs a run that varies two numbers.",
    "nothing_observable": "Nowhere on this map can the stations tell a position: add a station or an altitude.",
    "no_velocity": "No algorithm of this run estimates a velocity.",
    "no_acceleration": "No algorithm of this run estimates an acceleration.",
    "other_kind": "This chart is for recordings of another kind.",
}


# Words that go with points: a name written before each value (may be empty), and the values, or how to read them.
HoverWords = Sequence[tuple[str, NDArray[Any] | Callable[[Ints], NDArray[Any]]]]


@dataclass(frozen=True)
class ChartNote:
    """Something that the reader of a chart must know; `label` names the entry it is about."""

    code: str
    text: str
    label: str | None = None

    def to_json(self) -> dict[str, str | None]:
        """As the page gets it."""
        return {"code": self.code, "text": self.text, "label": self.label}


def trace(role: Role, x: Any, y: Any, *, entry: Entry | None = None, **properties: Any) -> Trace:
    """One scatter trace with its role; entries group their traces so that one chip hides them all."""
    out: Trace = {"type": "scatter", "x": x, "y": y, "meta": meta(role, entry)}
    if entry is not None:
        out["legendgroup"] = entry.label
    if out["meta"]["role"] == "bound":
        out["hoverinfo"] = "skip"
    return out | properties


def meta(role: Role, entry: Entry | None = None) -> dict[str, Any]:
    """The trace's `meta`."""
    return {
        "role": role,
        "label": None if entry is None else entry.label,
        "index": None if entry is None else entry.index,
    }


def line_of(entry: Entry, width: float = 1.5) -> dict[str, Any]:
    """Line of an entry's curve."""
    return {"color": theme.series_color(entry.index), "dash": theme.series_dash(entry.index), "width": width}


def marker_of(entry: Entry, size: float = 4, opacity: float = 1.0) -> dict[str, Any]:
    """Filled marker of an entry."""
    return {
        "color": theme.series_color(entry.index),
        "symbol": theme.series_symbol(entry.index),
        "size": size,
        "opacity": opacity,
    }


def hollow_marker_of(entry: Entry, size: float = 7) -> dict[str, Any]:
    """Hollow marker for a mark that the entry did not use."""
    color = theme.series_color(entry.index)
    symbol = f"{theme.series_symbol(entry.index)}-open"
    return {"color": color, "symbol": symbol, "size": size, "line": {"color": color, "width": 1.2}}


def hover(points: Picked, title: str, values: str, words: HoverWords = ()) -> dict[str, Any]:
    """Hover properties of a trace: title, words of each point where they are few enough, `values` as a template."""
    out: dict[str, Any] = {"hovertemplate": f"<b>{title}</b><br>{values}<extra></extra>"}
    if points.positions.size > HOVER_WORDS:
        return out
    read = [(name, _words_of(points, column)) for name, column in words]
    used = [(name, column) for name, column in read if any(column)]
    if used:
        names = [name for name, _ in used]
        out["hovertext"] = [
            ", ".join(f"{name} {value}".strip() for name, value in zip(names, row, strict=True) if value)
            for row in zip(*(column for _, column in used), strict=True)
        ]
        out["hovertemplate"] = f"<b>{title}</b><br>%{{hovertext}}<br>{values}<extra></extra>"
    return out


def _words_of(points: Picked, column: NDArray[Any] | Callable[[Ints], NDArray[Any]]) -> NDArray[Any]:
    if not callable(column):
        return points.take(column)
    out = np.full(points.positions.size, "", object)
    there = points.positions != GAP
    out[there] = column(points.positions[there])
    return out


def axis(title: str, **properties: Any) -> dict[str, Any]:
    """An axis with its quantity and unit as title."""
    return {
        "title": {"text": title, "standoff": 8},
        "automargin": True,
        "gridcolor": theme.GRID,
        "linecolor": theme.AXIS,
        "zeroline": False,
        "showline": True,
        "ticks": "outside",
        "tickcolor": theme.AXIS,
        "ticklen": 4,
        "exponentformat": "none",
        "separatethousands": True,
    } | properties


def time_axis(recording: Recording, **properties: Any) -> dict[str, Any]:
    """The time axis: seconds from the start of the recording, which is named where it is known."""
    start = recording.start_utc
    return axis("Time, s" if start is None else f"Time from {start.replace('T', ' ')}, s", **properties)


def log_axis(title: str, traces: Sequence[Trace], **properties: Any) -> dict[str, Any]:
    """A logarithmic axis for what these traces hold: with 2 and 5 between the decades where they are few.

    Within one decade every tick has its whole number (Plotly's own choice): a 5 alone does not say of what.
    """
    values = np.concatenate([np.asarray(t["y"], np.float64) for t in traces] or [np.empty(0)])
    values = values[values > 0]
    decades = float(np.log10(values.max() / values.min())) if values.size else 0.0
    if values.size and decades < 1:
        return axis(title, type="log", **properties)
    return axis(title, type="log", dtick="D2" if decades <= DECADES_WITH_DIGITS else 1, **properties)


def name_pieces(line: Trace, names: Sequence[str | int]) -> None:
    """Name the unbroken pieces of a line: targets, or numbers of tracks (-1 = none).

    Many of them side by side are thin and faint, so that one that is looked at stands out.
    """
    if 1 < len(names) <= MOST_PIECES:
        line["meta"]["pieces"] = list(names)
    if len(set(names)) > MANY_PIECES:
        line["line"] = line["line"] | {"width": min(line["line"]["width"], 1)}
        line["opacity"] = FAINT


def crowd_opacity(count: int, most: float = 0.45) -> float:
    """Opacity of single marks: the more there are, the fainter, so that a crowd shows its density."""
    return float(np.clip(most * np.sqrt(1500 / max(count, 1)), 0.1, most))


def drawn_by_webgl(traces: Iterable[Trace]) -> None:
    """Give the markers of a crowded chart to WebGL. Lines alone and filled outlines stay SVG."""
    with_markers = [t for t in traces if t["type"] == "scatter" and "markers" in t.get("mode", "")]
    if sum(len(t["x"]) for t in with_markers) > SVG_POINTS:
        for t in with_markers:
            # Summaries and stations stay SVG, which lies over the canvas.
            if len(t["x"]) > SUMMARY_POINTS:
                t["type"] = "scattergl"


def outside_view(count: int, of: int, noun: str) -> ChartNote:
    """Say how many points the first view leaves out."""
    text = f"Outside the first view: {thousands(count)} of {counted(of, noun)}; a double click shows them."
    return ChartNote("outside_view", text)


def figure(
    title: str,
    traces: list[Trace],
    *,
    recording: Recording | None,
    picked: Sequence[Picked] = (),
    notes: Sequence[ChartNote] = (),
    legend: bool = False,
    **layout: Any,
) -> Figure:
    """Put a chart together: traces, axes (`xaxis=...`, `yaxis=...`) and what must be said about them.

    The page has a legend of its own for the entries; `legend` asks it for one of the curves too, where a chart has
    curves that belong to no entry.
    """
    about: dict[str, Any] = {"notes": [note.to_json() for note in notes]}
    if legend:
        about["legend"] = True
    if recording is not None and recording.start_utc is not None:
        about["start_utc"] = recording.start_utc
    heading: dict[str, Any] = {"text": title, "x": 0, "xref": "paper", "xanchor": "left", "font": {"size": 15}}
    shown, of = (sum(getattr(p, field) for p in picked) for field in ("shown", "of"))
    if shown < of:
        about["decimated"] = {"shown": shown, "of": of}
        heading["subtitle"] = {"text": f"{thousands(shown)} of {thousands(of)} points drawn"}
    drawn_by_webgl(traces)
    return {"data": traces, "layout": _layout(heading, about) | layout}


def not_applicable(title: str, code: str) -> Figure:
    """A figure without traces that says why there is nothing to see."""
    detail = REASONS[code]
    about = {"notes": [], "not_applicable": code, "detail": detail}
    words = {"text": detail, "showarrow": False, "xref": "paper", "yref": "paper", "x": 0.5, "y": 0.5}
    heading = {"text": title, "x": 0, "xref": "paper", "xanchor": "left", "font": {"size": 15}}
    hidden = {"visible": False}
    return {
        "data": [],
        "layout": _layout(heading, about) | {"annotations": [words], "xaxis": hidden, "yaxis": hidden},
    }


def _layout(heading: dict[str, Any], about: dict[str, Any]) -> dict[str, Any]:
    return {
        "template": "none",
        "title": heading,
        "meta": about,
        "font": {"family": theme.FONT, "size": 12, "color": theme.TEXT},
        "paper_bgcolor": theme.SURFACE,
        "plot_bgcolor": theme.SURFACE,
        "margin": {"l": 56, "r": 16, "t": 56, "b": 44},
        "hovermode": "closest",
        "separators": ".\u2009",
        "legend": {"orientation": "h", "x": 0, "y": 0, "yref": "container", "yanchor": "bottom"},
        "uirevision": "keep",
    }


def counted(count: int, noun: str) -> str:
    """A count with its noun: 1 mark, 1 200 marks."""
    return f"{thousands(count)} {noun}" + ("" if count == 1 else "s")


def thousands(count: int) -> str:
    """A count with thin spaces between thousands."""
    return f"{count:,}".replace(",", "\u2009")


def figure_json(drawn: Figure) -> bytes:
    """The figure as JSON; numeric arrays as base64 typed arrays in little-endian order."""
    return json.dumps(drawn, default=_encoded, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def _encoded(value: Any) -> Any:
    """Encode what `json` does not know: NumPy arrays and scalars."""
    if isinstance(value, np.generic):
        return value.item()
    if not isinstance(value, np.ndarray):
        raise TypeError(f"{type(value).__name__} has no place in a figure")
    if value.dtype.kind not in "fiu":
        return value.tolist()
    if value.dtype.itemsize == 8 and value.dtype.kind in "iu":
        # plotly.js has no 64-bit integers.
        value = _narrow(value)
    value = value.astype(value.dtype.newbyteorder("<"), copy=False)
    out = {"dtype": value.dtype.str[1:], "bdata": base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()}
    if value.ndim > 1:
        out["shape"] = ", ".join(str(n) for n in value.shape)
    return out


def _narrow(value: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    if value.size == 0 or (value.min() >= -(2**31) and value.max() < 2**31):
        return value.astype(np.int32)
    return value.astype(np.float64)
