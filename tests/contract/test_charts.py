"""What every registered chart must do, whatever it is given."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import plotly.graph_objects as go
import pytest

from algorithms.recording import Recording
from algorithms.result import Table
from backend.charts.catalogue import charts, charts_of_kind
from backend.charts.figure import figure_json
from backend.charts.html import chart_page, plotly_js
from backend.charts.table import chart_table
from backend.charts.view import Chart, ChartOptions, Entry, RecordingView, RunView
from tests import chart_views, pair_views, track_views

ROLES = {"series", "truth", "station", "measurement", "bound", "interval", "rejected"}
# Quantities without a unit; everything else says its unit after the last comma.
UNITLESS = (
    "Counter",
    "Number of",
    "NIS", "Station", "Gain", "Chi2", "Calibration error", "Plot of", "Algorithm", "Probability",
    "Mean probability", "Share", "Target", "Normal acceleration", "Squared", "sigma", "scenario", "NEES",
    "Nonlinearity", "Ratio", "Stage",
)  # fmt: skip
LONG_LABEL = "rdfv " + "x" * 115


def _all_nan(recording: Recording) -> RunView:
    table = chart_views.states(recording)
    nan = {n: np.full(len(table), np.nan) for n in table.names if isinstance(table.columns[n], np.ndarray)}
    return chart_views.run(recording, {"states": Table(dict(table.columns) | nan)})


RECORDINGS: dict[str, Callable[[], Recording]] = {
    "six marks": chart_views.marks,
    "one mark": lambda: chart_views.marks(1),
    "no marks": lambda: chart_views.marks(0),
    "no truth": lambda: chart_views.marks(truth=False),
    "no altitude": lambda: chart_views.marks(altitude=False, truth=False),
    "no site": lambda: chart_views.marks(site=None),
    "thirty targets": lambda: chart_views.marks(600, targets=30),
    "started": lambda: chart_views.marks(start_utc="2023-04-05T10:00:00Z"),
    "plots": chart_views.plots,
    "no plots": lambda: chart_views.plots(0),
    "plots of two radars": chart_views.two_radars,
    "antenna plots": chart_views.antenna,
    "Doppler pairs": chart_views.doppler,
    "no Doppler": lambda: chart_views.doppler(0),
    "Doppler without site": lambda: chart_views.doppler(site=False),
}

VIEWS: dict[str, Callable[[Recording], RunView]] = {
    "complete": lambda r: chart_views.run(
        r,
        *[
            {
                "states": chart_views.states(r, **track_views.motion(len(r))),
                "decisions": track_views.track_decisions(r),
                "set_distances": track_views.set_distances(r),
                "errors": chart_views.errors(r),
                "receivers": chart_views.receivers(),
                "receiver_delays": chart_views.receiver_delays(),
                **chart_views.trial_tables(scale),
                **chart_views.scatter_tables(r),
                **chart_views.model_tables(r),
                **pair_views.pair_tables(r),
            }
            for scale in (2.0, 1.0, 1.0)
        ],
        algorithms=("rdf", "mma2_122", "kalman_1_5"),
    ),
    "long label": lambda r: chart_views.run(r, {"states": chart_views.states(r)}, labels=(LONG_LABEL,)),
    "all NaN": _all_nan,
    "no tables": lambda r: chart_views.run(r, {}),
    "no entries": lambda r: RunView(r, ()),
    "unused": lambda r: chart_views.run(
        r,
        {
            "states": chart_views.states(
                r, used=[None] * len(r), status=["residual_gate"] * len(r), dof=np.arange(len(r)) % 4.0
            )
        },
    ),
}


OPTIONS = (ChartOptions(), ChartOptions(points=50), ChartOptions(full=True))


# What is drawn is made once for all charts: to make it takes longer than to draw one.
@pytest.mark.parametrize("how", VIEWS)
@pytest.mark.parametrize("what", RECORDINGS)
def test_every_chart_of_a_run_holds_the_contract(what: str, how: str) -> None:
    view = VIEWS[how](RECORDINGS[what]())
    drawn = [name for name, chart in charts("run").items() if chart.takes(view.recording.kind)]
    assert drawn
    for name in drawn:
        for options in OPTIONS:
            with told(f"chart {name}, {options}"):
                _holds_the_contract(charts("run")[name], view, options)


@pytest.mark.parametrize("what", RECORDINGS)
def test_every_chart_of_a_recording_holds_the_contract(what: str) -> None:
    view = RecordingView(RECORDINGS[what]())
    drawn = [name for name, chart in charts("recording").items() if chart.takes(view.recording.kind)]
    assert drawn
    for name in drawn:
        for options in OPTIONS:
            with told(f"chart {name}, {options}"):
                _holds_the_contract(charts("recording")[name], view, options)


@contextmanager
def told(where: str) -> Iterator[None]:
    """Say at which of many things a test failed."""
    try:
        yield
    except Exception as error:
        error.add_note(f"at {where}")
        raise


def _holds_the_contract(chart: Chart, view: Any, options: ChartOptions) -> None:
    drawn = chart.draw(view, options)
    layout = drawn["layout"]
    assert layout["template"] == "none"
    assert layout["title"]["text"]
    assert isinstance(layout["meta"]["notes"], list)
    for note in layout["meta"]["notes"]:
        assert set(note) == {"code", "text", "label"}
        assert re.fullmatch(r"[a-z_0-9]+", note["code"])
        assert note["text"].endswith((".", ")."))
    if "not_applicable" in layout["meta"]:
        assert drawn["data"] == []
        assert layout["meta"]["detail"]
        return
    assert drawn["data"]
    for trace in drawn["data"]:
        assert trace["meta"]["role"] in ROLES
        assert set(trace["meta"]) - {"pieces"} == {"role", "label", "index"}
        assert (trace["meta"]["label"] is None) == (trace["meta"]["index"] is None)
        assert trace["name"]
        for key in ("x", "y", "customdata", "text", "hovertext"):
            if trace["type"] != "heatmap" and key in trace:
                assert len(trace[key]) == len(trace["x"])
        for key in ("x", "y"):
            values = np.asarray(trace[key])
            if values.dtype.kind == "f":
                assert not np.isinf(values).any()
                assert np.isfinite(values).any() or trace["meta"]["role"] in ("series", "measurement")
    for name, axis in layout.items():
        if re.fullmatch(r"[xy]axis\d*", name):
            title = axis["title"]["text"]
            assert title.startswith(UNITLESS) or re.search(r", (s|m|km|%|deg|deg/s|m/s|m/s²|Hz|Hz/s|µs)$", title), title


@pytest.mark.parametrize(("source", "name"), [(s, n) for s in ("run", "recording") for n in charts(s)])
@pytest.mark.parametrize("what", ["six marks", "thirty targets", "plots", "Doppler pairs", "no marks"])
def test_plotly_accepts_the_figure_as_it_is_sent(source: Any, name: str, what: str) -> None:
    recording = RECORDINGS[what]()
    view = RecordingView(recording) if source == "recording" else VIEWS["complete"](recording)
    sent = json.loads(figure_json(charts(source)[name].draw(view, ChartOptions())))
    go.Figure(sent)  # raises for an unknown property or a value out of its range
    for trace in sent["data"]:
        for key in ("x", "y", "z", "customdata"):
            assert not (isinstance(trace.get(key), list) and trace[key] and isinstance(trace[key][0], float))


@pytest.mark.parametrize(("source", "name"), [(s, n) for s in ("run", "recording") for n in charts(s)])
def test_a_chart_has_a_table_and_a_page(source: Any, name: str) -> None:
    own = {("doppler_pairs",): chart_views.doppler, ("polar_plots",): chart_views.two_radars,
           ("antenna_plots",): chart_views.antenna}  # fmt: skip
    recording = own.get(charts(source)[name].kinds, chart_views.marks)()
    view = RecordingView(recording) if source == "recording" else VIEWS["complete"](recording)
    drawn = charts(source)[name].draw(view, ChartOptions(full=True))
    table = chart_table(drawn)
    assert len(table) > 0
    assert {"label", "trace", "role", "x", "y", "row"} <= set(table.names)
    assert len({len(column) for column in table.columns.values()}) == 1
    list(table.rows())
    page = chart_page(drawn, "a <run> & its name").decode()
    assert "a &lt;run&gt; &amp; its name" in page
    own = page.replace(plotly_js(), "")
    assert "src=" not in own
    assert "http" not in own.replace("http-equiv", "")


@pytest.mark.parametrize("source", ["run", "recording"])
def test_every_chart_is_documented(source: Any, request: pytest.FixtureRequest) -> None:
    text = (request.config.rootpath / "docs" / "charts.md").read_text(encoding="utf-8")
    for name in charts(source):
        assert f"### `{name}` of a {source}" in text


def test_reason_codes_are_documented(request: pytest.FixtureRequest) -> None:
    text = (request.config.rootpath / "docs" / "charts.md").read_text(encoding="utf-8")
    folder = request.config.rootpath / "backend" / "charts"
    sources = "".join(path.read_text(encoding="utf-8") for path in folder.rglob("*.py"))
    codes = set(re.findall(r'ChartNote\(\s*"([a-z_0-9]+)"', sources))
    codes |= set(re.findall(r'not_applicable\([A-Z]+, "([a-z_]+)"', sources))
    codes |= set(re.findall(r'not_applicable\(title, "([a-z_]+)"', sources))
    assert codes
    assert not {code for code in codes if f"`{code}`" not in text}


def test_algorithms_name_charts_that_exist() -> None:
    from algorithms.registry import algorithms_by_name

    for algorithm in algorithms_by_name().values():
        assert not set(algorithm.charts) - set(charts("run")), algorithm.name


def test_a_kind_gets_the_charts_that_speak_of_it() -> None:
    assert {c.name for c in charts_of_kind("recording", "toa_marks")} == {"plan", "receptions", "measurements"}
    assert {c.name for c in charts_of_kind("recording", "polar_plots")} == {"plan", "measurements"}


def test_an_entry_is_read_only_when_it_is_drawn() -> None:
    asked: list[str] = []

    def table(name: str) -> Table:
        asked.append(name)
        return Table({})

    view = RunView(chart_views.marks(), (Entry("a", 0, "rdf", table, dict),))
    for chart in charts("run").values():
        asked.clear()
        chart.draw(view, ChartOptions())
        assert set(asked) <= set(chart.needs)
