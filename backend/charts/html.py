"""A chart as one page that stands alone: no network, no server; to be sent as an attachment."""

from __future__ import annotations

import html
from functools import cache
from importlib.resources import files

from backend.charts.figure import figure_json
from backend.charts.language import Language
from backend.charts.view import Figure

# Sent with the page: it may run its own script and nothing else, and has no origin.
CONTENT_SECURITY_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data: blob:"
)

_PAGE = """<!doctype html>
<html lang="{language}">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ margin: 16px; font: 14px/1.4 system-ui, sans-serif; color: #1f2328; background: #fff }}
#chart {{ height: calc(100vh - {room}px); min-height: 400px }}
p {{ margin: 4px 0; color: #57606a }}
</style>
<script>{library}</script>
</head>
<body>
<div id="chart" role="img" aria-label="{title}"></div>
{notes}
<script type="application/json" id="figure">{figure}</script>
<script>
const figure = JSON.parse(document.getElementById("figure").textContent);
Plotly.newPlot("chart", figure.data, figure.layout,
  {{displaylogo: false, showSendToCloud: false, plotlyServerURL: "", responsive: true}});
</script>
</body>
</html>
"""


def chart_page(drawn: Figure, heading: str, language: Language = "en") -> bytes:
    """Put the figure, plotly.js and the notes into one page; `heading` names the run or recording.

    The figure is in this language already (`figure_words`).
    """
    title = html.escape(f"{drawn['layout']['title']['text']}: {heading}")
    notes = drawn["layout"]["meta"]["notes"]
    lines = [f"{note['label']}: {note['text']}" if note["label"] else str(note["text"]) for note in notes]
    page = _PAGE.format(
        language=language,
        title=title,
        room=48 + 24 * (len(lines) + 1),
        library=plotly_js(),
        notes="\n".join(f"<p>{html.escape(line)}</p>" for line in lines),
        # The only text that could end the element early.
        figure=figure_json(drawn).decode().replace("<", "\\u003c"),
    )
    return page.encode()


@cache
def plotly_js() -> str:
    """The library that comes with the installed plotly package."""
    text = (files("plotly") / "package_data" / "plotly.min.js").read_text("utf-8")
    # An inline script must not contain its own end.
    return text.replace("</script", "<\\/script")
