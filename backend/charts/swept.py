"""What a swept name means: title and unit of the parameter that an algorithm or the scenario declares."""

from __future__ import annotations

from typing import Any

from algorithms.registry import algorithms_by_name, scenarios_by_name
from backend.charts.view import RunView

SCENARIO = "scenario"


def title_of(name: str, view: RunView) -> str:
    """Title of the axis of a swept name, `scenario.NAME` or `LABEL.NAME`: the parameter's own words and unit."""
    owner, _, parameter = name.rpartition(".")
    model = _model(owner, view)
    field = None if model is None else model.model_fields.get(parameter)
    if field is None or not field.title:
        return parameter.replace("_", " ")
    extra = field.json_schema_extra
    unit = str(extra.get("unit") or "") if isinstance(extra, dict) else ""
    return f"{field.title}, {unit}" if unit and unit != "1" else str(field.title)


def _model(owner: str, view: RunView) -> Any:
    if owner == SCENARIO:
        scenario = scenarios_by_name().get(view.scenario)
        return None if scenario is None else scenario.parameters
    named = [e.algorithm for e in view.entries if e.label == owner]
    algorithm = algorithms_by_name().get(named[0]) if named else None
    return None if algorithm is None else algorithm.parameters
