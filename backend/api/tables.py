"""Tables of a run in long form, and its result file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from io import StringIO
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import FileResponse, StreamingResponse

from algorithms.result import Table
from backend.api import uploads
from backend.api.responses import content, problems
from backend.api.services import Services, ServicesDep
from backend.api.targets import TargetName, check_target
from backend.db import runs as stored
from backend.errors import StateError
from backend.files.table_writer import write_table_csv
from backend.http.etag import IMMUTABLE, etag_of, matches, not_modified
from backend.http.problems import ProblemError, ProblemItem

router = APIRouter(prefix="/runs/{run_id}", tags=["results"])

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


@router.get("/tables", name="list_tables", responses=problems(404, 409))
def list_tables(run_id: str, services: ServicesDep) -> TableList:
    """List the tables of a run."""
    from backend.jobs.results import table_names

    sizes = table_names(services.database, finished(services, run_id))
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
    run = finished(services, run_id)
    etag = _etag(run, table, "json", query)
    found = _load(services, run, table, query.target)
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
    run = finished(services, run_id)
    etag = _etag(run, table, "csv", query)
    found = _load(services, run, table, query.target)
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


def _load(services: Services, run: stored.Run, name: str, target: str) -> Table:
    from backend.charts.target import table_of
    from backend.jobs.results import load_table

    table = load_table(services.database, services.store, run, name)
    if not target:
        return table
    if "target" not in table.columns:
        detail = f"The table {name!r} does not say which target its rows are of; ask for it without `target`."
        item = ProblemItem(pointer="/query/target", detail=detail, code="table_without_targets")
        raise ProblemError(422, "table_without_targets", detail, errors=[item])
    check_target(services, [uploads.ready(services, str(run.source["recording_id"]))], target)
    return table_of(table, target)


def _etag(run: stored.Run, table: str, form: str, query: RowsQuery) -> str:
    return etag_of(run.id, run.result_sha256 or "", table, form, query.model_dump_json())


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
        write_table_csv(_cut(table, at, min(stop, at + _ROWS_AT_ONCE)), out, header=at == start)
        yield out.getvalue()


def _cut(table: Table, start: int, stop: int) -> Table:
    return Table({name: column[start:stop] for name, column in table.columns.items()})
