"""Several runs side by side: what they were given and what came of it as tables, their charts overlaid."""

from __future__ import annotations

import datetime as dt
from collections.abc import Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from backend.api import charts as single
from backend.api import compare_tables as tables
from backend.api.charts import ChartQuery, DrawQuery, TargetQuery
from backend.api.measurements import Measurements, of_run
from backend.api.responses import Responses, content, problems
from backend.api.run_schemas import Id, SettingOut
from backend.api.services import Services, ServicesDep
from backend.api.targets import check_target
from backend.charts.view import Chart, Figure, RunView
from backend.db import runs as stored
from backend.errors import NotFoundError
from backend.http.problems import ProblemError, ProblemItem

router = APIRouter(prefix="/compare", tags=["compare"])

FEWEST_RUNS, MOST_RUNS = 2, 10

_FIGURE: Responses = content("application/json", "Plotly figure with base64 typed arrays", {"type": "object"})
_ROWS: Responses = content("text/csv", "Every point of the chart, one row each")


class RunsQuery(BaseModel):
    """Which runs."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    run: Annotated[list[Id], Field(min_length=FEWEST_RUNS, max_length=MOST_RUNS)]
    """Runs that succeeded; repeated. Their order is that of the columns and colours."""


class TablesQuery(RunsQuery):
    """Which runs, and which part of them."""

    target: Annotated[str, Field(max_length=200)] = ""
    """Metrics of this target; default: of all together."""
    segment: Annotated[str, Field(max_length=200)] = ""
    """Metrics of this segment; default: of all together."""


class OverlaidQuery(RunsQuery, TargetQuery):
    """Which runs, and of which target."""


class OverlayQuery(OverlaidQuery, DrawQuery):
    """Which runs, of which target, and how much to draw."""


class _Out(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class ComparedRun(_Out):
    """One of the runs."""

    id: str
    title: str
    """Its label or its recording's name, with digits of its id where another run is called the same."""
    label: str
    tags: list[str]
    created_at: dt.datetime
    recording_id: str | None
    """Null where the measurements were simulated."""
    recording_name: str


class ComparedEntry(_Out):
    """One algorithm of one of the runs: a column of the tables, a colour of the charts."""

    index: int
    label: str
    """`run / entry`, unique among all; the charts use it."""
    run_id: str
    entry: str
    """Its label in its own run."""
    algorithm: str
    seconds: float | None


class ComparedFact(_Out):
    """A value for each entry, null where it has none."""

    name: str
    values: list[Any]
    differs: bool


class ComparedParameter(_Out):
    """A parameter as it was used by each entry; null where its algorithm has no such parameter."""

    name: str
    values: list[SettingOut | None]
    differs: bool
    """Whether entries that have the parameter used different values."""


class ComparedValue(_Out):
    """A metric of one entry."""

    value: float | None
    ci95: tuple[float, float] | None
    n: int | None


class ComparedMetric(_Out):
    """A metric of all entries."""

    metric: str
    unit: str
    values: list[ComparedValue | None]
    differs: bool
    best: list[int]
    """Indices of the best value; empty where neither direction is better, all are the same, or recordings differ."""


class ComparedChart(_Out):
    """A chart of the runs."""

    name: str
    title: str
    obstacle: str | None
    """Why these runs cannot be drawn into one such chart; null where they can."""


class Comparison(_Out):
    """Runs side by side."""

    runs: list[ComparedRun]
    entries: list[ComparedEntry]
    same_recording: bool
    """Whether all runs worked on the same measurements, site and truth; without that nothing is called best."""
    given: list[ComparedFact]
    """recording, algorithm, seed, trials."""
    parameters: list[ComparedParameter]
    software: list[ComparedFact]
    targets: list[str]
    """What `target` may be."""
    segments: list[str]
    """What `segment` may be."""
    metrics: list[ComparedMetric]
    charts: list[ComparedChart]


@router.get("", name="compare_runs", responses=problems(404, 409))
def compare_runs(services: ServicesDep, query: Annotated[TablesQuery, Query()]) -> Comparison:
    """Put the parameters and metrics of two to ten runs side by side."""
    from backend.jobs.results import load_table

    runs, recordings = _found(services, query.run)
    entries = tables.compared_entries(runs)
    same = tables.same_recording(recordings)
    found = {run.id: load_table(services.database, services.store, run, "metrics") for run in runs}
    rows = tables.metrics(entries, found, target=query.target, segment=query.segment, comparable=same)
    return Comparison.model_validate(
        {
            "runs": [
                {
                    "id": run.id,
                    "title": title,
                    "label": run.label,
                    "tags": list(run.tags),
                    "created_at": run.created_at,
                    "recording_id": recording.recording_id,
                    "recording_name": recording.name,
                }
                for run, title, recording in zip(runs, tables.titles_of(runs), recordings, strict=True)
            ],
            "entries": [
                {
                    "index": one.index,
                    "label": one.label,
                    "run_id": one.run.id,
                    "entry": one.entry.label,
                    "algorithm": one.entry.name,
                    "seconds": next(
                        (e["seconds"] for e in one.run.entries or () if e["label"] == one.entry.label), None
                    ),
                }
                for one in entries
            ],
            "same_recording": same,
            "given": tables.given(entries, recordings),
            "parameters": tables.parameters(entries),
            "software": tables.software(entries),
            "targets": _names(found, "target"),
            "segments": _names(found, "segment"),
            "metrics": rows,
            "charts": [
                {"name": c.name, "title": c.title, "obstacle": tables.obstacle(c.overlay, recordings)}
                for c in _charts(runs)
            ],
        },
        from_attributes=True,
    )


