"""Tables of a run in long form, and its result file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from io import StringIO
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import FileResponse, StreamingResponse

from algorithms.result import Table
from backend.api.measurements import of_run
from backend.api.responses import content, problems
from backend.api.services import Services, ServicesDep
from backend.api.targets import TargetName, check_target
from backend.db import runs as stored
from backend.errors import NotFoundError, StateError
from backend.files.table_writer import write_table_csv
from backend.http.etag import IMMUTABLE, etag_of, matches, not_modified
from backend.http.problems import ProblemError, ProblemItem

if TYPE_CHECKING:
    from backend.jobs.partial_results import PartialRun

router = APIRouter(prefix="/runs/{run_id}", tags=["results"])

# What a Monte Carlo run can say before its end.
PARTIAL_TABLES = ("metrics", "comparisons", "consistency", "curves")

_ROWS_AT_ONCE = 5000


class TableItem(BaseModel):
    """A table that a run has."""

    name: str
    rows: int
    csv_url: str
    json_url: str


class TableList(BaseModel):
    """All tables of a run."""

    items: list[TableItem]


class TableOut(BaseModel):
    """Rows of a table; null = not applicable."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    columns: list[str]
    rows: list[list[float | int | str | bool | None]]
    total: int
    """Rows of the whole table, or of the target."""


