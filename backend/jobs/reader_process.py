"""Files are parsed in a process of their own: what a malformed file can do stays there.

The process is started when it is first needed and again whenever it died; it ends by itself when the server is
gone. It has a memory limit, and each reading a time limit.
"""

from __future__ import annotations

import contextlib
import errno
import multiprocessing
import os
import resource
import signal
import threading
import traceback
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any

from algorithms.errors import InputError

if TYPE_CHECKING:
    from backend.files.preview import Preview
    from backend.files.report import ReadReport

# Where the process may be after it was told to end, seconds.
_END_S = 5


@dataclass(frozen=True)
class ReadRequest:
    """What to read; the recording's arrays go to `output` (an .npz), or, without one, it is only looked at.

    Options and limits as JSON. With `tracks` (a `TrackChoice`) the one file holds paths and nothing else is read.
    """

    files: tuple[tuple[str, Path], ...]
    site: bytes | None
    truth: tuple[str, Path] | None
    options: Mapping[str, Any]
    max_rows: int
    output: Path | None
    tracks: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class ReadAnswer:
    """What reading gave: the facts of the recording, or an error {code, detail, remedy, pointer}."""

    error: Mapping[str, Any] | None = None
    trace: str = ""
    """Where an unforeseen error came from, for the server's log."""
    kind: str = ""
    format: str = ""
    rows_read: int = 0
    rows_accepted: int = 0
    time_first_s: float | None = None
    time_last_s: float | None = None
    start_utc: str | None = None
    site: Mapping[str, Any] | None = None
    has_truth: bool = False
    warnings: tuple[Mapping[str, Any], ...] = ()
    rejections: tuple[tuple[int, str, str, str], ...] = ()
    preview: Mapping[str, Any] | None = None
    """What a look showed: format, columns, rows, kind and mapping that are suggested, and the trial's error.

    The other fields then tell of the trial.
    """
    tracks: Mapping[str, Any] | None = None
    """Paths of a file: `tracks` (as `RecordedTrack.to_json`), how many were `found`; warnings as always."""


class ReaderProcess:
    """Reads one request at a time; for one thread."""

    def __init__(self, memory_bytes: int, timeout_s: float) -> None:
        self._memory_bytes = memory_bytes
        self._timeout_s = timeout_s
        self._process: multiprocessing.process.BaseProcess | None = None
        self._connection: Connection | None = None

    def start(self) -> None:
        """Start the process where there is none; it takes half a second to be ready."""
        self._started()

    def read(self, request: ReadRequest) -> ReadAnswer:
        """Read files; death and delay of the process become an answer with an error."""
        connection = self._started()
        try:
            connection.send(request)
            if connection.poll(self._timeout_s):
                answer: ReadAnswer = connection.recv()
                return answer
        except (EOFError, BrokenPipeError, ConnectionResetError):
            self.stop()
            return _failure(
                "reader_died",
                "The process that read the file ended without an answer.",
                "The file may be damaged, or too large for the memory; try a shorter one, or report it.",
            )
        self.stop()
        return _failure(
            "reader_timeout",
            f"Reading took longer than {self._timeout_s:g} s and was stopped.",
            "Split the file, or raise FILTERROOM_READER_TIMEOUT_S.",
        )

    def kill(self) -> None:
        """Kill the process from any thread; a reading under way then answers that it died."""
        if self._process is not None:
            self._process.kill()

    def stop(self) -> None:
        """End the process, whatever it is doing; the next reading starts a new one."""
        if self._connection is not None:
            self._connection.close()
        if self._process is not None:
            self._process.kill()
            self._process.join(_END_S)
        self._process = self._connection = None

    @property
    def pid(self) -> int | None:
        """Id of the process, None while there is none."""
        return None if self._process is None else self._process.pid

    def _started(self) -> Connection:
        if self._process is not None and self._connection is not None and self._process.is_alive():
            return self._connection
        self.stop()
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs, self._memory_bytes), name="filterroom-reader", daemon=True
        )
        self._process.start()
        theirs.close()
        self._connection = ours
        return ours


def _failure(code: str, detail: str, remedy: str, pointer: str = "/file") -> ReadAnswer:
    return ReadAnswer(error={"code": code, "detail": detail, "remedy": remedy, "pointer": pointer})


