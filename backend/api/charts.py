"""Charts of runs and recordings: the same address gives the figure, its numbers, or a page that stands alone."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from io import StringIO
from typing import TYPE_CHECKING, Annotated, Any, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from algorithms.result import Table
from backend.api import uploads
from backend.api.algorithms import catalogue
from backend.api.measurements import Measurements, of_recording, of_run
from backend.api.responses import Responses, content, problems
from backend.api.services import Services, ServicesDep
from backend.api.tables import answering
from backend.api.targets import TargetName, check_target
from backend.charts.language import Language
from backend.charts.view import Chart as DeclaredChart
from backend.charts.view import ChartOptions, Entry, RecordingView, RunView, rows_of_label
from backend.db import runs as stored
from backend.errors import NotFoundError, StateError
from backend.files.table_writer import write_table_csv
from backend.http.etag import etag_of, matches, not_modified
from backend.version import program_version

if TYPE_CHECKING:
    from backend.jobs.partial_results import PartialRun

router = APIRouter(tags=["charts"])

# Charts of statistics over trials; what the algorithms declare then shows the first trial as an example.
TRIAL_CHARTS = ("trials_error", "trials_gain", "trials_consistency", "trials_lost", "trials_sweep", "trials_times")

Form = Literal["json", "csv", "html"]

# One chart is computed at a time: side by side they take as long, and the memory of all of them.
_drawing = threading.Lock()


class ChartItem(BaseModel):
    """A chart that can be drawn."""

    name: str
    title: str


class ChartList(BaseModel):
    """All charts of a run or a recording."""

    items: list[ChartItem]


class TargetQuery(BaseModel):
    """Of which target."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    target: TargetName = ""
    """Only this target; default: all of them."""


class DrawQuery(BaseModel):
    """How much to draw."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    points: Annotated[int, Field(ge=10, le=200_000)] = 2000
    """Most points of one curve; a decimated chart says so."""
    full: bool = False
    """Every point, in double precision."""


class ChartQuery(TargetQuery, DrawQuery):
    """Of which target, and how much to draw."""


class LanguageQuery(BaseModel):
    """In which language."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    language: Language = "en"
    """Language of the page; names of algorithms, stations and targets stay as they are."""


class PageQuery(ChartQuery, LanguageQuery):
    """Of which target, how much to draw, and in which language."""


_FIGURE: Responses = content("application/json", "Plotly figure with base64 typed arrays", {"type": "object"})
_ROWS: Responses = content("text/csv", "Every point of the chart, one row each")
_PAGE: Responses = content("text/html", "A page that stands alone, offline")


@router.get("/runs/{run_id}/charts", name="list_run_charts", responses=problems(404, 409))
def list_run_charts(run_id: str, services: ServicesDep) -> ChartList:
    """List the charts of a run; none as long as trials run and none of them is finished."""
    with services.database.read() as connection:
        found = stored.get_run(connection, run_id)
    try:
        run, partial = answering(services, run_id)
    except StateError:
        if found.state == "running" and "scenario" in found.source:
            return ChartList(items=[])
        raise
    return ChartList(items=[ChartItem(name=c.name, title=c.title) for c in charts_of_run(run, partial is not None)])


@router.get(
    "/runs/{run_id}/charts/{chart}.json",
    name="get_run_chart",
    response_class=Response,
    responses=_FIGURE | problems(404, 409),
)
def get_run_chart(
    run_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[ChartQuery, Query()]
) -> Response:
    """Draw a chart of a run."""
    return _of_run(services, request, run_id, chart, "json", query)


@router.get(
    "/runs/{run_id}/charts/{chart}.csv",
    name="get_run_chart_csv",
    response_class=Response,
    responses=_ROWS | problems(404, 409),
)
def get_run_chart_csv(
    run_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[TargetQuery, Query()]
) -> Response:
    """Give the numbers of a chart of a run, all of them."""
    return _of_run(services, request, run_id, chart, "csv", ChartQuery(target=query.target, full=True))


@router.get(
    "/runs/{run_id}/charts/{chart}.html",
    name="get_run_chart_page",
    response_class=Response,
    responses=_PAGE | problems(404, 409),
)
def get_run_chart_page(
    run_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[PageQuery, Query()]
) -> Response:
    """Draw a chart of a run as a page that needs no server."""
    return _of_run(services, request, run_id, chart, "html", query)


