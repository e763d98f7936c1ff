"""A look into files before they become a recording: columns, first rows, suggestions, and what reading would give."""

from __future__ import annotations

import json
from collections.abc import Mapping
from concurrent.futures import TimeoutError as StillReading
from pathlib import Path
from typing import Any

from fastapi import APIRouter, Request
from pydantic import BaseModel, ConfigDict
from starlette.concurrency import run_in_threadpool

from algorithms.recording import KINDS, Kind
from backend.api import uploads
from backend.api.recording_schemas import ReadAgain, RejectionOut, Rows, WarningOut, read_again_of
from backend.api.recordings import UPLOAD_FORM
from backend.api.responses import problems
from backend.api.services import Services, ServicesDep
from backend.errors import StateError
from backend.files.column_guess import native_columns
from backend.files.options import ColumnSource, ReadOptions
from backend.http.multipart import Parts, receive_form, received
from backend.http.problems import ProblemError
from backend.jobs.reader_process import ReadAnswer

router = APIRouter(prefix="/recordings", tags=["recordings"])

# A page waits for the answer; what takes longer than a proxy's patience is no preview.
_PATIENCE_S = 50.0
_REJECTIONS_SHOWN = 20


class _Model(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class NativeColumnOut(_Model):
    """A native column that a kind has."""

    name: str
    """`toa_<station>_ns` stands for one column per station."""
    units: list[str]
    """Units that a column of the file may be in, the native one first; none for names and counters."""


class SuggestionOut(_Model):
    """What the columns may mean, told from their names. Nothing of it was applied."""

    kind: Kind | None
    mapping: dict[str, ColumnSource]
    """For the option `mapping`; columns that are native already are not in it."""


class OptionOut(_Model):
    """An option of reading that means something for the file."""

    name: str
    values: list[str]
    """What it may be; empty where it is free."""
    is_number: bool
    description: str


class TrialOut(_Model):
    """What reading with the given options would give."""

    kind: Kind
    format: str
    rows: Rows
    rejections: list[RejectionOut]
    """The first twenty."""
    warnings: list[WarningOut]
    time_span_s: tuple[float, float]


class TrialErrorOut(_Model):
    """Why reading with the given options would give nothing."""

    code: str
    detail: str
    remedy: str
    pointer: str


class PreviewOut(_Model):
    """What is in the first file, and what reading all of them would give."""

    format: str | None
    """The reader that recognises the file without a mapping."""
    columns: list[str]
    """The line of names; empty where the file is no delimited text."""
    rows: list[list[str]]
    """The first twenty rows, as text."""
    suggestion: SuggestionOut
    trial: TrialOut | None
    error: TrialErrorOut | None
    native_columns: dict[Kind, list[NativeColumnOut]]
    """What a mapping may name, by kind."""
    options: list[OptionOut]
    """Options beside mapping and filter that this format, or this kind, has a use for."""


@router.post(
    "/preview",
    name="preview_recording",
    response_model=PreviewOut,
    responses=problems(409, 413, 415, 507),
    openapi_extra={
        "requestBody": {
            "required": True,
            "content": {
                "multipart/form-data": {"schema": UPLOAD_FORM},
                "application/json": {"schema": {"$ref": "#/components/schemas/ReadAgain"}},
            },
        }
    },
)
async def preview_recording(request: Request, services: ServicesDep) -> PreviewOut:
    """Look into files (a form as for an upload), or into stored bytes that are to be read again; nothing is stored."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    with received() as parts:
        if media_type == "multipart/form-data":
            await receive_form(request, parts, services.store.temporary)
            answer = await run_in_threadpool(_look_into_form, services, parts)
        elif media_type == "application/json":
            again = read_again_of(await request.body())
            answer = await run_in_threadpool(_look_again, services, again)
        else:
            raise ProblemError(
                415,
                "unsupported_media_type",
                f"A body of type {media_type or 'unknown'!r} is not taken; send multipart/form-data with `file`, or "
                "application/json with `from_recording_id`.",
            )
    return _shown(answer)


def _look_into_form(services: Services, parts: Parts) -> ReadAnswer:
    options = uploads.options_of_form(services, parts)
    files = tuple((p.file_name or p.name, p.path) for p in parts.named("file"))
    site = [p.path.read_bytes() for p in parts.named("site")]
    truth = [(p.file_name or p.name, p.path) for p in parts.named("truth")]
    return _look(services, files, site, truth, options.model_dump(mode="json"))


def _look_again(services: Services, request: ReadAgain) -> ReadAnswer:
    source = uploads.source_of(services, request)

    def stored(role: str) -> list[tuple[str, Path]]:
        return [(f.name, services.store.path(f.sha256)) for f in source.files if f.role == role]

    site = [path.read_bytes() for _, path in stored("site")]
    if "site" in request.model_fields_set:
        given = request.site
        site = [] if given is None else [(given if isinstance(given, str) else json.dumps(given.to_json())).encode()]
    options = uploads.options_again(request, source).model_dump(mode="json")
    if "truth" not in request.model_fields_set:
        return _look(services, tuple(stored("data")), site, stored("truth"), options)
    if request.truth is None:
        return _look(services, tuple(stored("data")), site, [], options)
    path = services.store.temporary()
    try:
        path.write_text(request.truth, encoding="utf-8")
        return _look(services, tuple(stored("data")), site, [("truth.csv", path)], options)
    finally:
        path.unlink(missing_ok=True)


def _look(
    services: Services,
    files: tuple[tuple[str, Path], ...],
    site: list[bytes],
    truth: list[tuple[str, Path]],
    options: Mapping[str, Any],
) -> ReadAnswer:
    looking = services.engine.look_into(files, site[0] if site else None, truth[0] if truth else None, options)
    try:
        answer = looking.result(timeout=_PATIENCE_S)
    except StillReading as error:
        looking.cancel()
        raise StateError(
            "The reader is busy with another file, or this one is too large for a look.",
            remedy="Try again in a moment, with fewer rows of it, or upload it at once.",
            code="reader_busy",
        ) from error
    if answer.error is not None:
        raise uploads.unreadable(answer.error)
    return answer


def _shown(answer: ReadAnswer) -> PreviewOut:
    seen = answer.preview
    assert seen is not None
    trial = None
    if answer.kind:
        assert answer.time_first_s is not None
        assert answer.time_last_s is not None
        trial = TrialOut(
            kind=answer.kind,
            format=answer.format,
            rows=Rows(
                read=answer.rows_read, accepted=answer.rows_accepted, rejected=answer.rows_read - answer.rows_accepted
            ),
            rejections=[
                RejectionOut(row=row, code=code, detail=detail, file=file)
                for row, code, detail, file in answer.rejections[:_REJECTIONS_SHOWN]
            ],
            warnings=[WarningOut(**w) for w in answer.warnings],
            time_span_s=(answer.time_first_s, answer.time_last_s),
        )
    return PreviewOut(
        format=seen["format"],
        columns=list(seen["columns"]),
        rows=[list(r) for r in seen["rows"]],
        suggestion=SuggestionOut(kind=seen["kind"], mapping=seen["mapping"]),
        trial=trial,
        error=None if seen["error"] is None else TrialErrorOut(**seen["error"]),
        native_columns={
            kind: [NativeColumnOut(name=c.name, units=list(c.units)) for c in native_columns(kind)] for kind in KINDS
        },
        options=[_option(name) for name in seen["options"]],
    )


def _option(name: str) -> OptionOut:
    schema = ReadOptions.model_json_schema()["properties"][name]
    forms = schema.get("anyOf", [schema])
    return OptionOut(
        name=name,
        values=[str(value) for form in forms for value in form.get("enum", ())],
        is_number=any(form.get("type") in ("number", "integer") for form in forms),
        description=schema.get("description", ""),
    )
