"""Recordings: upload, list, what was read and what was not, round trip, deletion."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict
from starlette.background import BackgroundTask
from starlette.concurrency import run_in_threadpool
from starlette.responses import FileResponse, StreamingResponse

from algorithms.recording import recording_from_arrays
from backend.api import uploads
from backend.api.recording_schemas import (
    REJECTIONS_SHOWN,
    RawUploadQuery,
    RecordingItem,
    RecordingOut,
    RecordingPage,
    RecordingQuery,
    RejectionOut,
    read_again_of,
)
from backend.api.responses import content, problems
from backend.api.services import Services, ServicesDep
from backend.db import recordings as stored
from backend.http.etag import etag_of, matches, not_modified
from backend.http.multipart import label_of, receive_form, receive_raw, received
from backend.http.pagination import cut
from backend.http.problems import ProblemError

router = APIRouter(prefix="/recordings", tags=["recordings"])

_ROWS_PER_READ = 5000

UPLOAD_FORM: dict[str, Any] = {
    "type": "object",
    "required": ["file"],
    "additionalProperties": False,
    "properties": {
        "file": {
            "type": "array",
            "items": {"type": "string", "contentMediaType": "application/octet-stream"},
            "description": "Files of one kind; their rows are merged by time.",
        },
        "site": {"type": "string", "description": "Site JSON, or a sensor table as CSV."},
        "truth": {"type": "string", "description": "Truth at other times, as CSV."},
        "options": {"type": "string", "description": "Options as JSON: see ReadOptions."},
    },
}


class DeleteQuery(BaseModel):
    """What happens to the runs that use the recording."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    runs: Literal["keep", "delete"] = "keep"
    """`keep` refuses while runs use the recording; `delete` deletes them too."""


