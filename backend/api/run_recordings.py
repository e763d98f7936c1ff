"""The recordings of a run: each is there and has been read, and several can be joined to one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from algorithms.errors import InputError
from algorithms.recording import Recording as Measured
from algorithms.recording import recording_from_arrays
from backend.api.run_schemas import RunIn
from backend.api.services import Services
from backend.db import recordings
from backend.db.recordings import Recording
from backend.errors import NotFoundError, StateError
from backend.files.joining import Joined, join_recordings
from backend.http.problems import ProblemError, ProblemItem


def recordings_of(services: Services, request: RunIn) -> list[Recording]:
    """Return the recordings that a request names.

    Raises
    ------
    ProblemError
        One of them does not exist, or is named twice.
    StateError
        One of them is still being read, or could not be.
    """
    if request.recording_ids is None:
        assert request.recording_id is not None
        return [_ready(services, request.recording_id, "/recording_id")]
    ids = request.recording_ids
    if not ids:
        raise _refused("/recording_ids", "Name at least one recording.", "source_missing")
    for i, recording_id in enumerate(ids):
        if recording_id in ids[:i]:
            detail = f"The recording {recording_id!r} is named twice; leave one out."
            raise _refused(f"/recording_ids/{i}", detail, "recording_repeated")
    return [_ready(services, recording_id, f"/recording_ids/{i}") for i, recording_id in enumerate(ids)]


def source_of(services: Services, found: Sequence[Recording]) -> dict[str, Any]:
    """Return what is stored of the origin of a run on these recordings.

    Raises
    ------
    ProblemError
        Several of them cannot be joined; the pointer names the recording and its field.
    """
    first = found[0]
    if len(found) == 1:
        return {"recording_id": first.id, "name": first.name, "kind": first.kind}
    try:
        joined = _joined(services, found)
    except InputError as error:
        detail = f"{error.message} {error.remedy}".strip()
        raise _refused(f"/recording_ids{error.pointer}", detail, error.code) from error
    return {
        "recording_ids": [one.id for one in found],
        "first_rows": list(joined.first_rows),
        "name": " + ".join(one.name for one in found),
        "kind": first.kind,
    }


def measurements_of(services: Services, found: Sequence[Recording]) -> Measured:
    """Return what the recordings of a run hold, several of them joined."""
    if len(found) > 1:
        return _joined(services, found).recording
    return recording_from_arrays(services.store.get_arrays(str(found[0].data_sha256)))


def is_joined(source: Mapping[str, Any]) -> bool:
    """Whether a run works on several recordings as one."""
    return "recording_ids" in source


def _joined(services: Services, found: Sequence[Recording]) -> Joined:
    named = []
    for one in found:
        assert one.data_sha256 is not None
        named.append((one.name, recording_from_arrays(services.store.get_arrays(one.data_sha256))))
    return join_recordings(named)


def _ready(services: Services, recording_id: str, pointer: str) -> Recording:
    with services.database.read() as connection:
        try:
            recording = recordings.get_recording(connection, recording_id)
        except NotFoundError as error:
            raise _refused(pointer, error.message, error.code) from error
    if recording.state == "parsing":
        raise StateError(
            f"The recording {recording.name!r} is still being read.",
            remedy="Try again when its state is `ready`.",
            code="recording_not_ready",
        )
    if recording.state == "failed":
        raise StateError(
            f"The recording {recording.name!r} could not be read.",
            remedy="Its `error` says why; read it again with other options.",
            code="recording_failed",
        )
    return recording


def _refused(pointer: str, detail: str, code: str) -> ProblemError:
    return ProblemError(422, code, detail, errors=[ProblemItem(pointer=pointer, detail=detail, code=code)])
