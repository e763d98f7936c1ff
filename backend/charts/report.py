"""A run as one page that stands alone: what was run, on what, what came out and how far to trust it.

It needs no network and no server; it is sent as an attachment with the policy of a chart's page (`html`). Numbers are
written with the digits that their intervals give sense to, whole ones are in the tables of the run. What it is given is
English, the figures are in its language already; the page's texts turn the rest into that language.
"""

from __future__ import annotations

import html
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from backend.charts.figure import figure_json
from backend.charts.html import plotly_js
from backend.charts.language import Words
from backend.charts.theme import FONT, series_color
from backend.charts.view import Figure

# More rows of one table belong into a file.
ROWS_SHOWN = 200


@dataclass(frozen=True)
class ReportMetric:
    """A metric of one entry: its interval may be unknown, its value undefined."""

    metric: str
    label: str
    segment: str
    value: float | None
    ci95: tuple[float, float] | None
    unit: str
    n: int


@dataclass(frozen=True)
class ReportRequirement:
    """What was asked of an entry and what it reached; a target in no words is all of them."""

    label: str
    target: str
    segment: str
    requirement: str
    value: float | None
    threshold: float | None
    unit: str
    verdict: str
    n: int


@dataclass(frozen=True)
class ReportEntry:
    """An algorithm as it was used: settings are (name, value, where it came from), notes are (words, count)."""

    label: str
    algorithm: str
    summary: str
    settings: Sequence[tuple[str, str, str]]
    notes: Sequence[tuple[str, int]]


@dataclass(frozen=True)
class ReportContent:
    """Everything that the report tells.

    Attributes
    ----------
    facts, recording : pairs of words
    decisions : (label, decision, reason, count)
    left_out : what the report does not show, and where it is
    """

    title: str
    facts: Sequence[tuple[str, str]]
    recording: Sequence[tuple[str, str]]
    warnings: Sequence[str]
    entries: Sequence[ReportEntry]
    metrics: Sequence[ReportMetric]
    figures: Sequence[Figure]
    decisions: Sequence[tuple[str, str, str, int]]
    references: Sequence[str]
    software: Mapping[str, str] = field(default_factory=dict)
    left_out: Sequence[str] = ()
    requirements: Sequence[ReportRequirement] = ()


ENGLISH = Words()

_STYLE = (
    """
body { margin: 24px auto; max-width: 1100px; padding: 0 16px; font: 14px/1.45 FONT; color: #1f2328; background: #fff }
h1 { font-size: 24px; margin: 0 0 4px } h2 { font-size: 18px; margin: 28px 0 8px; border-bottom: 1px solid #e3e6ea }
h3 { font-size: 15px; margin: 16px 0 4px } p { margin: 4px 0 } .muted { color: #57606a }
table { border-collapse: collapse; margin: 8px 0 } .wide { overflow-x: auto }
th, td { border: 1px solid #e3e6ea; padding: 3px 8px; text-align: left; vertical-align: top }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums }
thead th { background: #f6f8fa }
.chart { height: 460px; margin: 8px 0 16px }
.swatch { display: inline-block; width: 12px; height: 12px; margin-right: 6px }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 2px 16px } dt { color: #57606a } dd { margin: 0 }
@media print { h2 { break-after: avoid } .chart, tr { break-inside: avoid } }
"""
).replace("FONT", FONT)

# A chart is drawn when it comes near the window, and all of them before the page is printed.
_SCRIPT = """
const settings = {displaylogo: false, showSendToCloud: false, plotlyServerURL: "", responsive: true};
const waiting = new Map();
for (const node of document.querySelectorAll(".chart")) waiting.set(node, document.getElementById(node.dataset.figure));
function draw(node) {
  const text = waiting.get(node);
  if (!text) return;
  waiting.delete(node);
  const figure = JSON.parse(text.textContent);
  Plotly.newPlot(node, figure.data, figure.layout, settings);
}
const near = new IntersectionObserver((seen) => { for (const one of seen) if (one.isIntersecting) draw(one.target); },
  {rootMargin: "600px"});
for (const node of waiting.keys()) near.observe(node);
addEventListener("beforeprint", () => { for (const node of [...waiting.keys()]) draw(node); });
"""


