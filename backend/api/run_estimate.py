"""What a run would take, before it is started: told from what earlier runs took, or not at all."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict

from backend.api.responses import problems
from backend.api.run_request import CheckedRun, checked
from backend.api.run_scenario import memory_bytes
from backend.api.run_schemas import RunIn
from backend.api.services import Services, ServicesDep
from backend.db import runs
from backend.db.throughput import throughput
from backend.http.problems import ProblemError, ProblemItem

router = APIRouter(prefix="/runs", tags=["runs"])


class EntryEstimateOut(BaseModel):
    """What one entry would take."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    label: str
    seconds: float | None
    """Null where no run of the algorithm has been measured yet."""
    measured: int
    """How many earlier entries the estimate is told from."""


class RunEstimateOut(BaseModel):
    """What a run would take if it were started now."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    seconds: float | None
    """From its start to its end, with all workers free; null where an algorithm has not been measured yet."""
    memory_bytes: int | None
    """What the workers hold at once: the recording once for each entry under way, or a batch of trials each."""
    queue_position: int
    """How many runs are queued or running before it."""
    basis: list[EntryEstimateOut]
    errors: list[ProblemItem] = []
    """Why it cannot start, where that was asked for with `check`; then nothing else is told."""


@router.post("/estimate", name="estimate_run", responses=problems(409, 413, 415))
def estimate_run(
    body: RunIn,
    services: ServicesDep,
    check: Annotated[
        bool, Query(description="Answer 200 with `errors` where a start would be refused with 422.")
    ] = False,
) -> RunEstimateOut:
    """Estimate a run from the rows per second of earlier ones; the body is that of a start, and nothing starts.

    A form asks with `check` while somebody types: what is wrong is then an answer like another, not a failure.
    """
    try:
        run = checked(services, body)
    except ProblemError as problem:
        if not check or not problem.errors:
            raise
        return RunEstimateOut(seconds=None, memory_bytes=None, queue_position=0, basis=[], errors=problem.errors)
    simulated = run.scenario is not None
    with services.database.read() as connection:
        measured = {e.name: throughput(connection, e.name, simulated=simulated) for e in run.entries}
        waiting = sum(runs.count_runs(connection, state) for state in runs.LIVE)
    rows = _rows(run)
    basis = [
        EntryEstimateOut(
            label=e.label,
            seconds=None if (found := measured[e.name]) is None else found.seconds_per_row * rows[e.label],
            measured=0 if found is None else found.entries,
        )
        for e in run.entries
    ]
    workers = _workers(services)
    return RunEstimateOut(
        seconds=_together([b.seconds for b in basis], workers),
        memory_bytes=_memory(services, run, workers),
        queue_position=waiting,
        basis=basis,
    )


def _rows(run: CheckedRun) -> dict[str, int]:
    """Rows that each label works through: of the recording, or instants times trials times cells and variants."""
    if run.scenario is None:
        return {e.label: run.rows for e in run.entries}
    once = run.scenario.instants * run.scenario.trials * len(run.scenario.plan.cells)
    variants = [v.label for v in run.scenario.plan.variants]
    return {e.label: once * variants.count(e.label) for e in run.entries}


def _memory(services: Services, run: CheckedRun, workers: int) -> int | None:
    if run.scenario is not None:
        return memory_bytes(run.scenario) * min(workers, run.scenario.plan.size)
    sizes = [None if one.data_sha256 is None else services.store.size(one.data_sha256) for one in run.recordings]
    known = [size for size in sizes if size is not None]
    # Several are held beside the one that they are joined to.
    copies = 1 if len(sizes) == 1 else 2
    return sum(known) * copies * min(workers, len(run.entries)) if len(known) == len(sizes) else None


def _workers(services: Services) -> int:
    # While they start there are none yet; then the setting says how many there will be.
    return services.engine.status().workers or services.settings.workers


def _together(seconds: list[float | None], workers: int) -> float | None:
    """Entries run side by side: neither faster than the longest nor than all of them shared out."""
    known = [s for s in seconds if s is not None]
    return max(max(known), sum(known) / workers) if known and len(known) == len(seconds) else None
