"""Parse jobs: from the stored files of a recording to its arrays, one at a time, in order of arrival."""

from __future__ import annotations

import logging
import threading
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from backend.db import recordings
from backend.db.engine import Database
from backend.errors import StateError, StorageError, UnavailableError
from backend.files.store import Store
from backend.jobs.collection import collect, storing
from backend.jobs.reader_process import ReadAnswer, ReaderProcess, ReadRequest
from backend.settings import Settings

logger = logging.getLogger(__name__)

# Seconds until a recording is read again whose outcome could not be written down.
RETRY_S = 5.0


class Parser:
    """Parses recordings in the state `parsing`, in the background."""

    def __init__(self, database: Database, store: Store, settings: Settings) -> None:
        self._database = database
        self._store = store
        self._max_rows = settings.max_rows
        self._process = ReaderProcess(settings.reader_memory_bytes, settings.reader_timeout_s)
        self._stopping = threading.Event()
        self._under_way: dict[str, Future[recordings.Recording]] = {}
        # Reentrant: a future that is done already calls back at once.
        self._lock = threading.RLock()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="parser")

    def expect(self) -> None:
        """Have the process ready by the time at which a file that is arriving is there."""
        if self._process.pid is None:
            self._thread.submit(self._process.start)

    def parse(self, recording_id: str) -> Future[recordings.Recording]:
        """Parse a recording, once however often it is asked for; the future gives its row, `ready` or `failed`."""
        with self._lock:
            future = self._under_way.get(recording_id)
            if future is None:
                future = self._under_way[recording_id] = self._thread.submit(self._parse, recording_id)
                future.add_done_callback(lambda _: self._forget(recording_id))
            return future

    def look(
        self,
        files: tuple[tuple[str, Path], ...],
        site: bytes | None,
        truth: tuple[str, Path] | None,
        options: Mapping[str, Any],
    ) -> Future[ReadAnswer]:
        """Look into files without storing anything, after what is being parsed."""
        request = ReadRequest(files, site, truth, options, self._max_rows, output=None)
        return self._thread.submit(self._process.read, request)

    def tracks(
        self, file: tuple[str, Path], options: Mapping[str, Any], choice: Mapping[str, Any]
    ) -> Future[ReadAnswer]:
        """Read the paths of a file without storing anything, after what is being parsed."""
        request = ReadRequest((file,), None, None, options, self._max_rows, output=None, tracks=choice)
        return self._thread.submit(self._process.read, request)

    def _forget(self, recording_id: str) -> None:
        with self._lock:
            del self._under_way[recording_id]

    def resume(self) -> None:
        """Parse again what an earlier server did not finish."""
        with self._database.read() as connection:
            unfinished = recordings.recordings_in_state(connection, "parsing")
        for recording in unfinished:
            self.parse(recording.id)

    def stop(self) -> None:
        """Give up what is under way; the next server resumes it."""
        self._stopping.set()
        self._process.kill()
        self._thread.shutdown(wait=True, cancel_futures=True)
        self._process.stop()

    @property
    def pid(self) -> int | None:
        """Process that reads, None while there is none."""
        return self._process.pid

    def _parse(self, recording_id: str) -> recordings.Recording:
        """Read a recording; where neither arrays nor failure can be written down, read it again until they can."""
        while True:
            try:
                return self._read(recording_id)
            except (StorageError, UnavailableError) as error:
                logger.error("recording %s cannot be written down, and is read again: %s", recording_id, error)
                if self._stopping.wait(RETRY_S):
                    raise _stopping() from error

    def _read(self, recording_id: str) -> recordings.Recording:
        with self._database.read() as connection:
            recording = recordings.get_recording(connection, recording_id)
        output = self._store.temporary()
        try:
            answer = self._process.read(self._request(recording, output))
            if self._stopping.is_set():
                # It may be our own kill that ended it.
                raise _stopping()
            self._settle(recording, answer, output)
        except StorageError as error:
            with self._database.write() as connection:
                recordings.set_failed(
                    connection,
                    recording_id,
                    {"code": error.code, "detail": error.message, "remedy": error.remedy, "pointer": ""},
                )
        finally:
            output.unlink(missing_ok=True)
        with self._database.read() as connection:
            return recordings.get_recording(connection, recording_id)

    def _settle(self, recording: recordings.Recording, answer: ReadAnswer, output: Path) -> None:
        rejected = [recordings.Rejection(*r) for r in answer.rejections]
        if answer.error is not None:
            if answer.trace:
                logger.error("reading recording %s failed:\n%s", recording.id, answer.trace)
            with self._database.write() as connection:
                recordings.set_failed(connection, recording.id, answer.error, rejected)
            return
        with storing(self._database, self._store) as put:
            data_sha256 = self._store.put_file(output)
            put.add(data_sha256)
            with self._database.write() as connection:
                kept = recordings.set_parsed(connection, recording.id, _parsed(answer, rejected, data_sha256))
        if not kept:
            collect(self._database, self._store, {data_sha256})

    def _request(self, recording: recordings.Recording, output: Path) -> ReadRequest:
        def named(role: recordings.FileRole) -> list[tuple[str, Path]]:
            return [(f.name, self._store.path(f.sha256)) for f in recording.files if f.role == role]

        site = [self._store.get_bytes(f.sha256) for f in recording.files if f.role == "site"]
        truth = named("truth")
        return ReadRequest(
            files=tuple(named("data")),
            site=site[0] if site else None,
            truth=truth[0] if truth else None,
            options=recording.options,
            max_rows=self._max_rows,
            output=output,
        )


def _stopping() -> StateError:
    """The state of the recording stays `parsing`, and the next server reads it."""
    return StateError("The server is stopping.", remedy="It reads the file when it is back.")


def _parsed(answer: ReadAnswer, rejected: list[recordings.Rejection], data_sha256: str) -> recordings.Parsed:
    return recordings.Parsed(
        kind=answer.kind,
        format=answer.format,
        rows_read=answer.rows_read,
        rows_accepted=answer.rows_accepted,
        time_first_s=answer.time_first_s,
        time_last_s=answer.time_last_s,
        start_utc=answer.start_utc,
        site=answer.site,
        has_truth=answer.has_truth,
        warnings=answer.warnings,
        rejections=rejected,
        data_sha256=data_sha256,
    )
