"""What is written about a run on its way, each step in one transaction.

A blob is stored and referred to under the store's guard, so a collection never takes it in between. Whoever comes
too late, because the run was cancelled or deleted meanwhile, changes nothing.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import FilterRoomError
from algorithms.recording import recording_from_arrays
from algorithms.result import LazyArrays
from backend.db import events, idempotency, outcomes, recordings, runs
from backend.db.engine import Database
from backend.db.ids import new_id, now
from backend.errors import StateError
from backend.files.joining import join_recordings
from backend.files.store import Store
from backend.jobs import results
from backend.jobs.collection import collect
from backend.jobs.outcome import Outcome, WrittenResult, block_arrays, outcome_of
from backend.jobs.plan import Plan, RecordingPlan, TrialsPlan
from backend.jobs.result_file import recording_arrays
from backend.jobs.work import AnyBlock, Block, TrialsBlock

if TYPE_CHECKING:
    from backend.jobs.gathering import Gathering

# How long idempotency keys and events that belong to no run are kept.
KEEP_KEYS = dt.timedelta(days=7)
KEEP_EVENTS = dt.timedelta(days=1)


def recover(database: Database, store: Store) -> None:
    """Take up what an earlier server left: queue its running runs again, delete what belongs to nothing."""
    with database.write() as connection:
        runs.requeue_running(connection)
        idempotency.forget_old_keys(connection, now() - KEEP_KEYS)
        events.forget_old_events(connection, now() - KEEP_EVENTS)
    store.clear_temporary()
    collect(database, store)


def begin(database: Database, run: runs.Run, plan: Plan, finished: int) -> runs.Run | None:
    """Make a queued run a running one; None where it was cancelled or deleted meanwhile."""
    with database.write() as connection:
        if not runs.start_run(connection, run.id):
            return None
        parts = "algorithms" if isinstance(plan, RecordingPlan) else "blocks"
        count = f"{finished} of {plan.size} {parts} are finished already"
        text = f"Goes on after a restart of the server: {count}." if run.started_at else "Started."
        events.append_log(connection, run.id, text)
        return runs.get_run(connection, run.id)


def block_of(
    database: Database, store: Store, run: runs.Run, plan: Plan, position: int, *, same_machine: bool = False
) -> AnyBlock:
    """Return the block at `position` of a run, with its recording or its trials.

    A worker on the same machine reads the recording from the store, and writes the result of a run's only algorithm
    beside it: sent, encrypted, written and hashed by the server, a long one would take twice as long.
    """
    token = f"{run.id}-{position}-{new_id()}"
    if isinstance(plan, TrialsPlan):
        return trials_block(plan, position, token=token, seed=run.seed)
    entry = run.algorithms[position]
    sources = _recordings_of(database, run)
    return Block(
        token=token,
        algorithm=entry.name,
        label=entry.label,
        parameters=entry.parameters,
        seed=run.seed,
        recordings=[
            (name, store.existing(sha256) if same_machine else store.get_contents(sha256)) for name, sha256 in sources
        ],
        output=store.temporary() if same_machine and plan.size == 1 else None,
    )


def _recordings_of(database: Database, run: runs.Run) -> list[tuple[str, str]]:
    """Name and blob of each recording of a run."""
    with database.read() as connection:
        found = [recordings.get_recording(connection, i) for i in runs.recording_ids_of(connection, run.id)]
    if any(one.data_sha256 is None for one in found):
        raise StateError("The recording has no data.", remedy="Upload it again.", code="recording_not_ready")
    return [(one.name, one.data_sha256) for one in found if one.data_sha256 is not None]


def trials_block(plan: TrialsPlan, position: int, *, token: str, seed: int) -> TrialsBlock:
    """Return the block at `position` of simulated trials."""
    cell, (first, stop) = plan.place_of(position)
    return TrialsBlock(
        token=token,
        label=plan.label_of(position),
        preset=plan.preset,
        scenario=cell.parameters,
        variants=tuple((v.algorithm, v.parameters) for v in plan.variants),
        seed=seed,
        first=first,
        stop=stop,
        keep_every=plan.keep_every,
        # Nobody looks at the first trial of another cell.
        example=position == 0,
    )


def keep(
    database: Database, store: Store, run: runs.Run, plan: Plan, position: int, outcome: Outcome
) -> Mapping[str, NDArray[Any]]:
    """Store a finished block, so that a restarted server need not compute it again, and return what was stored."""
    label = plan.name_of(position)
    arrays = block_arrays(outcome)
    if isinstance(plan, TrialsPlan):
        # As they come back from the disk: the order of a sum may follow that of the memory.
        arrays = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    with store.guard():
        sha256 = store.put_arrays(arrays)
        with database.write() as connection:
            outcomes.store_block(connection, run.id, position, sha256)
            for text, level in _log_of(label, outcome):
                events.append_log(connection, run.id, text, level)
    return arrays


def _log_of(label: str, outcome: Outcome) -> list[tuple[str, events.LogLevel]]:
    """Lines of the log about a finished block."""
    return [
        (f"{label}: finished in {outcome.seconds:.2f} s.", "info"),
        *((f"{label}: {note['detail']}", "warning") for note in outcome.notes),
    ]


def finish(
    database: Database,
    store: Store,
    run: runs.Run,
    plan: Plan,
    gathering: Gathering | None = None,
    last: tuple[int, Outcome] | None = None,
) -> None:
    """Put the stored blocks of a run together and make it succeeded; `gathering` has seen some of them already.

    `last` is the one algorithm that came back only now: it goes into the result without being stored for itself. If its
    worker has written the result file, that only moves into the store.
    """
    with database.read() as connection:
        blobs = outcomes.finished_blocks(connection, run.id)
    written = None if last is None else last[1].written
    if isinstance(plan, TrialsPlan):
        # Its statistics need scipy, for which no server waits at its start.
        from backend.jobs import trial_results
        from backend.jobs.gathering import Gathering

        gathering = gathering or Gathering(plan)
        for position in gathering.missing:
            gathering.add(position, store.get_arrays(blobs[position]))
        composed = trial_results.compose(gathering, run.source.get("study"))
    else:
        arrived = {} if last is None else {last[0]: last[1]}
        blocks = [arrived.get(p) or outcome_of(store.get_arrays(blobs[p])) for p in range(plan.size)]
        composed = results.compose([e.label for e in run.algorithms], blocks)
        sources = _recordings_of(database, run)
        if len(sources) > 1 and written is None:
            named = [(name, recording_from_arrays(store.get_arrays(sha256))) for name, sha256 in sources]
            joined = join_recordings(named).recording
            arrays = LazyArrays()
            arrays.add_all(composed.arrays)
            arrays.add_all(recording_arrays(joined.to_arrays()))
            composed = replace(composed, arrays=arrays)
    with _stored(store, composed.arrays, written) as sha256, database.write() as connection:
        if runs.finish_run(
            connection,
            run.id,
            result_sha256=sha256,
            summary=composed.summary,
            entries=composed.entries,
            software=composed.software,
        ):
            outcomes.store_tables(connection, run.id, composed.tables)
            outcomes.forget_blocks(connection, run.id)
            for text, level in [] if last is None else _log_of(plan.name_of(last[0]), last[1]):
                events.append_log(connection, run.id, text, level)
            events.append_log(connection, run.id, "Succeeded.")
    collect(database, store, {sha256, *blobs.values()})


@contextmanager
def _stored(store: Store, arrays: Mapping[str, NDArray[Any]], written: WrittenResult | None) -> Iterator[str]:
    """Put a result into the store, or take one in that is written, and give its hash to refer to."""
    if written is None:
        with store.guard():
            yield store.put_arrays(arrays)
    else:
        with store.adopted(written.path, written.sha256):
            yield written.sha256


def fail(database: Database, run_id: str, error: Mapping[str, Any], trace: str) -> None:
    """Make a live run failed; the trace goes to its log only."""
    with database.write() as connection:
        if runs.fail_run(connection, run_id, error):
            where = f"{error['label']}: " if error.get("label") else ""
            text = f"{where}{error['detail']} {error['remedy']}".strip()
            events.append_log(connection, run_id, f"{text}\n{trace}".strip(), "error")


def forget(database: Database, store: Store, run_id: str) -> None:
    """Delete the finished blocks of a run that will not be finished."""
    with database.write() as connection:
        blobs = set(outcomes.finished_blocks(connection, run_id).values())
        outcomes.forget_blocks(connection, run_id)
    if blobs:
        collect(database, store, blobs)


def error_of(error: FilterRoomError, label: str) -> dict[str, Any]:
    """Return an error of the server as the `error` of a run."""
    return {"code": error.code, "detail": error.message, "remedy": error.remedy, "label": label}
