"""The worker's entry point, without a worker."""

from __future__ import annotations

import errno
import io
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.errors import AlgorithmError, RecordingError
from algorithms.recording import ToaMarks
from algorithms.result import Result, Table
from algorithms.spec import Algorithm, Parameters, parameter
from backend.files import array_file
from backend.files.array_file import write_arrays
from backend.files.store import Store
from backend.jobs import results, work


class Gain(Parameters):
    gain: float = parameter(1.0, title="Gain", ge=0)


@pytest.fixture
def recording(tmp_path: Path) -> bytes:
    marks = ToaMarks(
        time_s=np.arange(3.0),
        row=np.arange(1, 4),
        target=np.zeros(3, np.int64),
        toa_s=np.zeros((3, 4, 1)),
        altitude_m=np.zeros((3, 1)),
        stations=("1", "2", "3", "4"),
    )
    write_arrays(tmp_path / "r.npz", marks.to_arrays())
    return (tmp_path / "r.npz").read_bytes()


@pytest.fixture
def run_with(monkeypatch: pytest.MonkeyPatch, recording: bytes, tmp_path: Path) -> Callable[..., work.Outcome]:
    """Run a block whose algorithm is the given function."""

    def run(
        function: Callable[..., Result],
        parameters: dict[str, Any] | None = None,
        token: str = "t",
        tables: dict[str, Table] | None = None,
        output: Path | None = None,
    ) -> work.Outcome:
        algorithm = Algorithm(
            "gain", "", "", "", ("toa_marks",), Gain, (), (), (), function, lambda *_: tables or {}, lambda *_: []
        )
        monkeypatch.setattr(work, "algorithms_by_name", lambda: {"gain": algorithm})
        recordings: list[Any] = [("", np.frombuffer(recording, np.uint8) if output is None else tmp_path / "r.npz")]
        block = work.Block(token, "gain", "label", parameters or {}, 7, recordings, output)
        return work.run_block(block, lambda share: None)

    return run


def test_a_block_is_done(run_with: Callable[..., work.Outcome]) -> None:
    outcome = run_with(lambda r, p, c: Result({"t": r.time_s * p.gain}), {"gain": 2.0})
    assert outcome.kind == "done"
    np.testing.assert_array_equal(outcome.arrays["t"], [0.0, 2.0, 4.0])


def test_a_worker_of_this_machine_writes_the_file_that_the_server_would(
    run_with: Callable[..., work.Outcome], tmp_path: Path
) -> None:
    tables = {
        "errors": Table({"row": np.arange(3), "target": ["a", None, "a"]}),
        "tracks": Table({"track": np.array([1.0])}),
    }

    def double(recording: ToaMarks, parameters: Gain, _c: object) -> Result:
        return Result({"t": recording.time_s * parameters.gain, "x": np.zeros((3, 2))})

    sent = run_with(double, {"gain": 2.0}, tables=tables)
    put = run_with(double, {"gain": 2.0}, tables=tables, output=tmp_path / "out")
    assert put.written is not None
    assert put.arrays == {}
    assert list(put.tables) == ["tracks"]
    store = Store(tmp_path / "store")
    sha256 = store.put_arrays(results.compose(["label"], [sent]).arrays)
    assert put.written.path.read_bytes() == store.get_bytes(sha256)
    assert put.written.sha256 == sha256
    composed = [results.compose(["label"], [replace(outcome, seconds=0.0)]) for outcome in (sent, put)]
    assert composed[0].entries == composed[1].entries
    assert composed[0].entries[0]["tables"] == {"errors": 3, "tracks": 1}
    assert composed[0].tables == composed[1].tables