@router.get("/recordings/{recording_id}/charts", name="list_recording_charts", responses=problems(404, 409))
def list_recording_charts(recording_id: str, services: ServicesDep) -> ChartList:
    """List the charts of a recording."""
    recording = uploads.ready(services, recording_id)
    return ChartList(items=[ChartItem(name=c.name, title=c.title) for c in _recording_charts(recording.kind)])


@router.get(
    "/recordings/{recording_id}/charts/{chart}.json",
    name="get_recording_chart",
    response_class=Response,
    responses=_FIGURE | problems(404, 409),
)
def get_recording_chart(
    recording_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[ChartQuery, Query()]
) -> Response:
    """Draw a chart of a recording."""
    return _of_recording(services, request, recording_id, chart, "json", query)


@router.get(
    "/recordings/{recording_id}/charts/{chart}.csv",
    name="get_recording_chart_csv",
    response_class=Response,
    responses=_ROWS | problems(404, 409),
)
def get_recording_chart_csv(
    recording_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[TargetQuery, Query()]
) -> Response:
    """Give the numbers of a chart of a recording, all of them."""
    return _of_recording(services, request, recording_id, chart, "csv", ChartQuery(target=query.target, full=True))


@router.get(
    "/recordings/{recording_id}/charts/{chart}.html",
    name="get_recording_chart_page",
    response_class=Response,
    responses=_PAGE | problems(404, 409),
)
def get_recording_chart_page(
    recording_id: str, chart: str, request: Request, services: ServicesDep, query: Annotated[PageQuery, Query()]
) -> Response:
    """Draw a chart of a recording as a page that needs no server."""
    return _of_recording(services, request, recording_id, chart, "html", query)


def charts_of_run(run: stored.Run, trials_only: bool = False) -> list[DeclaredChart]:
    """Return the charts of a run: of its trials, then those its algorithms declare, in the order of the first.

    While trials still run there are only theirs.
    """
    return charts_of_entries(run.algorithms, run.source, trials_only)


def charts_of_entries(
    entries: Sequence[stored.Entry], source: Mapping[str, Any], trials_only: bool = False
) -> list[DeclaredChart]:
    """Return the charts of these algorithms on this source, stored or not."""
    from backend.charts.catalogue import charts

    found = charts("run")
    names = dict.fromkeys(
        name for entry in entries if (algorithm := catalogue().get(entry.name)) is not None for name in algorithm.charts
    )
    # What an algorithm declares of trials has nothing to show on a recording.
    of_trials = [name for name in names if name.startswith("trials_")]
    names = dict.fromkeys(name for name in names if name not in of_trials)
    if "scenario" in source:
        # Who names one of the common charts chooses among them; others get them all.
        chosen = of_trials if set(of_trials) & set(TRIAL_CHARTS) else (*of_trials, *TRIAL_CHARTS)
        sweep = source.get("sweep") or ()
        own = [name for name in chosen if name in found and found[name].suits(len(entries), sweep)]
        names = dict.fromkeys((*own, *(() if trials_only else names)))
    return [found[name] for name in names if name in found]


def _recording_charts(kind: str | None) -> tuple[DeclaredChart, ...]:
    from backend.charts.catalogue import charts_of_kind

    assert kind is not None
    return charts_of_kind("recording", kind)  # type: ignore[arg-type]  # the database keeps kinds as text


def _of_run(services: Services, request: Request, run_id: str, name: str, form: Form, query: ChartQuery) -> Response:
    run, partial = answering(services, run_id)
    chart = named(charts_of_run(run, partial is not None), name)
    version = (run.id, run.result_sha256 or (partial.version if partial else ""), run.label if form == "html" else "")
    file_name = f"{name}-{run_id}"
    heading = run.label or str(run.source.get("name", run_id))

    measurements = of_run(services, run, partial)
    check_target([measurements], query.target)

    def draw() -> dict[str, Any]:
        view = _run_view(services, run, measurements, partial)
        return chart.draw(selected(view, query.target), options_of(query, len(run.algorithms)))

    return drawn(request, draw, form, query, version, file_name, heading, name)


def _of_recording(
    services: Services, request: Request, recording_id: str, name: str, form: Form, query: ChartQuery
) -> Response:
    recording = uploads.ready(services, recording_id)
    chart = named(_recording_charts(recording.kind), name)
    measurements = of_recording(services, recording)
    check_target([measurements], query.target)
    file_name = f"{name}-{recording_id}"

    def draw() -> dict[str, Any]:
        from backend.charts.target import recording_view_of

        view = RecordingView(measurements.load())
        return chart.draw(recording_view_of(view, query.target) if query.target else view, options_of(query))

    version = (recording.id, recording.data_sha256 or "")
    return drawn(request, draw, form, query, version, file_name, recording.name, name)


