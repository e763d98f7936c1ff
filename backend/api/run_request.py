"""Check a requested run completely before it is queued, and say everything that is wrong at once."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import ValidationError

from algorithms.errors import InputError
from algorithms.spec import Algorithm
from backend.api.algorithms import catalogue
from backend.api.run_recordings import measurements_of, recordings_of, source_of
from backend.api.run_scenario import ScenarioRun, checked_scenario, misfit
from backend.api.run_schemas import EntryIn, RunIn, ScenarioIn
from backend.api.services import Services
from backend.api.studies import studies
from backend.db.recordings import Recording
from backend.db.runs import Entry
from backend.http.problems import ProblemError, ProblemItem, items_of, pointer_of, summary_of

# Kinds whose numbers mean nothing without the places of the stations.
_NEEDS_SITE = {"toa_marks": "stations", "doppler_pairs": "transmitters and receivers"}


@dataclass(frozen=True)
class CheckedRun:
    """A run that can start.

    `request` is what was asked for, a study spread out; `source` is what is stored of its origin.
    """

    request: RunIn
    entries: list[Entry]
    source: Mapping[str, Any]
    recordings: tuple[Recording, ...]
    scenario: ScenarioRun | None

    @property
    def recording_ids(self) -> list[str]:
        """The recordings it works on."""
        return [one.id for one in self.recordings]

    @property
    def rows(self) -> int:
        """Rows of all its recordings."""
        return sum(one.rows_accepted for one in self.recordings)

    @property
    def trials(self) -> int:
        """Simulated trials; a recording is one."""
        return self.scenario.trials if self.scenario is not None else 1

    @property
    def progress_total(self) -> int:
        """Work in the unit of a run's progress."""
        if self.scenario is not None:
            return self.scenario.progress_total
        return self.rows * len(self.entries)


def checked(services: Services, request: RunIn) -> CheckedRun:
    """Return a run that can start, or everything that is wrong with it."""
    study = request.study
    request = spread_out(request)
    _one_source(request)
    found = [] if request.scenario is not None else recordings_of(services, request)
    problems: list[ProblemItem] = []
    if not request.algorithms:
        problems.append(_item("/algorithms", "Name at least one algorithm.", "missing"))
    problems += _labels(request.algorithms)
    for i, entry in enumerate(request.algorithms):
        problems += _entry(f"/algorithms/{i}", entry, found)
    entries = [Entry(name=e.name, label=e.label or e.name, parameters=e.parameters) for e in request.algorithms]
    if found:
        problems += _of_recordings(request, found)
        if not problems:
            source = source_of(services, found)
            problems = _misfits(services, request.algorithms, found)
            if not problems:
                return CheckedRun(request, entries, source, tuple(found), None)
    else:
        scenario, more = checked_scenario(request, entries) if not problems else (None, [])
        problems += more
        if scenario is not None and not problems:
            about = {"study": study} if study is not None else {}
            return CheckedRun(request, entries, {**scenario.source, **about}, (), scenario)
    first = problems[0].code
    code = first if all(p.code == first for p in problems) and first in _OWN_CODES else "validation"
    raise ProblemError(422, code, summary_of(problems), errors=problems)


def _of_recordings(request: RunIn, found: Sequence[Recording]) -> list[ProblemItem]:
    """Say what cannot be asked of recordings, and what they lack."""
    problems = []
    if request.trials not in (None, 1):
        problems.append(_item("/trials", "A recording is one trial; leave this out.", "trials_of_a_recording"))
    if request.sweep is not None:
        detail = "A sweep needs a scenario; on a recording give one entry per value, each with its label."
        problems.append(_item("/sweep", detail, "sweep_of_a_recording"))
    for recording in found:
        needed = _NEEDS_SITE.get(recording.kind or "")
        if needed and recording.site is None:
            problems.append(
                _item(
                    "/site",
                    f"The recording {recording.name!r} has no site, and its measurements mean nothing without the "
                    f"places of the {needed}. Read it again with a `site` (POST /api/v1/recordings, "
                    "from_recording_id).",
                    "site_missing",
                )
            )
    return problems


def _misfits(services: Services, entries: Sequence[EntryIn], found: Sequence[Recording]) -> list[ProblemItem]:
    """Say which algorithms' parameters cannot go with what the recordings hold."""
    errors = [misfit(e.name, e.parameters, lambda: measurements_of(services, found)) for e in entries]
    return [
        _item(f"/algorithms/{i}/parameters{error.pointer}", str(error), error.code)
        for i, error in enumerate(errors)
        if error is not None
    ]