def test_nothing_stays_of_a_result_that_was_not_finished(
    run_with: Callable[..., work.Outcome], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def cancelled(recording: ToaMarks, _p: object, _c: object) -> Result:
        work.cancel(["gone"])
        return Result({"t": recording.time_s})

    outcome = run_with(cancelled, token="gone", output=tmp_path / "out")
    assert outcome.kind == "cancelled"
    assert not (tmp_path / "out").exists()

    def refuse(*_: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(array_file, "_write_array", refuse)
    outcome = run_with(lambda r, _p, _c: Result({"t": r.time_s}), output=tmp_path / "out")
    assert outcome.error is not None
    assert outcome.error["code"] == "disk_full"
    assert not (tmp_path / "out").exists()


def test_streams_depend_on_seed_and_trial_only(run_with: Callable[..., work.Outcome]) -> None:
    def draw(_r: object, _p: object, context: work.BlockContext) -> Result:
        return Result({"x": context.random(3).standard_normal(2)})

    first, second = run_with(draw, token="a"), run_with(draw, token="b")
    np.testing.assert_array_equal(first.arrays["x"], second.arrays["x"])


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (
            AlgorithmError("Singular.", time_s=2.0, track=1, remedy="Add.", code="singular"),
            {"code": "singular", "detail": "Singular.", "remedy": "Add.", "label": "label", "time_s": 2.0, "track": 1},
        ),
        (
            RecordingError("No site.", pointer="/site", remedy="Give one."),
            {"code": "recording", "detail": "No site.", "remedy": "Give one.", "label": "label", "pointer": "/site"},
        ),
    ],
)
def test_known_errors_are_told(
    run_with: Callable[..., work.Outcome], error: Exception, expected: dict[str, Any]
) -> None:
    def fail(*_: object) -> Result:
        raise error

    outcome = run_with(fail)
    assert (outcome.kind, outcome.error, outcome.trace) == ("failed", expected, "")


@pytest.mark.parametrize(("error", "code"), [(MemoryError(), "out_of_memory"), (KeyError("x"), "internal")])
def test_other_errors_keep_their_trace_apart(
    run_with: Callable[..., work.Outcome], error: Exception, code: str
) -> None:
    def fail(*_: object) -> Result:
        raise error

    outcome = run_with(fail)
    assert outcome.error is not None
    assert outcome.error["code"] == code
    assert type(error).__name__ in outcome.trace
    assert "Traceback" not in str(outcome.error)


def test_parameters_are_checked_here_too(run_with: Callable[..., work.Outcome]) -> None:
    outcome = run_with(lambda *_: Result({}), {"gain": -1})
    assert outcome.error is not None
    assert outcome.error["pointer"] == "/parameters/gain"
    assert "greater than or equal to 0" in outcome.error["detail"]


def test_cancel_before_and_while_it_runs(run_with: Callable[..., work.Outcome]) -> None:
    def look(_r: object, _p: object, context: work.BlockContext) -> Result:
        work.cancel(["later"])
        context.check_cancelled()
        return Result({})

    work.cancel(["early"])
    assert run_with(look, token="early").kind == "cancelled"
    assert run_with(look, token="later").kind == "cancelled"
    assert run_with(lambda *_: Result({}), token="never").kind == "done"


def test_progress_is_throttled(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([10.0, 10.1, 10.24, 10.26, 10.3])
    monkeypatch.setattr(work.time, "monotonic", lambda: next(clock))
    seen: list[float] = []
    context = work.BlockContext("t", 0, seen.append)
    for share in (0.1, 0.2, 0.3, 0.4, 0.5):
        context.progress(share)
    assert seen == [0.1, 0.4]


def test_a_damaged_recording_is_an_internal_error(run_with: Callable[..., work.Outcome], recording: bytes) -> None:
    with zipfile.ZipFile(io.BytesIO(recording)) as archive:
        assert "meta.npy" in archive.namelist()
    block = work.Block("t", "gain", "label", {}, 0, [("", np.frombuffer(recording[: len(recording) // 2], np.uint8))])
    outcome = work.run_block(block, lambda share: None)
    assert outcome.kind == "failed"
