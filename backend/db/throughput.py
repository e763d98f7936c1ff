"""How fast earlier runs were: measured times of their entries, for the estimate of a new one."""

from __future__ import annotations

from dataclasses import dataclass
from statistics import median

from sqlalchemy import Connection, select

from backend.db.tables import run_algorithms, runs

# The newest runs that tell; older ones were made by older code, or on another machine.
_RUNS = 20


@dataclass(frozen=True)
class Throughput:
    """Medians over entries of one algorithm: seconds a row, and how many entries were measured."""

    seconds_per_row: float
    entries: int


def throughput(connection: Connection, algorithm: str, *, simulated: bool = False) -> Throughput | None:
    """Return what the newest finished runs of an algorithm took, None where none was measured.

    Runs on recordings and on simulated trials are told apart: trials side by side cost a fraction of single marks.
    """
    query = (
        select(runs.c.algorithms, runs.c.entries, runs.c.progress_total, runs.c.source)
        .join(run_algorithms, run_algorithms.c.run_id == runs.c.id)
        .where(run_algorithms.c.name == algorithm, runs.c.state == "succeeded")
        .order_by(runs.c.created_at.desc(), runs.c.id.desc())
        .limit(_RUNS)
    )
    measured: list[float] = []
    for algorithms, entries, total, source in connection.execute(query):
        if ("scenario" in source) != simulated:
            continue
        names = {a["label"]: a["name"] for a in algorithms}
        rows = total * source["instants"] if simulated else total / len(algorithms)
        measured += [
            e["seconds"] / (rows * e.get("variants", 1))
            for e in entries or ()
            if rows and names.get(e["label"]) == algorithm
        ]
    return Throughput(median(measured), len(measured)) if measured else None
