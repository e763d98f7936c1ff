"""Check a run on a scenario: preset, parameters, trials and sweep, each combination before anything starts."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from algorithms.errors import InputError
from algorithms.recording import Recording
from algorithms.spec import Algorithm, Scenario
from algorithms.toolbox.monte_carlo.batches import BATCH, batches_per_task
from backend.api.algorithms import catalogue
from backend.api.run_schemas import EntryIn, RunIn
from backend.db.runs import Entry
from backend.http.problems import ProblemItem, items_of
from backend.jobs.plan import SCENARIO, Cell, TrialsPlan, Variant, series_count, trials_plan

DEFAULT_TRIALS = 100
# Combinations of scenario cells and variants in one run.
MAX_SERIES = 500
# Instants of one trial: a batch of 64 trials of so many fits into a worker.
MAX_INSTANTS = 50_000
# Single values kept for quantiles and histograms, 4 bytes each.
MAX_SINGLE_VALUES = 6_000_000


@dataclass(frozen=True)
class ScenarioRun:
    """What is stored of a run on a scenario, and its plan."""

    source: Mapping[str, Any]
    trials: int
    plan: TrialsPlan
    instants: int

    @property
    def progress_total(self) -> int:
        """Trials times cells of the scenario."""
        return self.trials * len(self.plan.cells)


def scenarios() -> Mapping[str, Scenario]:
    """Return the presets by name."""
    from algorithms.registry import scenarios_by_name

    return scenarios_by_name()


def checked_scenario(request: RunIn, entries: Sequence[Entry]) -> tuple[ScenarioRun | None, list[ProblemItem]]:
    """Return the scenario of a run whose entries have been checked by themselves, or what is wrong with it."""
    assert request.scenario is not None
    preset = scenarios().get(request.scenario.preset)
    if preset is None:
        detail = f"There is no scenario {request.scenario.preset!r}; there are {', '.join(scenarios())}."
        return None, [ProblemItem(pointer="/scenario/preset", detail=detail, code="scenario_not_found")]
    problems = _takes(preset, request.algorithms)
    sweep = request.sweep or {}
    problems += _sweep_names(preset, request.algorithms, entries, sweep)
    count = series_count([e.label for e in entries], sweep)
    if count > MAX_SERIES:
        detail = f"The sweep has {count:,} combinations; one run may have {MAX_SERIES}. Nothing was started."
        problems.append(ProblemItem(pointer="/sweep", detail=detail, code="sweep_too_large"))
    if problems:
        return None, problems
    trials = request.trials or DEFAULT_TRIALS
    scenario = {"preset": preset.name, "parameters": request.scenario.parameters}
    plan = trials_plan(scenario, entries, sweep, trials=trials, batches_per_task=1, keep_every=1)
    problems = _variants(plan)
    instants, found = _instants(preset, plan, request.seed or 0, () if problems else plan.variants)
    problems += found
    if problems:
        return None, list({(p.pointer, p.detail): p for p in problems}.values())
    batches = batches_per_task(trials, instants, len(plan.variants), len(plan.cells))
    values = instants * trials * len(plan.variants) * len(plan.cells)
    keep_every = max(1, -(-values // MAX_SINGLE_VALUES))
    source = {
        SCENARIO: scenario,
        "name": preset.title,
        "kind": preset.kind,
        "sweep": sweep or None,
        "instants": instants,
        "batches_per_task": batches,
        "even_tasks": True,
        "keep_every": keep_every,
        "legs": [[leg.name, leg.start_s, leg.stop_s] for leg in preset.legs(_conditions(preset, plan.cells[0]))],
    }
    plan = trials_plan(scenario, entries, sweep, trials=trials, batches_per_task=batches, keep_every=keep_every)
    return ScenarioRun(source, trials, plan, instants), []


def _takes(preset: Scenario, entries: Sequence[EntryIn]) -> list[ProblemItem]:
    problems = []
    for i, entry in enumerate(entries):
        algorithm = catalogue().get(entry.name)
        if algorithm is None:
            continue
        if preset.kind not in algorithm.takes:
            detail = f"{entry.name} takes {' or '.join(algorithm.takes)}, and {preset.name} makes {preset.kind}."
            problems.append(ProblemItem(pointer=f"/algorithms/{i}/name", detail=detail, code="kind_mismatch"))
        elif algorithm.score is None:
            detail = f"{entry.name} works on recordings only: it does not say how its estimates are scored."
            problems.append(ProblemItem(pointer=f"/algorithms/{i}/name", detail=detail, code="no_monte_carlo"))
    return problems


def _sweep_names(
    preset: Scenario, given: Sequence[EntryIn], entries: Sequence[Entry], sweep: Mapping[str, Sequence[Any]]
) -> list[ProblemItem]:
    problems = []
    models = {SCENARIO: preset.parameters}
    for entry, entry_in in zip(entries, given, strict=True):
        algorithm: Algorithm | None = catalogue().get(entry_in.name)
        if algorithm is not None:
            models[entry.label] = algorithm.parameters
    for name, values in sweep.items():
        owner, _, parameter = name.rpartition(".")
        pointer = f"/sweep/{_escaped(name)}"
        if owner not in models:
            detail = f"{owner!r} is neither a label of this run nor `scenario`; there are {', '.join(models)}."
            problems.append(ProblemItem(pointer=pointer, detail=detail, code="sweep_unknown"))
        elif parameter not in models[owner].model_fields:
            known = ", ".join(models[owner].model_fields)
            detail = f"{owner} has no parameter {parameter!r}; it has {known}."
            problems.append(ProblemItem(pointer=pointer, detail=detail, code="sweep_unknown"))
        elif len({json.dumps(v, sort_keys=True) for v in values}) < len(values):
            problems.append(
                ProblemItem(pointer=pointer, detail="A value is given twice; leave it out.", code="sweep_repeated")
            )
    return problems


def _variants(plan: TrialsPlan) -> list[ProblemItem]:
    """Check every variant's parameters; what is wrong with a swept value is said of the sweep."""
    problems = []
    for variant in plan.variants:
        algorithm = catalogue()[variant.algorithm]
        pointer = f"/algorithms/{variant.entry}/parameters"
        problems += _invalid(algorithm.parameters, variant.parameters, pointer, variant.values)
    return problems


