"""What a worker does: arrays and JSON in, arrays and JSON out. It touches no file and no database.

A worker must be able to say why it could not go on, so nothing is raised through Dask: an `Outcome` is done,
cancelled, or failed with an error that the user can act on. What does reach the engine as an exception is
the death of the worker itself.
"""

from __future__ import annotations

import io
import platform
import time
import traceback
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from algorithms.errors import AlgorithmError, FilterRoomError, InputError, ParameterError, RunCancelled
from algorithms.recording import recording_from_arrays
from algorithms.registry import algorithms_by_name
from algorithms.result import Metric, Table
from algorithms.spec import trial_stream

# Seconds between two reports of progress.
REPORT_S = 0.25

# Tokens of blocks that were cancelled. The worker's event loop adds to it while its only task looks into it.
_cancelled: set[str] = set()


@dataclass(frozen=True)
class Block:
    """One piece of a run: an algorithm on a recording (the bytes of its .npz)."""

    token: str
    algorithm: str
    label: str
    parameters: Mapping[str, Any]
    seed: int
    recording: bytes = field(repr=False)


@dataclass(frozen=True)
class Outcome:
    """What became of a block.

    `arrays` are the result's, `tables` by name; `settings` say which value of each parameter was used and
    where it came from; `error` is {"code", "detail", "remedy", "label", ...}; `trace` is for the run's log only.
    """

    kind: Literal["done", "failed", "cancelled"]
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    metrics: tuple[Metric, ...] = ()
    settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    notes: tuple[dict[str, Any], ...] = ()
    seconds: float = 0.0
    software: dict[str, str] = field(default_factory=dict)
    error: dict[str, Any] | None = None
    trace: str = ""


@dataclass
class BlockContext:
    """The surroundings of a running block (see `algorithms.spec.RunContext`)."""

    token: str
    seed: int
    report: Callable[[float], None]
    first_trial: int = 0
    _next_report: float = 0.0

    def random(self, lane: int) -> np.random.Generator:
        """Random stream of the trial in a lane; it depends on seed and trial only."""
        return trial_stream(self.seed, self.first_trial + lane)

    def progress(self, share: float) -> None:
        """Report the finished share, at most four times a second."""
        at = time.monotonic()
        if at >= self._next_report:
            self._next_report = at + REPORT_S
            self.report(share)

    def check_cancelled(self) -> None:
        """Raise RunCancelled where the user has cancelled."""
        if self.token in _cancelled:
            raise RunCancelled


def run_block(block: Block, report: Callable[[float], None]) -> Outcome:
    """Run the algorithm of a block and describe what came of it."""
    started = time.perf_counter()
    try:
        outcome = _compute(block, BlockContext(block.token, block.seed, report))
    except RunCancelled:
        _cancelled.discard(block.token)
        return Outcome("cancelled")
    except FilterRoomError as error:
        return Outcome("failed", error=_error(error, block.label))
    except MemoryError:
        return Outcome(
            "failed",
            error={
                "code": "out_of_memory",
                "detail": "The worker ran out of memory.",
                "remedy": "Use a shorter recording, or give the workers more memory.",
                "label": block.label,
            },
            trace=traceback.format_exc(),
        )
    except Exception:
        return Outcome(
            "failed",
            error={
                "code": "internal",
                "detail": "The algorithm stopped with an error that nobody foresaw.",
                "remedy": "The run's log holds what developers need to know; please report it.",
                "label": block.label,
            },
            trace=traceback.format_exc(),
        )
    return replace(outcome, seconds=round(time.perf_counter() - started, 3))


def run_on_worker(block: Block, topic: str) -> Outcome:
    """Run a block on a Dask worker; progress goes to `topic`."""
    from distributed import get_worker

    worker = get_worker()
    return run_block(block, lambda share: worker.log_event(topic, {"token": block.token, "share": share}))


def cancel(tokens: list[str]) -> None:
    """Mark blocks as cancelled in this worker."""
    _cancelled.update(tokens)


def warm_up() -> None:
    """Compile this worker's kernels, or load them from the cache."""
    from algorithms.warm_up import warm_up as compile_kernels

    compile_kernels()


def software() -> dict[str, str]:
    """Return the versions and the processor on which results depend."""
    import llvmlite.binding
    import numba

    try:
        own = version("filterroom")
    except PackageNotFoundError:
        own = "checkout"
    return {
        "filterroom": own,
        "numpy": np.__version__,
        "numba": numba.__version__,
        "python": platform.python_version(),
        "cpu": numba.config.CPU_NAME or llvmlite.binding.get_host_cpu_name(),
    }


def _compute(block: Block, context: BlockContext) -> Outcome:
    context.check_cancelled()
    algorithm = algorithms_by_name().get(block.algorithm)
    if algorithm is None:
        raise ParameterError(
            f"This worker knows no algorithm {block.algorithm!r}.",
            remedy="Install the same version and the same plugins on server and workers.",
            code="unknown_algorithm",
        )
    try:
        parameters = algorithm.parameters.model_validate(block.parameters)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        pointer = "/parameters/" + "/".join(str(step) for step in first["loc"])
        raise ParameterError(f"{pointer}: {first['msg']}.", pointer=pointer) from error
    with np.load(io.BytesIO(block.recording), allow_pickle=False) as arrays:
        recording = recording_from_arrays(arrays)
    result = algorithm.run(recording, parameters, context)
    context.check_cancelled()
    return Outcome(
        "done",
        arrays=dict(result.arrays),
        tables=algorithm.tabulate(recording, result),
        metrics=tuple(algorithm.measure(recording, result)),
        settings={name: asdict(setting) for name, setting in result.settings.items()},
        notes=tuple(asdict(note) for note in result.notes),
        software=software(),
    )


def _error(error: FilterRoomError, label: str) -> dict[str, Any]:
    out: dict[str, Any] = {
        "code": error.code,
        "detail": error.message,
        "remedy": error.remedy,
        "label": label,
    }
    if isinstance(error, InputError) and error.pointer:
        out["pointer"] = error.pointer
    if isinstance(error, AlgorithmError):
        out |= {"time_s": error.time_s, "track": error.track}
    return out
