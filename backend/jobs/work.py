"""What a worker does: arrays and JSON in, arrays and JSON out. It touches no database, and no file but those that the
server names: on the server's own machine it reads the recording, and writes the result, where the server keeps them.

A worker must be able to say why it could not go on, so nothing is raised through Dask: an `Outcome` is done,
cancelled, or failed with an error that the user can act on. What does reach the engine as an exception is
the death of the worker itself.
"""

from __future__ import annotations

import platform
import time
import traceback
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from algorithms.errors import AlgorithmError, FilterRoomError, InputError, ParameterError, RunCancelled
from algorithms.recording import Recording, recording_from_arrays
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.spec import Algorithm, Parameters, trial_stream
from algorithms.toolbox.monte_carlo.batches import BATCH, batches
from algorithms.toolbox.monte_carlo.sums import Sums, joined, sums_of
from backend.files.array_file import MappedArrays, read_arrays
from backend.files.joining import join_recordings
from backend.jobs.outcome import Outcome, WrittenResult, block_arrays
from backend.jobs.result_file import ResultWriter, writing
from backend.jobs.worker_memory import keep_freed_memory, lift_limit

# Seconds between two reports of progress.
REPORT_S = 0.25
# Of a recording of more marks tables are made while metrics are computed.
LONG = 100_000

# Tokens of blocks that were cancelled. The worker's event loop adds to it while its only task looks into it.
_cancelled: set[str] = set()


@dataclass(frozen=True)
class Block:
    """One piece of a run: an algorithm on a recording, or on several as one.

    `recordings` are (name, bytes of its .npz as an array, or where they lie on this machine). Who computes the block
    takes them out as soon as they are read: a long recording would stand in the memory twice. `output` is where the
    result file is written to on this machine; empty: everything is sent.
    """

    token: str
    algorithm: str
    label: str
    parameters: Mapping[str, Any]
    seed: int
    recordings: list[tuple[str, NDArray[np.uint8] | Path]] = field(repr=False)
    output: Path | None = None


@dataclass(frozen=True)
class TrialsBlock:
    """One piece of a Monte Carlo run: some trials of one scenario cell, through all variants of the algorithms.

    `variants` are (algorithm, parameters); trials first <= i < stop are whole batches; of single values every
    `keep_every`-th instant is kept. With `example` the first trial comes along whole.
    """

    token: str
    label: str
    preset: str
    scenario: Mapping[str, Any]
    variants: tuple[tuple[str, Mapping[str, Any]], ...]
    seed: int
    first: int
    stop: int
    keep_every: int
    example: bool = False


AnyBlock = Block | TrialsBlock


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