@router.get(
    "/charts/{chart}.json",
    name="compare_chart",
    response_class=Response,
    responses=_FIGURE | problems(404, 409),
)
def compare_chart(
    chart: str, request: Request, services: ServicesDep, query: Annotated[OverlayQuery, Query()]
) -> Response:
    """Draw the entries of two to ten runs into one chart."""
    drawn = ChartQuery(target=query.target, points=query.points, full=query.full)
    return _overlaid(services, request, chart, query.run, "json", drawn)


@router.get(
    "/charts/{chart}.csv",
    name="compare_chart_csv",
    response_class=Response,
    responses=_ROWS | problems(404, 409),
)
def compare_chart_csv(
    chart: str, request: Request, services: ServicesDep, query: Annotated[OverlaidQuery, Query()]
) -> Response:
    """Give the numbers of a chart of two to ten runs, all of them."""
    return _overlaid(services, request, chart, query.run, "csv", ChartQuery(target=query.target, full=True))


def _found(services: Services, ids: Sequence[str]) -> tuple[list[stored.Run], list[Measurements]]:
    """Return the runs and what each worked on; say of all of them at once why they cannot be compared."""
    runs: list[stored.Run] = []
    wrong: list[tuple[int, ProblemItem]] = []
    with services.database.read() as connection:
        for i, run_id in enumerate(ids):
            pointer = f"/query/run/{i}"
            if run_id in ids[:i]:
                wrong.append((422, _item(pointer, f"The run {run_id} is named twice.", "run_repeated")))
                continue
            try:
                run = stored.get_run(connection, run_id)
            except NotFoundError as error:
                wrong.append((404, _item(pointer, error.message, error.code)))
                continue
            if run.state != "succeeded":
                name = run.label or run.source.get("name", run_id)
                detail = f"The run {name!r} ({run_id}) is {run.state}: it has no result to compare."
                wrong.append((409, _item(pointer, detail, "no_result")))
            elif run.source.get("sweep"):
                detail = f"The run {run_id} has a sweep: its own tables compare what it varies."
                wrong.append((409, _item(pointer, detail, "sweep_not_comparable")))
            runs.append(run)
    if wrong:
        status, first = wrong[0]
        raise ProblemError(status, first.code, first.detail, errors=[item for _, item in wrong])
    return runs, [of_run(services, run) for run in runs]


def _item(pointer: str, detail: str, code: str) -> ProblemItem:
    return ProblemItem(pointer=pointer, detail=detail, code=code)


def _names(found: dict[str, Any], column: str) -> list[str]:
    """Return the targets or segments of all runs, in the order in which they first stand there."""
    return list(dict.fromkeys(str(value or "") for table in found.values() for value in table.columns[column]))


def _charts(runs: Sequence[stored.Run]) -> list[Chart]:
    return list({chart.name: chart for run in runs for chart in single.charts_of_run(run)}.values())


def _overlaid(
    services: Services, request: Request, name: str, ids: Sequence[str], form: single.Form, query: ChartQuery
) -> Response:
    runs, recordings = _found(services, ids)
    chart = single.named(_charts(runs), name)
    obstacle = tables.obstacle(chart.overlay, recordings)
    if obstacle is not None:
        detail = f"{obstacle} Look at the chart of each run by itself."
        raise ProblemError(409, "recordings_differ", detail)
    check_target(recordings, query.target)
    entries = tables.compared_entries(runs)

    def draw() -> Figure:
        # One recording for all runs that worked on it, so that its truth is drawn once.
        first, *others = [one.load() for one in {one.key: one for one in recordings}.values()]
        view = RunView(
            recording=first,
            entries=tuple(single.chart_entry(services, e.run, e.entry, index=e.index, label=e.label) for e in entries),
            others=tuple(others),
        )
        figure: Figure = chart.draw(single.selected(view, query.target), single.options_of(query, len(entries)))
        return figure

    version = tuple(part for e in entries for part in (e.run.id, e.run.result_sha256 or "", e.label))
    return single.drawn(request, draw, form, query, version, f"{name}-compared", "")
