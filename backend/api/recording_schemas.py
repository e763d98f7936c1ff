"""Recordings as the API takes and gives them."""

from __future__ import annotations

import datetime as dt
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from algorithms.recording import Kind
from algorithms.site import Site
from backend.db import recordings as stored
from backend.files.options import ReadOptions
from backend.http.pagination import PageQuery
from backend.http.problems import ProblemError, items_of, summary_of

REJECTIONS_SHOWN = 100


class _Model(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class RawUploadQuery(BaseModel):
    """The simple options of a raw upload."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    name: Annotated[str, Field(max_length=200)] | None = None
    """Name of the recording."""
    kind: Kind | None = None
    """Kind of the measurements, where the columns leave it open."""
    format: Annotated[str, Field(max_length=40)] | None = None
    """Name of a reader, where the content leaves it open."""
    start_utc: Annotated[str, Field(max_length=40)] | None = None
    """The instant from which `time_s` counts."""
    edition: Annotated[str, Field(max_length=40)] | None = None
    """Edition of a binary format's specification: "1.30", or by ASTERIX category "48:1.30 34:1.27"."""
    scan_cut: Literal["marks", "azimuth", "period"] | None = None
    """How plots are parted into scans."""
    scan_period_s: Annotated[float, Field(gt=0, le=3600)] | None = None
    """Seconds of one turn of the antenna."""
    order: Literal["sort", "reject"] | None = None
    """What happens to rows that are earlier than one before them."""
    equal_times: Literal["reject", "average"] | None = None
    """What happens to a Doppler that is measured again at the same instant."""


class ReadAgain(BaseModel):
    """Read stored bytes again, with something corrected. What is not given stays as it was; null takes it away."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False)

    from_recording_id: Annotated[str, Field(max_length=64)]
    """The recording whose bytes are read again."""
    site: Site | str | None = None
    """Site JSON, or a sensor table as CSV text."""
    truth: str | None = None
    """Truth as CSV text."""
    options: ReadOptions | None = None
    """All options; they replace the earlier ones."""


def read_again_of(body: bytes) -> ReadAgain:
    """Take the body of a request apart."""
    try:
        return TypeAdapter(ReadAgain).validate_json(body)
    except ValidationError as error:
        if any(e["type"] == "json_invalid" for e in error.errors()):
            raise ProblemError(400, "malformed_json", f"{error.errors()[0]['msg']}.") from error
        items = items_of(error)
        raise ProblemError(422, "validation", summary_of(items), errors=items) from error


class Rows(_Model):
    """What became of the rows."""

    read: int
    accepted: int
    rejected: int


class RejectionOut(_Model):
    """A row that was not used."""

    row: int | None
    code: str
    detail: str
    file: str


class WarningOut(_Model):
    """Something that was noticed, or decided for the user."""

    code: str
    detail: str
    count: int


class FileOut(_Model):
    """An uploaded file."""

    role: Literal["data", "site", "truth"]
    name: str
    sha256: str
    size: int


class RecordingItem(_Model):
    """A recording in a list."""

    id: str
    name: str
    kind: Kind | None
    """Null while the file is parsed."""
    format: str | None
    sha256: str
    """Hash of the uploaded bytes."""
    state: Literal["parsing", "ready", "failed"]
    rows: Rows
    rejections_url: str
    time_span_s: tuple[float, float] | None
    """First and last `time_s`."""
    start_utc: str | None
    """The instant from which `time_s` counts."""
    site: dict[str, Any] | None
    has_truth: bool
    warnings: list[WarningOut]
    files: list[FileOut]
    options: dict[str, Any]
    error: dict[str, Any] | None
    """Why reading failed: code, detail, remedy, pointer."""
    created_at: dt.datetime
    size_bytes: int

    @classmethod
    def of(cls, recording: stored.Recording, **more: Any) -> Self:
        """Show a stored recording."""
        first, last = recording.time_first_s, recording.time_last_s
        return cls(
            id=recording.id,
            name=recording.name,
            kind=recording.kind,
            format=recording.format,
            sha256=recording.sha256,
            state=recording.state,
            rows=Rows(read=recording.rows_read, accepted=recording.rows_accepted, rejected=recording.rows_rejected),
            rejections_url=f"/api/v1/recordings/{recording.id}/rejections.csv",
            time_span_s=None if first is None or last is None else (first, last),
            start_utc=recording.start_utc,
            site=None if recording.site is None else dict(recording.site),
            has_truth=recording.has_truth,
            warnings=[WarningOut(**w) for w in recording.warnings],
            files=[FileOut(role=f.role, name=f.name, sha256=f.sha256, size=f.size) for f in recording.files],
            options=dict(recording.options),
            error=None if recording.error is None else dict(recording.error),
            created_at=recording.created_at,
            size_bytes=recording.size_bytes,
            **more,
        )


class RecordingOut(RecordingItem):
    """A recording with its first rejected rows."""

    rejections: list[RejectionOut]
    """The first hundred; all of them are at `rejections_url`."""
    runs: int
    """How many runs use it."""


class RecordingPage(_Model):
    """A page of recordings, newest first."""

    items: list[RecordingItem]
    next_cursor: str | None


class RecordingQuery(PageQuery):
    """Filters of the list."""

    state: Literal["parsing", "ready", "failed"] | None = None
    kind: Kind | None = None
    text: Annotated[str, Field(max_length=200)] = ""
    """Part of the name."""