class RowsQuery(BaseModel):
    """A part of a table."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    offset: Annotated[int, Field(ge=0, le=10**12)] = 0
    """Rows to skip."""
    limit: Annotated[int, Field(ge=1, le=10**12)] | None = None
    """Most rows to give; default: all."""
    target: TargetName = ""
    """Only rows of this target; default: all."""


def finished(services: Services, run_id: str) -> stored.Run:
    """Return a run that has a result.

    Raises
    ------
    StateError
        It is not finished, or did not succeed.
    """
    with services.database.read() as connection:
        run = stored.get_run(connection, run_id)
    if run.state != "succeeded":
        raise StateError(
            f"The run is {run.state}: it has no result.",
            remedy="Run it again." if run.is_final else "Wait until its state is `succeeded`.",
            code="no_result",
        )
    return run


def answering(services: Services, run_id: str) -> tuple[stored.Run, PartialRun | None]:
    """Return a run that has a result, or one whose trials still run, with what they say so far.

    Raises
    ------
    StateError
        It has nothing to say yet, or it failed or was cancelled.
    """
    with services.database.read() as connection:
        run = stored.get_run(connection, run_id)
    if run.state == "running" and "scenario" in run.source:
        from backend.jobs.partial_results import partial_run

        partial = partial_run(services.database, services.store, run)
        if partial is not None:
            return run, partial
    return finished(services, run_id), None


@router.get("/tables", name="list_tables", responses=problems(404, 409))
def list_tables(run_id: str, services: ServicesDep) -> TableList:
    """List the tables of a run; while its trials run, those that can be told from the finished ones."""
    from backend.jobs.results import table_names

    run, partial = answering(services, run_id)
    if partial is None:
        sizes = table_names(services.database, run)
    else:
        found = {name: partial.table(name) for name in PARTIAL_TABLES}
        sizes = {name: len(table) for name, table in found.items() if table is not None}
    url = f"/api/v1/runs/{run_id}/tables"
    return TableList(
        items=[
            TableItem(name=name, rows=rows, csv_url=f"{url}/{name}.csv", json_url=f"{url}/{name}.json")
            for name, rows in sizes.items()
        ]
    )


@router.get(
    "/tables/{table}.json",
    name="get_table_json",
    response_model=TableOut,
    responses=problems(404, 409, 422),
)
def get_table_json(
    run_id: str, table: str, request: Request, services: ServicesDep, query: Annotated[RowsQuery, Query()]
) -> Response:
    """Give a table, or some rows of it, as JSON: names of columns, and rows."""
    run, partial = answering(services, run_id)
    etag = _etag(run, partial, table, "json", query)
    found = rows_of_table(services, run, partial, table, query.target)
    if matches(request, etag):
        return not_modified(etag)
    return StreamingResponse(_json(found, *_range(found, query)), media_type="application/json", headers=_headers(etag))


@router.get(
    "/tables/{table}.csv",
    name="get_table_csv",
    response_class=Response,
    responses=content("text/csv", "First line = names; empty = not applicable") | problems(404, 409),
)
def get_table_csv(
    run_id: str, table: str, request: Request, services: ServicesDep, query: Annotated[RowsQuery, Query()]
) -> Response:
    """Give a table, or some rows of it, as CSV."""
    run, partial = answering(services, run_id)
    etag = _etag(run, partial, table, "csv", query)
    found = rows_of_table(services, run, partial, table, query.target)
    if matches(request, etag):
        return not_modified(etag)
    headers = _headers(etag) | {"Content-Disposition": f'attachment; filename="{table}-{run_id}.csv"'}
    return StreamingResponse(_csv(found, *_range(found, query)), media_type="text/csv; charset=utf-8", headers=headers)


@router.get(
    "/result.npz",
    name="get_result",
    response_class=Response,
    responses=content(
        "application/octet-stream",
        "NumPy archive: LABEL/ARRAY, and tables/TABLE/LABEL/COLUMN",
        {"type": "string", "contentMediaType": "application/octet-stream"},
    )
    | problems(404, 409),
)
def get_result(run_id: str, request: Request, services: ServicesDep) -> Response:
    """Give all arrays of a run; `numpy.load` reads them without pickle."""
    run = finished(services, run_id)
    assert run.result_sha256 is not None
    etag = f'"{run.result_sha256}"'
    if matches(request, etag):
        return not_modified(etag, IMMUTABLE)
    return FileResponse(
        services.store.path(run.result_sha256),
        media_type="application/octet-stream",
        filename=f"run-{run_id}.npz",
        headers={"ETag": etag, "Cache-Control": IMMUTABLE},
    )


def rows_of_table(services: Services, run: stored.Run, partial: PartialRun | None, name: str, target: str) -> Table:
    """Return a table of a run, or its rows of one target; the empty name means all."""
    from backend.charts.target import table_of
    from backend.jobs.results import load_table

    table = load_table(services.database, services.store, run, name) if partial is None else partial.table(name)
    if table is None:
        raise NotFoundError(
            f"The table {name!r} is not known while trials still run.",
            remedy=f"There are {', '.join(PARTIAL_TABLES)}; the others come with the end of the run.",
            code="table_not_found",
        )
    if not target:
        return table
    if "target" not in table.columns:
        detail = f"The table {name!r} does not say which target its rows are of; ask for it without `target`."
        item = ProblemItem(pointer="/query/target", detail=detail, code="table_without_targets")
        raise ProblemError(422, "table_without_targets", detail, errors=[item])
    check_target([of_run(services, run, partial)], target)
    return table_of(table, target)


def _etag(run: stored.Run, partial: PartialRun | None, table: str, form: str, query: RowsQuery) -> str:
    version = run.result_sha256 or "" if partial is None else partial.version
    return etag_of(run.id, version, table, form, query.model_dump_json())


def _headers(etag: str) -> dict[str, str]:
    return {"ETag": etag, "Cache-Control": "private, no-cache"}


def _range(table: Table, query: RowsQuery) -> tuple[int, int]:
    start = min(query.offset, len(table))
    return start, len(table) if query.limit is None else min(len(table), start + query.limit)


def _json(table: Table, start: int, stop: int) -> Iterator[str]:
    yield f'{{"columns":{json.dumps(table.names)},"total":{len(table)},"rows":['
    for at in range(start, stop, _ROWS_AT_ONCE):
        rows: list[Any] = list(table.rows(at, min(stop, at + _ROWS_AT_ONCE)))
        text = json.dumps(rows, separators=(",", ":"), allow_nan=False)
        yield ("," if at > start else "") + text[1:-1]
    yield "]}"


def _csv(table: Table, start: int, stop: int) -> Iterator[str]:
    for at in range(start, max(stop, start + 1), _ROWS_AT_ONCE):
        out = StringIO()
        write_table_csv(table.take(slice(at, min(stop, at + _ROWS_AT_ONCE))), out, header=at == start)
        yield out.getvalue()
