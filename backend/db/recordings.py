"""Queries about recordings. Every function works inside the caller's transaction."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Literal

from sqlalchemy import ColumnElement, Connection, Row, delete, func, insert, select, tuple_, update

from backend.db import events, runs
from backend.db.ids import new_id, now
from backend.db.tables import recordings, rejections, run_recordings
from backend.errors import NotFoundError, StateError

RecordingState = Literal["parsing", "ready", "failed"]
FileRole = Literal["data", "site", "truth"]


@dataclass(frozen=True)
class StoredFile:
    """An uploaded file as it stands in the store; `name` is only a label."""

    role: FileRole
    name: str
    sha256: str
    size: int


@dataclass(frozen=True)
class Recording:
    """A row of `recordings`: the stored bytes, how they were to be read, and what came of it."""

    id: str
    created_at: dt.datetime
    name: str
    state: RecordingState
    kind: str | None
    format: str | None
    sha256: str
    fingerprint: str
    size_bytes: int
    files: tuple[StoredFile, ...]
    options: Mapping[str, Any]
    error: Mapping[str, Any] | None
    rows_read: int
    rows_accepted: int
    rows_rejected: int
    time_first_s: float | None
    time_last_s: float | None
    start_utc: str | None
    site: Mapping[str, Any] | None
    has_truth: bool
    warnings: tuple[Mapping[str, Any], ...]
    data_sha256: str | None


@dataclass(frozen=True)
class Rejection:
    """A row of a file that could not be used: number of the row, stable code, words."""

    row: int | None
    code: str
    detail: str
    file: str = ""


@dataclass(frozen=True)
class Parsed:
    """What reading the files of a recording gave."""

    kind: str
    format: str
    rows_read: int
    rows_accepted: int
    time_first_s: float | None
    time_last_s: float | None
    start_utc: str | None
    site: Mapping[str, Any] | None
    has_truth: bool
    warnings: Sequence[Mapping[str, Any]]
    rejections: Sequence[Rejection]
    data_sha256: str


@dataclass(frozen=True)
class Deleted:
    """What a deletion took away; the blobs may go if nothing else refers to them."""

    blobs: frozenset[str]
    run_ids: tuple[str, ...] = ()


def create_recording(
    connection: Connection,
    *,
    name: str,
    sha256: str,
    fingerprint: str,
    files: Sequence[StoredFile],
    options: Mapping[str, Any],
) -> Recording:
    """Add a recording in the state `parsing`.

    `fingerprint` is the hash of everything that decides how the recording reads (bytes, site, truth,
    options); ask `find_by_fingerprint` in the same transaction first.
    """
    recording_id = new_id()
    connection.execute(
        insert(recordings).values(
            id=recording_id,
            created_at=now(),
            name=name,
            state="parsing",
            sha256=sha256,
            fingerprint=fingerprint,
            size_bytes=sum(f.size for f in files),
            files=[{"role": f.role, "name": f.name, "sha256": f.sha256, "size": f.size} for f in files],
            options=dict(options),
            warnings=[],
        )
    )
    _announce(connection, recording_id, "parsing")
    return get_recording(connection, recording_id)


def find_by_fingerprint(connection: Connection, fingerprint: str) -> Recording | None:
    """Return the recording that reads the same bytes in the same way, if there is one."""
    row = connection.execute(select(recordings).where(recordings.c.fingerprint == fingerprint)).one_or_none()
    return None if row is None else _recording(row)


def get_recording(connection: Connection, recording_id: str) -> Recording:
    """Return a recording or raise NotFoundError."""
    row = connection.execute(select(recordings).where(recordings.c.id == recording_id)).one_or_none()
    if row is None:
        raise NotFoundError(f"There is no recording {recording_id!r}.", code="recording_not_found")
    return _recording(row)


def list_recordings(
    connection: Connection,
    *,
    limit: int = 50,
    after: tuple[dt.datetime, str] | None = None,
    oldest_first: bool = False,
    state: RecordingState | None = None,
    kind: str | None = None,
    text: str = "",
) -> list[Recording]:
    """Return up to `limit` recordings, newest first, that follow the recording (created_at, id) `after`."""
    key = tuple_(recordings.c.created_at, recordings.c.id)
    query = select(recordings).limit(limit)
    query = query.order_by(*(c.asc() if oldest_first else c.desc() for c in (recordings.c.created_at, recordings.c.id)))
    if after is not None:
        query = query.where(key > after if oldest_first else key < after)
    if state is not None:
        query = query.where(recordings.c.state == state)
    if kind is not None:
        query = query.where(recordings.c.kind == kind)
    if text:
        query = query.where(recordings.c.name.icontains(text, autoescape=True))
    return [_recording(row) for row in connection.execute(query)]


def recordings_in_state(connection: Connection, state: RecordingState) -> list[Recording]:
    """Return all recordings in a state, oldest first."""
    query = select(recordings).where(recordings.c.state == state)
    return [_recording(row) for row in connection.execute(query.order_by(recordings.c.created_at))]


def set_parsed(connection: Connection, recording_id: str, parsed: Parsed) -> bool:
    """Store what reading gave and make the recording `ready`; False where it is no longer `parsing`."""
    values = {f.name: getattr(parsed, f.name) for f in fields(parsed) if f.name not in ("rejections", "warnings")}
    if not _leave_parsing(
        connection,
        recording_id,
        state="ready",
        rows_rejected=len(parsed.rejections),
        warnings=[dict(w) for w in parsed.warnings],
        **values,
    ):
        return False
    add_rejections(connection, recording_id, parsed.rejections)
    return True


def set_failed(
    connection: Connection, recording_id: str, error: Mapping[str, Any], rejected: Sequence[Rejection] = ()
) -> bool:
    """Make the recording `failed` with {code, detail, remedy, pointer}; False where it is not `parsing`."""
    if not _leave_parsing(connection, recording_id, state="failed", error=dict(error), rows_rejected=len(rejected)):
        return False
    add_rejections(connection, recording_id, rejected)
    return True


def add_rejections(connection: Connection, recording_id: str, rejected: Sequence[Rejection]) -> None:
    """Store the rejected rows of a recording, in the order given."""
    if rejected:
        connection.execute(
            insert(rejections),
            [
                {
                    "recording_id": recording_id,
                    "position": position,
                    "row": r.row,
                    "code": r.code,
                    "detail": r.detail,
                    "file": r.file,
                }
                for position, r in enumerate(rejected)
            ],
        )


def list_rejections(
    connection: Connection, recording_id: str, *, start: int = 0, limit: int | None = 100
) -> list[Rejection]:
    """Return rejected rows in the order in which they were found, from position `start` on."""
    query = (
        select(rejections.c.row, rejections.c.code, rejections.c.detail, rejections.c.file)
        .where(rejections.c.recording_id == recording_id, rejections.c.position >= start)
        .order_by(rejections.c.position)
        .limit(limit)
    )
    return [Rejection(**row._mapping) for row in connection.execute(query)]


def delete_recording(connection: Connection, recording_id: str, *, with_runs: bool = False) -> Deleted:
    """Delete a recording.

    Raises
    ------
    StateError
        Runs use it and `with_runs` is false, or one of these runs is still queued or running.
    """
    recording = get_recording(connection, recording_id)
    used_by = connection.scalars(
        select(run_recordings.c.run_id).where(run_recordings.c.recording_id == recording_id)
    ).all()
    if used_by and not with_runs:
        raise StateError(
            f"{len(used_by)} run{'s use' if len(used_by) > 1 else ' uses'} this recording.",
            remedy="Delete the runs first, or repeat with runs=delete to delete them too.",
            code="recording_in_use",
        )
    blobs = {f.sha256 for f in recording.files} | ({recording.data_sha256} if recording.data_sha256 else set())
    for run_id in used_by:
        blobs |= runs.delete_run(connection, run_id)
    connection.execute(delete(recordings).where(recordings.c.id == recording_id))
    _announce(connection, recording_id, "deleted")
    return Deleted(frozenset(blobs), tuple(used_by))


def count_runs(connection: Connection, recording_id: str) -> int:
    """Return how many runs use a recording."""
    query = select(func.count()).select_from(run_recordings)
    return int(connection.scalar(query.where(run_recordings.c.recording_id == recording_id)) or 0)


def _leave_parsing(connection: Connection, recording_id: str, *, state: RecordingState, **values: Any) -> bool:
    still_parsing: ColumnElement[bool] = recordings.c.state == "parsing"
    statement = update(recordings).where(recordings.c.id == recording_id, still_parsing)
    if connection.execute(statement.values(state=state, **values)).rowcount == 0:
        return False
    _announce(connection, recording_id, state)
    return True


def _announce(connection: Connection, recording_id: str, state: str) -> None:
    events.append_event(connection, "recording.changed", {"id": recording_id, "state": state})


def _recording(row: Row[Any]) -> Recording:
    values = dict(row._mapping)
    values["files"] = tuple(StoredFile(**f) for f in values["files"])
    values["warnings"] = tuple(values["warnings"])
    return Recording(**values)