def report_page(content: ReportContent, words: Words = ENGLISH) -> bytes:
    """Put the report together as HTML."""
    colours = {entry.label: series_color(i) for i, entry in enumerate(content.entries)}
    said = words.said
    references = "".join(f"<li>{_text(r)}</li>" for r in content.references)
    parts = [
        f'<!doctype html>\n<html lang="{words.language}">\n<head>\n<meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{_text(said(content.title))}</title>\n<style>{_STYLE}</style>\n<script>{plotly_js()}</script>\n</head>\n<body>",
        f"<main>\n<h1>{_text(said(content.title))}</h1>",
        _pairs(content.facts, words),
        f"<h2>{said('Measurements')}</h2>",
        _pairs(content.recording, words),
        _list([said(text) for text in content.warnings]),
        f"<h2>{said('Results')}</h2>",
        _metrics(content.metrics, colours, words),
        _requirements(content.requirements, words),
        *(_chart(figure, i) for i, figure in enumerate(content.figures)),
        f"<h2>{said('Decisions')}</h2>",
        _decisions(content.decisions, words),
        f"<h2>{said('Algorithms and settings')}</h2>",
        *(_entry(entry, colours[entry.label], words) for entry in content.entries),
        f"<h2>{said('References')}</h2>",
        f"<ol>{references}</ol>" if references else _none(words),
        f"<h2>{said('Software')}</h2>",
        _pairs([(words.told(f"software.{name}", name), value) for name, value in content.software.items()], words),
        _list([said(text) for text in content.left_out]),
        f"</main>\n<script>{_SCRIPT}</script>\n</body>\n</html>\n",
    ]
    return "\n".join(parts).encode()


def number_text(value: float | None, interval: tuple[float, float] | None = None) -> str:
    """A number with two digits of its interval's half width, or four significant digits without one."""
    if value is None or not math.isfinite(value):
        return "\u2013"
    if interval is not None and (half := (interval[1] - interval[0]) / 2) > 0:
        digits = max(0, 1 - math.floor(math.log10(half)))
        return f"{value:.{min(digits, 9)}f}"
    return f"{value:.4g}" if 1e-4 <= abs(value) < 1e6 or value == 0 else f"{value:.3e}"


def _metrics(metrics: Sequence[ReportMetric], colours: Mapping[str, str], words: Words) -> str:
    if not metrics:
        return _none(words)
    rows = list(dict.fromkeys((m.metric, m.segment, m.unit) for m in metrics))
    found = {(m.metric, m.segment, m.unit, m.label): m for m in metrics}
    segments = any(segment for _, segment, _ in rows)
    head = ["metric", *(["segment"] if segments else []), "unit"]
    names = "".join(f'<th scope="col">{_swatch(c)}{_text(label)}</th>' for label, c in colours.items())
    lines = []
    for metric, segment, unit in rows:
        name = words.metric(metric)
        cells = [
            f'<th scope="row">{_text(name)}</th>',
            *([f"<td>{_text(words.said(segment))}</td>"] if segments else []),
        ]
        cells.append(f"<td>{_text(words.said(unit))}</td>")
        cells += [f'<td class="number">{_value(found.get((metric, segment, unit, label)))}</td>' for label in colours]
        lines.append(f"<tr>{''.join(cells)}</tr>")
    about = words.said("In brackets: 95 % confidence interval, where one is known; n: observations.")
    return f'<p class="muted">{_text(about)}</p>{_table(head, lines, words, more=names)}'


def _requirements(requirements: Sequence[ReportRequirement], words: Words) -> str:
    """What was asked, failed first; nothing where the run knows no requirements."""
    if not requirements:
        return ""
    order = {"failed": 0, "passed": 1, "no data": 2}
    rows = sorted(requirements, key=lambda r: order.get(r.verdict, 3))
    counts = {word: sum(r.verdict == word for r in rows) for word in ("failed", "passed", "no data", "not asked")}
    head = ("algorithm", "target", "segment", "requirement", "reached", "threshold", "unit", "verdict", "n")

    def in_words(code: str) -> str:
        return _text(words.told(f"requirements.{code}", code))

    lines = [
        f"<tr><td>{_text(r.label)}</td><td>{_text(r.target or words.said('all'))}</td><td>{in_words(r.segment)}</td>"
        f"<td>{_text(words.metric(r.requirement))}</td>"
        f'<td class="number">{number_text(r.value)}</td><td class="number">{number_text(r.threshold)}</td>'
        f"<td>{_text(words.said(r.unit))}</td><td>{in_words(r.verdict)}</td>"
        f'<td class="number">{r.n}</td></tr>'
        for r in rows[:ROWS_SHOWN]
    ]
    said = ", ".join(f"{count} {in_words(word)}" for word, count in counts.items() if count)
    if words.language != "en":
        said = ", ".join(f"{in_words(word)}: {count}" for word, count in counts.items() if count)
    more = f" {words.said(f'The first {ROWS_SHOWN} are shown.')}" if len(rows) > ROWS_SHOWN else ""
    heading = f"<h2>{words.said('Requirements')}</h2>"
    return f'{heading}<p class="muted">{said}.{more}</p>{_table(head, lines, words)}'


