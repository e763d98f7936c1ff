"""Check a requested scenario completely, and say everything that is wrong with a pointer to each field."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from algorithms.errors import InputError
from algorithms.recording import Recording
from algorithms.spec import Parameters, Scenario
from backend.http.problems import ProblemError, ProblemItem, items_of, pointer_of, summary_of


def scenarios() -> Mapping[str, Scenario]:
    """Return the presets by name; the first call imports the families, which takes seconds."""
    from algorithms.registry import scenarios_by_name

    return scenarios_by_name()


def checked_scenario(
    preset: str, parameters: Mapping[str, Any], pointer: str = ""
) -> tuple[Scenario, Parameters, Recording]:
    """Return the preset, its complete parameters, and the recording without trials (instants and truth).

    Nothing random is drawn, so this takes milliseconds; a scenario that passes can be simulated.

    Parameters
    ----------
    preset, parameters : as requested
    pointer : JSON pointer of the object that holds `preset` and `parameters`

    Raises
    ------
    ProblemError
        422 with pointers: an unknown preset, values outside their bounds, a scenario that cannot be.
    """
    scenario = scenarios().get(preset)
    if scenario is None:
        detail = f"There is no scenario {preset!r}; there are {', '.join(scenarios())}."
        item = ProblemItem(pointer=f"{pointer}/preset", detail=detail, code="scenario_not_found")
        raise ProblemError(422, item.code, detail, errors=[item])
    try:
        # Strict: "10" is not 10 and true is not 1. Nothing is reinterpreted silently.
        given = scenario.parameters.model_validate_json(json.dumps(parameters), strict=True)
    except ValidationError as error:
        items = _items(scenario, error, f"{pointer}/parameters")
        raise ProblemError(422, "validation", summary_of(items), errors=items) from error
    try:
        return scenario, given, scenario.simulate(given, (), 0)
    except InputError as error:
        raise _impossible(error, pointer) from error


def _items(scenario: Scenario, error: ValidationError, pointer: str) -> list[ProblemItem]:
    items = items_of(error, pointer)
    for item, e in zip(items, error.errors(), strict=True):
        if e["type"] == "extra_forbidden" and len(e["loc"]) == 1:
            known = ", ".join(scenario.parameters.model_fields)
            item.detail = f"{scenario.name} has no parameter{pointer_of(e['loc']).replace('/', ' ')}; it has {known}."
    return items


def _impossible(error: InputError, pointer: str) -> ProblemError:
    item = ProblemItem(pointer=f"{pointer}/parameters{error.pointer}", detail=str(error), code=error.code)
    return ProblemError(422, item.code, summary_of([item]), errors=[item])
