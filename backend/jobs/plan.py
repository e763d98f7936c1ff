"""Into which blocks a run is cut: one for each algorithm on a recording, or one for each task of simulated trials.

A plan follows from what is stored of the run and from nothing else, so a restarted server goes on with the same blocks.
A sweep makes *cells* of the scenario (every combination of its swept values) and *variants* of an algorithm (every
combination of its own); one cell's variants see the same draws. The result names a variant by its label and values.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any

from algorithms.toolbox.monte_carlo.batches import BATCH, tasks
from backend.db.runs import Entry, Run

SCENARIO = "scenario"


@dataclass(frozen=True)
class Variant:
    """An algorithm with one combination of its swept values.

    `entry` is its place among the run's algorithms; `values` has every swept name of its own.
    """

    entry: int
    algorithm: str
    label: str
    parameters: Mapping[str, Any]
    values: Mapping[str, Any]


@dataclass(frozen=True)
class Cell:
    """One combination of the scenario's swept values, with its parameters."""

    index: int
    parameters: Mapping[str, Any]
    values: Mapping[str, Any]


@dataclass(frozen=True)
class RecordingPlan:
    """One block for each algorithm of a run on recordings."""

    labels: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of blocks."""
        return len(self.labels)

    def name_of(self, position: int) -> str:
        """What a block is called in the log."""
        return self.labels[position]

    def label_of(self, position: int) -> str:
        """Label of the algorithm that a block's error belongs to, empty where it belongs to several."""
        return self.labels[position]


@dataclass(frozen=True)
class TrialsPlan:
    """Blocks of trials: cell by cell, task by task."""

    preset: str
    cells: tuple[Cell, ...]
    variants: tuple[Variant, ...]
    tasks: tuple[tuple[int, int], ...]
    keep_every: int
    swept: tuple[str, ...]
    """All swept names, the scenario's first."""

    @property
    def size(self) -> int:
        """Number of blocks."""
        return len(self.cells) * len(self.tasks)

    def place_of(self, position: int) -> tuple[Cell, tuple[int, int]]:
        """Cell and trials of a block."""
        cell, task = divmod(position, len(self.tasks))
        return self.cells[cell], self.tasks[task]

    def positions_of(self, cell: int) -> range:
        """Blocks of a cell, in the order of the trials."""
        return range(cell * len(self.tasks), (cell + 1) * len(self.tasks))

    def name_of(self, position: int) -> str:
        """What a block is called in the log."""
        cell, (first, stop) = self.place_of(position)
        return f"Trials {first + 1} to {stop}{_words(cell.values)}"

    def label_of(self, position: int) -> str:
        """Blocks of trials belong to all labels."""
        return ""


Plan = RecordingPlan | TrialsPlan


def plan_of(run: Run) -> Plan:
    """Return the plan of a stored run."""
    if SCENARIO not in run.source:
        return RecordingPlan(tuple(entry.label for entry in run.algorithms))
    plan = trials_plan(
        run.source[SCENARIO],
        run.algorithms,
        run.source.get("sweep") or {},
        trials=run.trials,
        batches_per_task=run.source["batches_per_task"],
        keep_every=run.source["keep_every"],
    )
    if run.source.get("even_tasks"):
        return plan
    # Queued by an earlier version, whose last task was shorter: an unfinished run goes on with the same blocks.
    step = BATCH * run.source["batches_per_task"]
    return replace(plan, tasks=tuple((k, min(k + step, run.trials)) for k in range(0, run.trials, step)))


def trials_plan(
    scenario: Mapping[str, Any],
    entries: Sequence[Entry],
    sweep: Mapping[str, Sequence[Any]],
    *,
    trials: int,
    batches_per_task: int,
    keep_every: int,
) -> TrialsPlan:
    """Spread a sweep out into cells and variants, and the trials into tasks."""
    own = {name: values for name, values in sweep.items() if name.rpartition(".")[0] == SCENARIO}
    cells = tuple(
        Cell(k, {**scenario.get("parameters", {}), **_bare(values)}, values)
        for k, values in enumerate(_combinations(own))
    )
    variants = tuple(
        Variant(i, entry.name, entry.label, {**entry.parameters, **_bare(values)}, values)
        for i, entry in enumerate(entries)
        for values in _combinations({n: v for n, v in sweep.items() if n.rpartition(".")[0] == entry.label})
    )
    swept = (*own, *(name for name in sweep if name not in own))
    return TrialsPlan(scenario["preset"], cells, variants, tuple(tasks(trials, batches_per_task)), keep_every, swept)


def series_count(entries: Iterable[str], sweep: Mapping[str, Sequence[Any]]) -> int:
    """Return how many combinations of scenario cells and variants a sweep makes, without making them."""

    def combinations(owner: str) -> int:
        return prod(len(values) for name, values in sweep.items() if name.rpartition(".")[0] == owner)

    return combinations(SCENARIO) * sum(combinations(label) for label in entries)


def series_name(label: str, values: Mapping[str, Any]) -> str:
    """Name of one line of a swept run: `rdfv, sigma_altitude_m = 10`; the label alone where nothing is swept."""
    return f"{label}{_words(values)}"


def _words(values: Mapping[str, Any]) -> str:
    return "".join(f", {name.rpartition('.')[2]} = {value}" for name, value in values.items())


def _combinations(sweep: Mapping[str, Sequence[Any]]) -> list[dict[str, Any]]:
    return [dict(zip(sweep, values, strict=True)) for values in product(*sweep.values())]


def _bare(values: Mapping[str, Any]) -> dict[str, Any]:
    """Values by the parameter's own name."""
    return {name.rpartition(".")[2]: value for name, value in values.items()}