def _table(head: Sequence[str], lines: Sequence[str], words: Words, more: str = "") -> str:
    """A table that scrolls by itself; `more` are heads that are no words of ours."""
    heads = "".join(f'<th scope="col">{_text(words.said(h))}</th>' for h in head)
    return (
        f'<div class="wide"><table><thead><tr>{heads}{more}</tr></thead><tbody>{"".join(lines)}</tbody></table></div>'
    )


def _value(metric: ReportMetric | None) -> str:
    if metric is None:
        return ""
    text = number_text(metric.value, metric.ci95)
    if metric.ci95 is not None:
        text += f" [{number_text(metric.ci95[0], metric.ci95)}, {number_text(metric.ci95[1], metric.ci95)}]"
    return f'{text} <span class="muted">n {metric.n}</span>'


def _chart(figure: Figure, number: int) -> str:
    layout = figure["layout"]
    title, about = str(layout["title"]["text"]), layout["meta"]
    if "not_applicable" in about:
        return f'<h3>{_text(title)}</h3><p class="muted">{_text(about["detail"])}</p>'
    notes = [f"{n['label']}: {n['text']}" if n["label"] else str(n["text"]) for n in about["notes"]]
    # The only text that could end the element early.
    data = figure_json(figure).decode().replace("<", "\\u003c")
    return (
        f'<div class="chart" data-figure="figure{number}" role="img" aria-label="{_text(title)}"></div>'
        f'<script type="application/json" id="figure{number}">{data}</script>{_list(notes)}'
    )


def _decisions(decisions: Sequence[tuple[str, str, str, int]], words: Words) -> str:
    if not decisions:
        return f'<p class="muted">{words.said("Every mark was used as it came.")}</p>'
    rows = [
        f"<tr><td>{_text(label)}</td><td>{_decision(what, words)}</td><td>{_text(words.said(why))}</td>"
        f'<td class="number">{count}</td></tr>'
        for label, what, why, count in decisions[:ROWS_SHOWN]
    ]
    more = len(decisions) - ROWS_SHOWN
    left = words.said(f"{more} more kinds of decisions are in the table.")
    rest = f'<p class="muted">{left}</p>' if more > 0 else ""
    return f"{_table(('algorithm', 'decision', 'reason', 'times'), rows, words)}{rest}"


def _decision(code: str, words: Words) -> str:
    known = words.told(f"decision.{code}", code)
    return f"<code>{_text(code)}</code>" if known == code else _text(known)


def _entry(entry: ReportEntry, colour: str, words: Words) -> str:
    rows = [
        f'<tr><th scope="row"><code>{_text(name)}</code></th><td class="number">{_text(words.said(value))}</td>'
        f"<td>{_text(words.told(f'source.{source}', source))}</td></tr>"
        for name, value, source in entry.settings
    ]
    notes = [(words.said(text), count) for text, count in entry.notes]
    return (
        f"<h3>{_swatch(colour)}{_text(entry.label)}</h3>"
        f"<p><code>{_text(entry.algorithm)}</code> {_text(words.said(entry.summary))}</p>"
        f"{_list([f'{text} ({count})' if count > 1 else text for text, count in notes])}"
        f"{_table(('setting', 'value', 'from'), rows, words) if rows else ''}"
    )


def _swatch(colour: str) -> str:
    return f'<span class="swatch" style="background: {colour}"></span>'


def _pairs(pairs: Sequence[tuple[str, str]], words: Words) -> str:
    inner = "".join(f"<dt>{_text(words.said(name))}</dt><dd>{_text(words.listed(value))}</dd>" for name, value in pairs)
    return f"<dl>{inner}</dl>"


def _list(lines: Sequence[str]) -> str:
    return f'<ul class="muted">{"".join(f"<li>{_text(line)}</li>" for line in lines)}</ul>' if lines else ""


def _none(words: Words) -> str:
    return f'<p class="muted">{words.said("None.")}</p>'


def _text(value: Any) -> str:
    return html.escape(str(value))
