"""One suite over every registered scenario: what each must hold, whatever it simulates."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.errors import ParameterError
from algorithms.recording import Recording
from algorithms.references import REFERENCES
from algorithms.registry import scenarios_by_name
from algorithms.spec import Scenario

SCENARIOS = list(scenarios_by_name().values())

each_scenario = pytest.mark.parametrize("scenario", SCENARIOS, ids=lambda s: s.name)


def bytes_of(recording: Recording) -> dict[str, bytes]:
    return {name: array.tobytes() for name, array in recording.to_arrays().items()}


def measured(recording: Recording, lanes: int) -> dict[str, np.ndarray]:
    """Arrays with a trial axis."""
    truth = ("truth_m", "truth_velocity_mps")
    return {n: a for n, a in recording.to_arrays().items() if a.ndim > 1 and a.shape[-1] == lanes and n not in truth}


def scalars(scenario: Scenario) -> list[tuple[str, dict[str, Any]]]:
    """Return the numbers that a sweep can name, with the schema of their bounds."""
    found = []
    for name, field in scenario.parameters.schema_for_forms()["properties"].items():
        number = next((one for one in field.get("anyOf", [field]) if one.get("type") in ("number", "integer")), None)
        if number is not None:
            found.append((name, number))
    return found


@each_scenario
def test_declaration_is_complete(scenario: Scenario) -> None:
    assert scenario.title
    assert scenario.summary.endswith(".")
    assert all(r.key in REFERENCES for r in scenario.references)
    schema = scenario.parameters.schema_for_forms()
    assert schema["additionalProperties"] is False
    for name, field in schema["properties"].items():
        assert field.get("title"), name
        assert field.get("description"), name
        assert field.get("group"), name
        assert "default" in field, name
    for model, definition in schema.get("$defs", {}).items():
        for name, field in definition.get("properties", {}).items():
            assert field.get("title"), f"{model}.{name}"


@each_scenario
def test_the_default_is_of_its_kind_and_has_truth_and_site(scenario: Scenario) -> None:
    recording = scenario.simulate(scenario.parameters(), (0,), 1)
    assert recording.kind == scenario.kind
    assert recording.site is not None
    true = np.isfinite(recording.truth_m).all(axis=1)
    assert np.isfinite(recording.truth_velocity_mps[true]).all()
    # False plots have no truth; every target has, at each of its instants or at most of them.
    named = [i for i, name in enumerate(recording.targets) if name != "clutter"]
    assert all(true[recording.rows_of(i)].mean() > 0.5 for i in named)
    assert (np.diff(recording.time_s) >= 0).all()
    for leg in scenario.legs(scenario.parameters()):
        assert ((recording.time_s >= leg.start_s) & (recording.time_s < leg.stop_s)).any(), leg


@each_scenario
def test_a_trial_depends_on_the_seed_and_its_number_alone(scenario: Scenario) -> None:
    p = scenario.parameters()
    whole = scenario.simulate(p, tuple(range(17)), 5)
    parts = [scenario.simulate(p, cut, 5) for cut in (tuple(range(5)), tuple(range(5, 17)))]
    other = scenario.simulate(p, tuple(range(17)), 6)
    assert measured(whole, 17)
    for name, array in measured(whole, 17).items():
        joined = np.concatenate([part.to_arrays()[name] for part in parts], axis=-1)
        assert joined.tobytes() == array.tobytes(), name
    assert bytes_of(whole) == bytes_of(scenario.simulate(p, tuple(range(17)), 5))
    assert any(a.tobytes() != other.to_arrays()[n].tobytes() for n, a in measured(whole, 17).items())
    assert whole.truth_m.tobytes() == other.truth_m.tobytes(), "the truth belongs to the scenario"


@each_scenario
def test_no_trials_give_instants_and_truth(scenario: Scenario) -> None:
    """The cheap way to check a scenario completely before anything starts."""
    nothing = scenario.simulate(scenario.parameters(), (), 5)
    one = scenario.simulate(scenario.parameters(), (0,), 5)
    assert nothing.time_s.tobytes() == one.time_s.tobytes()
    assert nothing.truth_m.tobytes() == one.truth_m.tobytes()


@each_scenario
def test_the_ends_of_every_bound_work_or_say_why_not(scenario: Scenario) -> None:
    assert len(scalars(scenario)) > 5
    for name, bounds in scalars(scenario):
        least = bounds.get("minimum", bounds.get("exclusiveMinimum"))
        most = bounds.get("maximum", bounds.get("exclusiveMaximum"))
        assert least is not None, name
        assert most is not None, name
        low = math.nextafter(least, math.inf) if "exclusiveMinimum" in bounds else least
        for value in (low, most):
            refusal, recording = simulated(scenario, name, value)
            if refusal is not None:
                assert refusal.pointer, (name, value)
                assert refusal.remedy, (name, value)
            else:
                assert not any(np.isinf(a).any() for a in measured(recording, 1).values()), (name, value)


def simulated(scenario: Scenario, name: str, value: float) -> tuple[ParameterError | None, Recording]:
    try:
        return None, scenario.simulate(scenario.parameters(**{name: value}), (0,), 1)
    except ParameterError as error:
        return error, scenario.simulate(scenario.parameters(), (0,), 1)


@each_scenario
def test_every_text_has_russian_words(scenario: Scenario, repository: Path) -> None:
    texts = "".join(path.read_text("utf-8") for path in sorted((repository / "frontend" / "i18n").glob("ru*.js")))
    said = [scenario.title, scenario.summary]
    schema = scenario.parameters.schema_for_forms()
    for model in (schema, *schema.get("$defs", {}).values()):
        for field in model["properties"].values():
            said += [field["title"], field["description"], *field.get("choices", {}).values()]
            assert f'"group.{field["group"]}": ' in texts, field["title"]
    assert {text for text in (" ".join(t.split()) for t in said) if f"\n  {json.dumps(text)}: " not in texts} == set()


@each_scenario
def test_it_and_every_field_is_documented(scenario: Scenario, repository: Path) -> None:
    page = (repository / "docs" / "scenarios.md").read_text("utf-8")
    assert f"\n| `{scenario.name}` | " in page
    schema = scenario.parameters.schema_for_forms()
    assert [name for name in schema["properties"] if f"\n| `{name}` | " not in page] == []
    nested = {name for model in schema.get("$defs", {}).values() for name in model["properties"]}
    assert {name for name in nested if f"`{name}`" not in page} == set()
