"""What a run would take, before it is started: told from what earlier runs took, or not at all."""

from __future__ import annotations

from fastapi import APIRouter
from pydantic import BaseModel, ConfigDict

from backend.api.responses import problems
from backend.api.run_request import checked
from backend.api.run_schemas import RunIn
from backend.api.services import Services, ServicesDep
from backend.db import runs
from backend.db.throughput import throughput

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
    """Measurements that the workers hold at once: the recording once for each entry under way."""
    queue_position: int
    """How many runs are queued or running before it."""
    basis: list[EntryEstimateOut]


@router.post("/estimate", name="estimate_run", responses=problems(409, 413, 415))
def estimate_run(body: RunIn, services: ServicesDep) -> RunEstimateOut:
    """Estimate a run from the rows per second of earlier ones; the body is that of a start, and nothing starts."""
    entries, recording = checked(services, body)
    with services.database.read() as connection:
        measured = {e.name: throughput(connection, e.name) for e in entries}
        waiting = sum(runs.count_runs(connection, state) for state in runs.LIVE)
    basis = [
        EntryEstimateOut(
            label=e.label,
            seconds=None if (found := measured[e.name]) is None else found.seconds_per_row * recording.rows_accepted,
            measured=0 if found is None else found.entries,
        )
        for e in entries
    ]
    workers = _workers(services)
    size = None if recording.data_sha256 is None else services.store.size(recording.data_sha256)
    return RunEstimateOut(
        seconds=_together([b.seconds for b in basis], workers),
        memory_bytes=None if size is None else size * min(workers, len(entries)),
        queue_position=waiting,
        basis=basis,
    )


def _workers(services: Services) -> int:
    # While they start there are none yet; then the setting says how many there will be.
    return services.engine.status().workers or services.settings.workers


def _together(seconds: list[float | None], workers: int) -> float | None:
    """Entries run side by side: neither faster than the longest nor than all of them shared out."""
    known = [s for s in seconds if s is not None]
    return max(max(known), sum(known) / workers) if known and len(known) == len(seconds) else None