def run_block(block: AnyBlock, report: Callable[[float], None]) -> Outcome:
    """Compute a block and describe what came of it."""
    started = time.perf_counter()
    # Compiled functions are imported where they are computed: the server, which only sends blocks, does without.
    from algorithms.warm_up import have_compiled

    context = BlockContext(block.token, block.seed, report, _next_report=time.monotonic() + REPORT_S)
    try:
        # Before anything is compiled here: a worker that did would give other last digits than one that loads.
        have_compiled()
        context.check_cancelled()
        outcome = _compute(block, context) if isinstance(block, Block) else _compute_trials(block, context)
        context.check_cancelled()
    except RunCancelled:
        _cancelled.discard(block.token)
        return Outcome("cancelled")
    except FilterRoomError as error:
        return Outcome("failed", error=_error(error, block.label))
    except MemoryError:
        lift_limit()
        return Outcome(
            "failed",
            error={
                "code": "out_of_memory",
                "detail": "The worker ran out of memory.",
                "remedy": "Use a shorter recording, fewer workers, or raise FILTERROOM_WORKER_MEMORY_BYTES.",
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


def run_on_worker(block: AnyBlock, topic: str) -> Outcome:
    """Run a block on a Dask worker; progress goes to `topic`."""
    from distributed import get_worker

    # Our own workers do so at their start; one that somebody else started does not know.
    keep_freed_memory()
    worker = get_worker()
    return run_block(block, lambda share: worker.log_event(topic, {"token": block.token, "share": share}))


def cancel(tokens: list[str]) -> None:
    """Mark blocks as cancelled in this worker."""
    _cancelled.update(tokens)


def warm_up() -> None:
    """Have the kernels compiled where they are not, and load them from the cache."""
    from algorithms.warm_up import have_compiled
    from algorithms.warm_up import warm_up as load

    have_compiled()
    load()


def fault_of_kernel_folder() -> str:
    """Say in words why this worker cannot keep compiled kernels; empty where it can."""
    from algorithms.warm_up import fault_of_folder

    return fault_of_folder()


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
    algorithm, parameters = _prepared(block.algorithm, block.parameters)
    read = [(name, recording_from_arrays(_arrays_at(place))) for name, place in block.recordings]
    block.recordings.clear()
    joined = join_recordings(read) if len(read) > 1 else None
    recording = read[0][1] if joined is None else joined.recording
    if block.output is None:
        outcome = _outcome(algorithm, recording, parameters, context)
    else:
        with writing(block.output, block.label) as out:
            outcome = _outcome(algorithm, recording, parameters, context, out)
            context.check_cancelled()
            small = out.add_tables(outcome.tables)
            if joined is not None:
                out.add_recording(recording.to_arrays())
            rows = {name: len(table) for name, table in outcome.tables.items()}
            written = WrittenResult(block.output, out.finish(), rows)
        outcome = replace(outcome, arrays={}, tables=small, written=written)
    if joined is None:
        return outcome
    return replace(outcome, notes=(*(asdict(note) for note in joined.notes), *outcome.notes))


def _arrays_at(place: NDArray[np.uint8] | Path) -> Mapping[str, NDArray[Any]]:
    return MappedArrays(place) if isinstance(place, Path) else read_arrays(place)


def _outcome(
    algorithm: Algorithm, recording: Recording, parameters: Any, context: BlockContext, out: ResultWriter | None = None
) -> Outcome:
    """Run, measure and tabulate; the arrays are written to `out` meanwhile, where there is one."""
    result = algorithm.run(recording, parameters, context)
    if out is not None:
        out.add_arrays(result.arrays)
    # Of a long recording both take as long as the filter; neither changes anything.
    with ThreadPoolExecutor(1, thread_name_prefix="tables") as beside:
        tabulated = beside.submit(algorithm.tabulate, recording, result) if len(recording) > LONG else None
        metrics = tuple(algorithm.measure(recording, result))
        tables = algorithm.tabulate(recording, result) if tabulated is None else tabulated.result()
    return Outcome(
        "done",
        arrays=dict(result.arrays),
        tables=tables,
        metrics=metrics,
        settings={name: asdict(setting) for name, setting in result.settings.items()},
        notes=tuple(asdict(note) for note in result.notes),
        software=software(),
    )


def _compute_trials(block: TrialsBlock, context: BlockContext) -> Outcome:
    """Simulate, filter and score batch by batch; what leaves is sums, and the first trial whole as an example."""
    scenario = scenarios_by_name().get(block.preset)
    if scenario is None:
        raise _unknown("scenario", block.preset)
    conditions = _validated(scenario.parameters, block.scenario, "/scenario/parameters")
    prepared = [_prepared(name, parameters) for name, parameters in block.variants]
    legs = scenario.legs(conditions)
    parts: list[list[Sums]] = [[] for _ in prepared]
    seconds = np.zeros(len(prepared))
    arrays: dict[str, Any] = {"seconds": seconds}
    todo = batches(block.first, block.stop)
    for done, (first, stop) in enumerate(todo):
        recording = scenario.simulate(conditions, tuple(range(first, stop)), block.seed)
        batch = replace(context, first_trial=first, report=lambda _: None)
        for k, (algorithm, parameters) in enumerate(prepared):
            context.check_cancelled()
            assert algorithm.score is not None, "runs on scenarios are checked before they are queued"
            began = time.perf_counter()
            scores = algorithm.score(recording, parameters, batch)
            parts[k].append(sums_of(scores, legs, block.keep_every, first // BATCH))
            seconds[k] += time.perf_counter() - began
            if first == 0 and algorithm.bound is not None:
                bound = algorithm.bound(recording, parameters)
                if bound is not None:
                    arrays[f"{k}/bound"] = bound
            context.progress((done + (k + 1) / len(prepared)) / len(todo))
    for k, sums in enumerate(parts):
        arrays |= {f"{k}/{name}": array for name, array in joined(sums).to_arrays().items()}
    if block.example:
        one = scenario.simulate(conditions, (0,), block.seed)
        for k, (algorithm, parameters) in enumerate(prepared):
            example = _outcome(algorithm, one, parameters, replace(context, report=lambda _: None))
            arrays |= {f"{k}/example/{name}": array for name, array in block_arrays(example).items()}
        arrays |= {f"recording/{name}": array for name, array in one.to_arrays().items()}
    return Outcome("done", arrays=arrays, software=software())


def _prepared(name: str, given: Mapping[str, Any]) -> tuple[Algorithm, Any]:
    """Return an algorithm with its checked parameters."""
    algorithm = algorithms_by_name().get(name)
    if algorithm is None:
        raise _unknown("algorithm", name)
    return algorithm, _validated(algorithm.parameters, given, "/parameters")


def _validated(model: type[Parameters], given: Mapping[str, Any], pointer: str) -> Any:
    try:
        return model.model_validate(given)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        pointer = "/".join([pointer, *(str(step) for step in first["loc"])])
        raise ParameterError(f"{pointer}: {first['msg']}.", pointer=pointer) from error


def _unknown(what: str, name: str) -> ParameterError:
    return ParameterError(
        f"This worker knows no {what} {name!r}.",
        remedy="Install the same version and the same plugins on server and workers.",
        code=f"unknown_{what}",
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