@router.post(
    "",
    name="create_recording",
    status_code=201,
    response_model=RecordingOut,
    responses={
        200: {"model": RecordingOut, "description": "The same bytes were read in the same way before"},
        **problems(413, 415, 507),
    },
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {
                "multipart/form-data": {"schema": UPLOAD_FORM},
                "application/octet-stream": {
                    "schema": {"type": "string", "contentMediaType": "application/octet-stream"}
                },
                "application/json": {"schema": {"$ref": "#/components/schemas/ReadAgain"}},
            },
        }
    },
)
async def create_recording(
    request: Request,
    response: Response,
    services: ServicesDep,
    options: Annotated[RawUploadQuery, Query()],
) -> RecordingOut:
    """Upload measurements: a form, one raw file with its options in the query, or stored bytes to read again."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type != "application/octet-stream" and options.model_fields_set:
        raise ProblemError(422, "validation", "Options in the query belong to a raw body (application/octet-stream).")
    services.engine.expect_recording()
    with received() as parts:
        if media_type == "multipart/form-data":
            await receive_form(request, parts, services.store.temporary)
            uploaded = await run_in_threadpool(uploads.from_form, services, parts)
        elif media_type == "application/octet-stream":
            name = label_of(options.name or "upload")
            await receive_raw(request, parts, services.store.temporary, name)
            given = options.model_dump(exclude_unset=True)
            uploaded = await run_in_threadpool(uploads.from_body, services, parts, given)
        elif media_type == "application/json":
            again = read_again_of(await request.body())
            uploaded = await run_in_threadpool(uploads.again, services, again)
        else:
            raise ProblemError(
                415,
                "unsupported_media_type",
                f"A body of type {media_type or 'unknown'!r} is not taken; send multipart/form-data with `file`, "
                "the raw file as application/octet-stream, or application/json with `from_recording_id`.",
            )
    response.status_code = 201 if uploaded.is_new else 200
    response.headers["Location"] = f"/api/v1/recordings/{uploaded.recording.id}"
    return await run_in_threadpool(shown_recording, services, uploaded.recording.id)


@router.get("", name="list_recordings", responses=problems())
def list_recordings(
    request: Request, response: Response, services: ServicesDep, query: Annotated[RecordingQuery, Query()]
) -> RecordingPage:
    """List recordings, newest first."""
    with services.database.read() as connection:
        rows = stored.list_recordings(
            connection,
            limit=query.limit + 1,
            after=query.position(),
            state=query.state,
            kind=query.kind,
            text=query.text,
        )
    rows, cursor = cut(query, rows, request, response)
    return RecordingPage(items=[RecordingItem.of(r) for r in rows], next_cursor=cursor)


@router.get("/{recording_id}", name="get_recording", response_model=RecordingOut, responses=problems(404))
def get_recording(recording_id: str, request: Request, services: ServicesDep) -> Response:
    """Show what was read and what was not."""
    content_bytes = shown_recording(services, recording_id).model_dump_json().encode()
    etag = etag_of(content_bytes)
    if matches(request, etag):
        return not_modified(etag)
    return Response(content_bytes, media_type="application/json", headers={"ETag": etag})


def shown_recording(services: Services, recording_id: str) -> RecordingOut:
    """Return a stored recording with its first rejected rows."""
    with services.database.read() as connection:
        recording = stored.get_recording(connection, recording_id)
        first = stored.list_rejections(connection, recording_id, limit=REJECTIONS_SHOWN)
        used = stored.count_runs(connection, recording_id)
    rejections = [RejectionOut(row=r.row, code=r.code, detail=r.detail, file=r.file) for r in first]
    return RecordingOut.of(recording, rejections=rejections, runs=used)


@router.delete("/{recording_id}", name="delete_recording", status_code=204, responses=problems(404, 409))
def delete_recording(recording_id: str, services: ServicesDep, query: Annotated[DeleteQuery, Query()]) -> None:
    """Delete a recording; refused while runs use it, unless they are to be deleted too."""
    uploads.delete(services, recording_id, with_runs=query.runs == "delete")


@router.get(
    "/{recording_id}/rejections.csv",
    name="get_rejections",
    response_class=Response,
    responses=content("text/csv", "Columns row, code, detail, file") | problems(404),
)
def get_rejections(recording_id: str, services: ServicesDep) -> Response:
    """All rows that were not used, with the reason for each."""
    with services.database.read() as connection:
        stored.get_recording(connection, recording_id)
    return StreamingResponse(
        _rejection_lines(services, recording_id),
        media_type="text/csv; charset=utf-8",
        headers={"Content-Disposition": f'attachment; filename="rejections-{recording_id}.csv"'},
    )


def _rejection_lines(services: Services, recording_id: str) -> Iterator[str]:
    start = 0
    while True:
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        if start == 0:
            writer.writerow(["row", "code", "detail", "file"])
        with services.database.read() as connection:
            rows = stored.list_rejections(connection, recording_id, start=start, limit=_ROWS_PER_READ)
        writer.writerows([r.row, r.code, r.detail, r.file] for r in rows)
        yield out.getvalue()
        if len(rows) < _ROWS_PER_READ:
            return
        start += _ROWS_PER_READ


@router.get(
    "/{recording_id}/data.csv",
    name="get_recording_csv",
    response_class=Response,
    responses=content("text/csv", "Native CSV, which reads back as the same recording") | problems(404, 409),
)
def get_recording_csv(recording_id: str, request: Request, services: ServicesDep) -> Response:
    """Give the accepted rows as native CSV."""
    from backend.files.native_csv_writer import write_native_csv

    recording = uploads.ready(services, recording_id)
    assert recording.data_sha256 is not None
    etag = etag_of("data.csv", recording.data_sha256)
    if matches(request, etag):
        return not_modified(etag)
    data = recording_from_arrays(services.store.get_arrays(recording.data_sha256))
    path = services.store.temporary()
    with path.open("w", encoding="utf-8", newline="") as out:
        write_native_csv(data, out)
    return FileResponse(
        path,
        media_type="text/csv; charset=utf-8",
        filename=f"recording-{recording_id}.csv",
        headers={"ETag": etag, "Cache-Control": "private, no-cache"},
        background=BackgroundTask(path.unlink, missing_ok=True),
    )
