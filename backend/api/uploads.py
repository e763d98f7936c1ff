"""From received bytes to a recording: store, recognise what was read before, have it read, answer."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from concurrent.futures import TimeoutError as StillReading
from dataclasses import dataclass
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError

from algorithms.recording import Recording as SimulatedRecording
from backend.api.recording_schemas import ReadAgain
from backend.api.services import Services
from backend.db import recordings
from backend.db.recordings import Recording, StoredFile
from backend.errors import STORAGE_CODES, NotFoundError, StateError
from backend.files.options import ReadOptions
from backend.http.multipart import Part, Parts, received
from backend.http.problems import ProblemError, ProblemItem, items_of, summary_of
from backend.jobs.collection import collect, storing

# A file up to this size is usually read before the user would look elsewhere, so the answer waits for it.
WAIT_BYTES = 8 * 2**20
WAIT_S = 8.0

_FIELDS = ("file", "site", "truth", "options")


@dataclass(frozen=True)
class Uploaded:
    """A recording and whether this request made it."""

    recording: Recording
    is_new: bool


def from_form(services: Services, parts: Parts) -> Uploaded:
    """Make a recording of a form with the fields file (repeated), site, truth and options."""
    return _store_and_read(services, parts.items, options_of_form(services, parts))


def options_of_form(services: Services, parts: Parts) -> ReadOptions:
    """Check the fields of a form and return its options."""
    problems = [
        ProblemItem(
            pointer=f"/{p.name}",
            detail=f"There is no such field; fields are {', '.join(_FIELDS)}.",
            code="unknown_field",
        )
        for p in parts.items
        if p.name not in _FIELDS
    ]
    if not parts.named("file"):
        problems.append(ProblemItem(pointer="/file", detail="A file is missing.", code="missing"))
    problems += [
        ProblemItem(pointer=f"/{name}", detail="Give this field once.", code="repeated")
        for name in ("site", "truth", "options")
        if len(parts.named(name)) > 1
    ]
    if problems:
        raise ProblemError(422, "validation", summary_of(problems), errors=problems)
    return _options(services, parts.named("options"))


def from_body(services: Services, parts: Parts, options: Mapping[str, Any]) -> Uploaded:
    """Make a recording of a raw body with its options from the query."""
    if parts.items[0].size == 0:
        item = ProblemItem(pointer="", detail="The body is empty.", code="missing")
        raise ProblemError(422, "validation", item.detail, errors=[item])
    try:
        read_options = ReadOptions.model_validate(options)
    except ValidationError as error:
        items = items_of(error, "/query")
        raise ProblemError(422, "validation", summary_of(items), errors=items) from error
    return _store_and_read(services, parts.items, read_options)


def again(services: Services, request: ReadAgain) -> Uploaded:
    """Make a recording of bytes that are stored already."""
    source = source_of(services, request)
    with storing(services.database, services.store) as put:
        files = [f for f in source.files if f.role == "data"]
        for role, value in (("site", request.site), ("truth", request.truth)):
            if role not in request.model_fields_set:
                files += [f for f in source.files if f.role == role]
            elif value is not None:
                text = value if isinstance(value, str) else json.dumps(value.to_json(), sort_keys=True)
                files.append(_put_text(services, role, text))  # type: ignore[arg-type]  # one of the two literals
                put.add(files[-1].sha256)
        found = _find_or_create(services, files, options_again(request, source), default_name=source.name)
    return _read(services, found)


def from_simulation(services: Services, recording: SimulatedRecording, name: str) -> Uploaded:
    """Make a recording of a simulated one: its native file and its site go the way of every upload."""
    from backend.files.native_csv_writer import write_native_csv

    assert recording.site is not None
    with received() as parts:
        data, site = services.store.temporary(), services.store.temporary()
        parts.items += [Part("file", "simulated.csv", data), Part("site", "site.json", site)]
        with data.open("w", encoding="utf-8", newline="") as out:
            write_native_csv(recording, out)
        site.write_text(json.dumps(recording.site.to_json(), sort_keys=True), encoding="utf-8")
        for part in parts.items:
            part.size = part.path.stat().st_size
        return _store_and_read(services, parts.items, ReadOptions(name=name))


def source_of(services: Services, request: ReadAgain) -> Recording:
    """Return the recording whose bytes are meant."""
    with services.database.read() as connection:
        try:
            return recordings.get_recording(connection, request.from_recording_id)
        except NotFoundError as error:
            item = ProblemItem(pointer="/from_recording_id", detail=error.message, code=error.code)
            raise ProblemError(422, error.code, error.message, errors=[item]) from error


def options_again(request: ReadAgain, source: Recording) -> ReadOptions:
    """Return the options given, else those of the recording."""
    if "options" in request.model_fields_set:
        return request.options or ReadOptions()
    return ReadOptions.model_validate(source.options)


def delete(services: Services, recording_id: str, *, with_runs: bool) -> None:
    """Delete a recording and every stored file that nothing else needs."""
    with services.database.write() as connection:
        gone = recordings.delete_recording(connection, recording_id, with_runs=with_runs)
    collect(services.database, services.store, gone.blobs)


def _options(services: Services, parts: Sequence[Part]) -> ReadOptions:
    if not parts:
        return ReadOptions()
    if parts[0].size > services.settings.max_json_bytes:
        item = ProblemItem(pointer="/options", detail="The options are too long.", code="too_large")
        raise ProblemError(413, "too_large", item.detail, errors=[item])
    try:
        return TypeAdapter(ReadOptions).validate_json(parts[0].path.read_bytes())
    except ValidationError as error:
        items = items_of(error, "/options")
        raise ProblemError(422, "validation", summary_of(items), errors=items) from error


def _store_and_read(services: Services, parts: Sequence[Part], options: ReadOptions) -> Uploaded:
    roles: dict[str, Literal["data", "site", "truth"]] = {"file": "data", "site": "site", "truth": "truth"}
    with storing(services.database, services.store) as put:
        files = []
        # In this order whatever the order of the form's parts.
        for name, role in roles.items():
            for part in (p for p in parts if p.name == name):
                sha256 = services.store.put_file(part.path)
                put.add(sha256)
                files.append(StoredFile(role=role, name=part.file_name or name, size=part.size, sha256=sha256))
        found = _find_or_create(services, files, options, default_name="")
    return _read(services, found)


def _put_text(services: Services, role: Literal["site", "truth"], text: str) -> StoredFile:
    data = text.encode()
    suffix = "json" if text.lstrip().startswith("{") else "csv"
    return StoredFile(role=role, name=f"{role}.{suffix}", size=len(data), sha256=services.store.put_bytes(data))


def _find_or_create(
    services: Services, files: Sequence[StoredFile], options: ReadOptions, default_name: str
) -> Uploaded:
    data = [f for f in files if f.role == "data"]
    how = options.model_dump(mode="json", exclude_defaults=True)
    decisive = {
        "data": [f.sha256 for f in data],
        "site": [f.sha256 for f in files if f.role == "site"],
        "truth": [f.sha256 for f in files if f.role == "truth"],
        "options": how,
    }
    fingerprint = hashlib.sha256(json.dumps(decisive, sort_keys=True).encode()).hexdigest()
    # One file is known by its own hash, several by the hash of their hashes.
    together = hashlib.sha256("".join(f.sha256 for f in data).encode()).hexdigest()
    with services.database.write() as connection:
        existing = recordings.find_by_fingerprint(connection, fingerprint)
        if existing is not None and existing.state != "failed":
            return Uploaded(existing, is_new=False)
        if existing is not None:
            # What failed is tried again: the reader may be newer, or the machine had no memory left then.
            recordings.delete_recording(connection, existing.id)
        created = recordings.create_recording(
            connection,
            name=options.name or default_name or _default_name(data),
            sha256=data[0].sha256 if len(data) == 1 else together,
            fingerprint=fingerprint,
            files=files,
            options=how,
        )
    return Uploaded(created, is_new=True)


def _default_name(data: Sequence[StoredFile]) -> str:
    return data[0].name if len(data) == 1 else f"{data[0].name} and {len(data) - 1} more"


def _read(services: Services, found: Uploaded) -> Uploaded:
    """Have a recording read that is not yet, and wait for a small one."""
    recording = found.recording
    if recording.state != "parsing":
        return found
    # The same upload twice at the same time is read once; both wait for it.
    reading = services.engine.read_recording(recording.id)
    if recording.size_bytes > WAIT_BYTES:
        return found
    try:
        recording = reading.result(timeout=WAIT_S)
    except StillReading:
        return found
    if recording.state == "failed":
        if found.is_new:
            delete(services, recording.id, with_runs=False)
        raise unreadable(recording.error or {})
    return Uploaded(recording, found.is_new)


def unreadable(error: Mapping[str, Any]) -> ProblemError:
    """Return the problem that tells why files cannot be read."""
    detail = f"{error.get('detail', 'The file could not be read.')} {error.get('remedy') or ''}".strip()
    code = str(error.get("code", "unreadable"))
    item = ProblemItem(pointer=str(error.get("pointer") or "/file"), detail=detail, code=code)
    if code in STORAGE_CODES:
        return ProblemError(507, code, detail)
    return ProblemError(422, code, detail, errors=[item])


def ready(services: Services, recording_id: str) -> Recording:
    """Return a recording that has been read.

    Raises
    ------
    StateError
        It is still being read, or could not be.
    """
    with services.database.read() as connection:
        recording = recordings.get_recording(connection, recording_id)
    if recording.state == "parsing":
        raise StateError(
            "The recording is still being read.", remedy="Try again in a moment.", code="recording_not_ready"
        )
    if recording.state == "failed":
        raise StateError(
            "The recording could not be read.",
            remedy="Its `error` says why; read it again with other options.",
            code="recording_failed",
        )
    return recording