def _serve(connection: Connection, memory_bytes: int) -> None:
    """Answer requests until the server closes the connection or is gone."""
    # Ctrl-C in a terminal reaches the whole group; only the server decides when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()
    # Imported before the limit is set: it counts from here.
    from backend.files import preview, reading, store  # noqa: F401
    from backend.files.reader import readers_by_name

    readers_by_name()
    _limit_memory(memory_bytes)
    with contextlib.suppress(EOFError):
        while True:
            connection.send(_read(connection.recv()))


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None

    def wait() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def _limit_memory(memory_bytes: int) -> None:
    """Let the address space grow by this much, so that a bomb fails here and not the whole machine."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    limit = pages * resource.getpagesize() + memory_bytes
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    if hard != resource.RLIM_INFINITY:
        limit = min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (limit, hard))


def _read(request: ReadRequest) -> ReadAnswer:
    from backend.files.array_file import write_arrays
    from backend.files.preview import preview
    from backend.files.reading import NamedFile, ReadLimits, ReadOptions, read_recording
    from backend.files.store import refusal_of

    files = [NamedFile(name, path) for name, path in request.files]
    truth = None if request.truth is None else NamedFile(*request.truth)
    limits = ReadLimits(max_rows=request.max_rows)
    try:
        options = ReadOptions.model_validate(request.options)
        if request.tracks is not None:
            return _tracks(files[0], options, limits, request.tracks)
        if request.output is None:
            return _seen(preview(files, site=request.site, truth=truth, options=options, limits=limits))
        recording, report = read_recording(files, site=request.site, truth=truth, options=options, limits=limits)
        write_arrays(request.output, recording.to_arrays())
    except InputError as error:
        return _failure(error.code, error.message, error.remedy, error.pointer)
    except MemoryError:
        return _failure(
            "reader_memory",
            "The file needs more memory than one reading may take.",
            "Split it, or raise FILTERROOM_READER_MEMORY_BYTES.",
        )
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            return _unforeseen()
        refusal = refusal_of(error)
        return _failure(refusal.code, refusal.message, refusal.remedy, "")
    except Exception:
        return _unforeseen()
    return replace(
        _reported(report),
        start_utc=recording.start_utc,
        site=None if recording.site is None else recording.site.to_json(),
        has_truth=recording.has_truth,
    )


def _tracks(file: Any, options: Any, limits: Any, choice: Mapping[str, Any]) -> ReadAnswer:
    from backend.files.recorded_tracks import TrackChoice, read_tracks
    from backend.files.report import Findings

    findings = Findings(file.label)
    found = read_tracks(file, options, limits, TrackChoice.model_validate(choice), findings)
    tracks = {"tracks": [track.to_json() for track in found.tracks], "found": found.found}
    return ReadAnswer(tracks=tracks, start_utc=found.start_utc, warnings=tuple(asdict(w) for w in findings.warnings))


def _unforeseen() -> ReadAnswer:
    answer = _failure("internal", "The reader stopped with an error that nobody foresaw.", "Please report it.")
    return replace(answer, trace=traceback.format_exc())


def _reported(report: ReadReport) -> ReadAnswer:
    return ReadAnswer(
        kind=report.kind,
        format=report.format,
        rows_read=report.rows_read,
        rows_accepted=report.rows_accepted,
        time_first_s=report.time_span_s[0],
        time_last_s=report.time_span_s[1],
        warnings=tuple(asdict(w) for w in report.warnings),
        rejections=tuple((r.row, r.code, r.detail, r.file) for r in report.rejections),
    )


def _seen(found: Preview) -> ReadAnswer:
    answer = ReadAnswer() if found.report is None else _reported(found.report)
    error = found.error
    return replace(
        answer,
        preview={
            "format": found.format,
            "columns": found.columns,
            "rows": found.rows,
            "kind": found.suggestion.kind,
            "mapping": {n: s.model_dump(exclude_none=True) for n, s in found.suggestion.mapping.items()},
            "options": found.options,
            "error": None if error is None else _failure(error.code, error.message, error.remedy, error.pointer).error,
        },
    )