def _invalid(model: Any, given: Mapping[str, Any], pointer: str, swept: Mapping[str, Any]) -> list[ProblemItem]:
    try:
        model.model_validate_json(json.dumps(given), strict=True)
    except ValidationError as error:
        items = items_of(error, pointer)
        names = {name.rpartition(".")[2]: name for name in swept}
        for item, found in zip(items, error.errors(), strict=True):
            name = names.get(str(found["loc"][0])) if found["loc"] else None
            if name is not None:
                item.pointer = f"/sweep/{_escaped(name)}"
                item.detail = f"{swept[name]!r}: {item.detail}"
        return items
    return []


def _instants(
    preset: Scenario, plan: TrialsPlan, seed: int, variants: Sequence[Variant]
) -> tuple[int, list[ProblemItem]]:
    """Simulate the first trial of every cell: whatever leaves the domain is said before the start."""
    largest = 0
    problems: list[ProblemItem] = []
    for cell in plan.cells:
        found = _invalid(preset.parameters, cell.parameters, "/scenario/parameters", cell.values)
        problems += found
        if found:
            continue
        try:
            recording = preset.simulate(_conditions(preset, cell), (0,), seed)
        except InputError as error:
            pointer = f"/scenario/parameters{error.pointer or ''}"
            detail = f"{error.message}. {error.remedy}".replace("..", ".").strip()
            for name, value in cell.values.items():
                if error.pointer == f"/{name.rpartition('.')[2]}":
                    pointer, detail = f"/sweep/{_escaped(name)}", f"{value!r}: {detail}"
            problems.append(ProblemItem(pointer=pointer, detail=detail, code=error.code))
            continue
        instants = len(recording)
        largest = max(largest, instants)
        problems += _misfits(variants, recording)
        if instants > MAX_INSTANTS:
            detail = (
                f"The scenario has {instants:,} instants; Monte Carlo runs take up to {MAX_INSTANTS:,}. Shorten it, or "
                "store one simulated recording and run the algorithms on that."
            )
            problems.append(ProblemItem(pointer="/scenario/parameters", detail=detail, code="scenario_too_long"))
        elif instants == 0:
            detail = "The scenario has no measurement at all; lengthen it or shorten the period."
            problems.append(ProblemItem(pointer="/scenario/parameters", detail=detail, code="scenario_empty"))
    return largest, problems


def misfit(name: str, given: Mapping[str, Any], get: Callable[[], Recording]) -> InputError | None:
    """Say why an algorithm's parameters, valid by themselves, cannot go with a recording."""
    algorithm = catalogue()[name]
    if algorithm.check is not None:
        try:
            algorithm.check(algorithm.parameters.model_validate_json(json.dumps(given), strict=True), get)
        except InputError as error:
            return error
    return None


def _misfits(variants: Sequence[Variant], recording: Recording) -> list[ProblemItem]:
    """Say which variants cannot go with what a cell simulates; of a swept value it is said of the sweep."""
    problems = []
    for variant in variants:
        error = misfit(variant.algorithm, variant.parameters, lambda: recording)
        if error is None:
            continue
        pointer, detail = f"/algorithms/{variant.entry}/parameters{error.pointer}", str(error)
        for name, value in variant.values.items():
            if error.pointer.startswith(f"/{name.rpartition('.')[2]}"):
                pointer, detail = f"/sweep/{_escaped(name)}", f"{value!r}: {detail}"
        problems.append(ProblemItem(pointer=pointer, detail=detail, code=error.code))
    return problems


def _conditions(preset: Scenario, cell: Cell) -> Any:
    return preset.parameters.model_validate_json(json.dumps(cell.parameters), strict=True)


def _escaped(name: str) -> str:
    """Name as a step of a JSON pointer (RFC 6901)."""
    return name.replace("~", "~0").replace("/", "~1")


def memory_bytes(run: ScenarioRun) -> int:
    """Estimate what one worker holds at once: a batch's states, covariances and scores (60 numbers an instant)."""
    return run.instants * min(run.trials, BATCH) * 60 * 8