_OWN_CODES = (
    "site_missing", "kind_mismatch", "algorithm_not_found", "label_repeated", "trials_of_a_recording",
    "sweep_of_a_recording", "scenario_not_found", "sweep_too_large", "sweep_unknown", "sweep_repeated",
    "study_not_found", "study_is_whole", "no_monte_carlo", "scenario_too_long", "scenario_empty",
)  # fmt: skip


def _item(pointer: str, detail: str, code: str) -> ProblemItem:
    return ProblemItem(pointer=pointer, detail=detail, code=code)


def _fail(pointer: str, detail: str, code: str) -> ProblemError:
    return ProblemError(422, code, detail, errors=[_item(pointer, detail, code)])


def spread_out(request: RunIn) -> RunIn:
    """Return the run that a study is a recipe for; any other request as it is."""
    if request.study is None:
        return request
    for name in ("algorithms", "recording_id", "recording_ids", "scenario", "sweep"):
        if getattr(request, name):
            detail = f"A study brings its own algorithms, scenario and sweep: leave out `{name}`, or `study`."
            raise _fail(f"/{name}", detail, "study_is_whole")
    study = studies().get(request.study)
    if study is None:
        detail = f"There is no study {request.study!r}; there are {', '.join(studies())}."
        raise _fail("/study", detail, "study_not_found")
    return RunIn(
        algorithms=[EntryIn(name=e.name, label=e.label, parameters=dict(e.parameters)) for e in study.entries],
        scenario=ScenarioIn(preset=study.scenario, parameters=dict(study.scenario_parameters)),
        sweep={name: list(values) for name, values in study.sweep.items()} or None,
        trials=study.trials if request.trials is None else request.trials,
        seed=study.seed if request.seed is None else request.seed,
        label=request.label or study.title,
        tags=request.tags,
    )


def _one_source(request: RunIn) -> None:
    given = [name for name in ("recording_id", "recording_ids", "scenario") if getattr(request, name) is not None]
    if len(given) != 1:
        found = f"; there are {' and '.join(given)}" if given else ""
        detail = f"Give exactly one source: `recording_id`, `recording_ids` or `scenario`{found}."
        raise _fail(f"/{given[1]}" if given else "/recording_id", detail, "source_missing")


def _labels(entries: Sequence[EntryIn]) -> list[ProblemItem]:
    labels = [e.label or e.name for e in entries]
    return [
        _item(
            f"/algorithms/{i}/label",
            f"The label {label!r} is taken by entry {labels.index(label)}; give each entry its own.",
            "label_repeated",
        )
        for i, label in enumerate(labels)
        if labels.index(label) < i
    ]


def _entry(pointer: str, entry: EntryIn, found: Sequence[Recording]) -> list[ProblemItem]:
    algorithm = catalogue().get(entry.name)
    if algorithm is None:
        detail = f"There is no algorithm {entry.name!r}; there are {', '.join(catalogue())}."
        return [_item(f"{pointer}/name", detail, "algorithm_not_found")]
    unfit = next((one for one in found if one.kind not in algorithm.takes), None)
    if unfit is not None:
        detail = (
            f"{entry.name} takes {' or '.join(algorithm.takes)}, and this recording holds {unfit.kind}. "
            "Choose another algorithm or another recording."
        )
        return [_item(f"{pointer}/name", detail, "kind_mismatch")]
    return _parameters(f"{pointer}/parameters", algorithm, entry)


def _parameters(pointer: str, algorithm: Algorithm, entry: EntryIn) -> list[ProblemItem]:
    try:
        # Strict: "10" is not 10 and true is not 1. Nothing is reinterpreted silently.
        algorithm.parameters.model_validate_json(json.dumps(entry.parameters), strict=True)
    except ValidationError as error:
        items = items_of(error, pointer)
        known = algorithm.parameters.model_fields
        for item, e in zip(items, error.errors(), strict=True):
            if e["type"] == "extra_forbidden" and len(e["loc"]) == 1:
                item.detail = (
                    f"{algorithm.name} has no parameter{pointer_of(e['loc']).replace('/', ' ')}; "
                    f"it has {', '.join(known)}."
                )
        return items
    except InputError as error:
        return [_item(f"{pointer}{error.pointer}", str(error), error.code)]
    return []