def named(found: list[DeclaredChart] | tuple[DeclaredChart, ...], name: str) -> DeclaredChart:
    """Return the chart of this name or raise NotFoundError."""
    for chart in found:
        if chart.name == name:
            return chart
    raise NotFoundError(
        f"There is no chart {name!r} here.",
        remedy=f"There are: {', '.join(c.name for c in found)}." if found else "There is none at all.",
        code="chart_not_found",
    )


def options_of(query: DrawQuery, entries: int = 1) -> ChartOptions:
    """Return how much is to be drawn of so many entries."""
    return ChartOptions(points=query.points, full=query.full, entries=entries)


def selected(view: RunView, target: str) -> RunView:
    """Return the view with this target alone; the empty name means all targets."""
    from backend.charts.target import run_view_of

    return run_view_of(view, target) if target else view


def _run_view(services: Services, run: stored.Run, measurements: Measurements, partial: PartialRun | None) -> RunView:
    entries = (chart_entry(services, run, e, index=i, label=e.label) for i, e in enumerate(run.algorithms))
    if partial is not None:
        entries = (_partial_entry(partial, e, i) for i, e in enumerate(run.algorithms))
    legs = tuple((name, start, stop) for name, start, stop in run.source.get("legs", ()))
    return RunView(measurements.load(), tuple(entries), legs=legs, scenario=preset_of(run.source))


def preset_of(source: Mapping[str, Any]) -> str:
    """Return the preset that a run's trials are simulated from; empty for a run on recordings."""
    return str(source["scenario"]["preset"]) if "scenario" in source else ""


def _partial_entry(partial: PartialRun, declared: stored.Entry, index: int) -> Entry:
    def table(name: str) -> Table:
        found = partial.table(name)
        return Table({}) if found is None else rows_of_label(found, declared.label)

    return Entry(declared.label, index, declared.name, table, dict, declared.parameters)


def chart_entry(services: Services, run: stored.Run, declared: stored.Entry, *, index: int, label: str) -> Entry:
    """Give an entry of a run to a chart, under this label and with the colour of this place."""
    from backend.jobs.results import load_entry_arrays, load_entry_table

    def table(name: str) -> Table:
        try:
            return load_entry_table(services.database, services.store, run, declared.label, name)
        except NotFoundError:
            # An algorithm gives `errors`, for one, only where the truth is known.
            return Table({})

    return Entry(
        label=label,
        index=index,
        algorithm=declared.name,
        table=table,
        arrays=lambda: load_entry_arrays(services.store, run, declared.label),
        parameters=declared.parameters,
        key=f"{run.result_sha256}/{declared.label}" if run.result_sha256 else "",
    )


def drawn(
    request: Request,
    draw: Callable[[], dict[str, Any]],
    form: Form,
    query: ChartQuery,
    version: tuple[str, ...],
    file_name: str,
    heading: str,
    chart: str = "",
) -> Response:
    """Answer with a figure, its numbers or its page, or that the client has it already."""
    # How a chart looks may change with the program's version.
    etag = etag_of(program_version(), form, file_name, query.model_dump_json(), *version)
    if matches(request, etag):
        return not_modified(etag)
    headers = {"ETag": etag, "Cache-Control": "private, no-cache"}
    with _drawing:
        figure = draw()
    if form == "json":
        from backend.charts.figure import figure_json

        return Response(figure_json(figure), media_type="application/json", headers=headers)
    headers["Content-Disposition"] = f'attachment; filename="{file_name}.{form}"'
    if form == "csv":
        from backend.charts.table import chart_table

        out = StringIO()
        write_table_csv(chart_table(figure), out)
        return Response(out.getvalue(), media_type="text/csv; charset=utf-8", headers=headers)
    from backend.charts.figure_words import figure_in
    from backend.charts.html import CONTENT_SECURITY_POLICY, chart_page
    from backend.charts.language import words_of

    headers["Content-Security-Policy"] = CONTENT_SECURITY_POLICY
    language = query.language if isinstance(query, PageQuery) else "en"
    page = chart_page(figure_in(figure, words_of(language), chart), heading, language)
    return Response(page, media_type="text/html; charset=utf-8", headers=headers)
