"""A figure in another language: for pages that stand alone. What is shown in the page is put into words there.

Names of entries, stations and targets stay as they are. The rules are those of `frontend/js/figure.js`.
"""

from __future__ import annotations

import re
from typing import Any

from backend.charts.figure import Trace
from backend.charts.language import Words
from backend.charts.view import Figure

_AXIS = re.compile(r"[xyz]axis\d*")
# Commas and blanks around words.
_BETWEEN = re.compile(r"(\s*[,:]\s*|^\s+|\s+$)")
# What is filled in by Plotly, and the tags that it knows.
_FIXED = re.compile(r"(%\{[^}]*\}|<[^>]*>)")


def figure_in(figure: Figure, words: Words, chart: str) -> Figure:
    """Return a copy of the figure of this chart with its words in this language."""
    if words.language == "en":
        return figure
    layout = dict(figure["layout"])
    about = layout["meta"]
    layout["title"] = _titled(layout["title"], words, chart)
    notes = [note | {"text": words.told(f"chart.note.{note['code']}", note["text"])} for note in about["notes"]]
    layout["meta"] = about | {"notes": notes}
    if "not_applicable" in about:
        layout["meta"]["detail"] = words.told(f"chart.reason.{about['not_applicable']}", about["detail"])
    for name, axis in layout.items():
        if _AXIS.fullmatch(name) and "title" in axis:
            layout[name] = axis | {"title": axis["title"] | {"text": axis_title(axis["title"]["text"], words)}}
    if "annotations" in layout:
        layout["annotations"] = [
            note | {"text": words.listed(note["text"])} if note.get("text") else note for note in layout["annotations"]
        ]
    return {"data": [_trace(trace, words) for trace in figure["data"]], "layout": layout}


def axis_title(title: str, words: Words) -> str:
    """Return an axis title: known as a whole, or as the name of a quantity with its unit."""
    whole = words.said(title)
    quantity, comma, unit = title.rpartition(",")
    return f"{words.said(quantity.strip())}, {words.said(unit.strip())}" if whole == title and comma else whole


def _titled(title: dict[str, Any], words: Words, chart: str) -> dict[str, Any]:
    out = title | {"text": words.told(f"chart.{chart}", title["text"])}
    if "subtitle" in title:
        out["subtitle"] = title["subtitle"] | {"text": words.said(title["subtitle"]["text"])}
    return out


def _trace(trace: Trace, words: Words) -> Trace:
    out = dict(trace)
    label = trace["meta"]["label"]
    if trace.get("name"):
        out["name"] = _name(trace["name"], label, words)
    if "text" in trace.get("colorbar", {}).get("title", {}):
        title = trace["colorbar"]["title"]
        out["colorbar"] = trace["colorbar"] | {"title": title | {"text": words.said(title["text"])}}
    for axis in ("x", "y"):
        column = trace.get(axis)
        if isinstance(column, list) and column and isinstance(column[0], str):
            out[axis] = [_row(name, label, words) for name in column]
    if "hovertemplate" in trace:
        out["hovertemplate"] = _hover(trace["hovertemplate"], label, words)
    if isinstance(trace.get("hovertext"), list):
        out["hovertext"] = [_beside(text, words) for text in trace["hovertext"]]
    return out


def _name(name: str, label: str | None, words: Words) -> str:
    if not label or not name.startswith(f"{label}, "):
        return name if name == label else words.said(name)
    rest = name[len(label) + 2 :]
    # A single letter is a symbol: h is the altitude here and not an hour.
    if len(rest) == 1:
        return name
    whole = words.said(rest)
    # Between the label and the words may stand swept values.
    before, _, last = name.rpartition(", ")
    return f"{before}, {words.said(last)}" if whole == rest else f"{label}, {whole}"


def _row(name: str, label: str | None, words: Words) -> str:
    """Rows of names may begin with the entry's label, which stays."""
    if label and name.startswith(f"{label}, "):
        return f"{label}, {words.listed(name[len(label) + 2 :])}"
    return name if name == label else words.listed(name)


def _beside(text: str, words: Words) -> str:
    """Words that go with a point: one by one where a decision's code is among them, else as a whole where known."""
    parts = text.split(", ")
    whole = text if any(f"decision.{part}" in words.keys for part in parts) else words.said(text)
    return ", ".join(_part(part, words) for part in parts) if whole == text else whole


def _part(part: str, words: Words) -> str:
    """A code of a decision, a value with its name before it ("target A"), or words alone."""
    whole = words.told(f"decision.{part}", part)
    name, space, value = part.partition(" ")
    return f"{words.said(name)} {value}" if whole == part and space else whole


def _hover(template: str, label: str | None, words: Words) -> str:
    """The words between what Plotly fills in."""
    return "".join(
        piece if _FIXED.fullmatch(piece) else _between(piece, label, words) for piece in _FIXED.split(template)
    )


def _between(text: str, label: str | None, words: Words) -> str:
    if not text.strip() or text == label:
        return text
    if label and text.startswith(f"{label}, "):
        return _name(text, label, words)
    return "".join(part if not part.strip(" ,:") else words.said(part) for part in _BETWEEN.split(text))
