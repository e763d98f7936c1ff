"""Scenarios: the presets, a look at one while it is edited, and a simulated recording to keep."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from algorithms.recording import Kind, Recording, ToaMarks
from algorithms.spec import Leg, Scenario
from backend.api import uploads
from backend.api.algorithms import ReferenceOut
from backend.api.recording_schemas import RecordingOut
from backend.api.recordings import shown_recording
from backend.api.responses import problems
from backend.api.scenario_request import checked_scenario, scenarios
from backend.api.services import ServicesDep
from backend.errors import NotFoundError
from backend.http.etag import conditional

router = APIRouter(prefix="/scenarios", tags=["scenarios"])


class _Model(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class ScenarioOut(_Model):
    """A preset of the catalogue."""

    name: str
    title: str
    summary: str
    family: str
    kind: Kind
    """Kind of the recordings that it makes."""
    parameters_schema: dict[str, Any]
    """JSON Schema with the preset's defaults, and with unit, symbol, group and choices of every parameter."""
    references: list[ReferenceOut]

    @classmethod
    def of(cls, scenario: Scenario) -> ScenarioOut:
        """Show a declared scenario."""
        return cls(
            name=scenario.name,
            title=scenario.title,
            summary=scenario.summary,
            family=scenario.family,
            kind=scenario.kind,
            parameters_schema=scenario.parameters.schema_for_forms(),
            references=[ReferenceOut.of(r) for r in scenario.references],
        )


class ScenarioList(_Model):
    """All presets."""

    items: list[ScenarioOut]


class ScenarioIn(BaseModel):
    """A preset, what differs from its defaults, and where the noise comes from."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    preset: Annotated[str, Field(max_length=80)]
    """Name of a preset."""
    parameters: dict[str, Any] = {}
    """Parameters that differ from the preset's defaults."""
    seed: Annotated[int, Field(ge=0, le=2**53 - 1)] = 0
    """Of the noise; the first trial of a run with this seed is the same recording."""


class PreviewIn(ScenarioIn):
    """What is to be looked at, and how closely."""

    points: Annotated[int, Field(ge=10, le=5000)] = 600
    """Most points of one curve."""


class RecordingIn(ScenarioIn):
    """What is to be simulated and stored."""

    name: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Name of the recording; default: preset and seed."""


class LegOut(_Model):
    """A leg, whose metrics are given apart, start_s <= t < stop_s."""

    name: str
    start_s: float
    stop_s: float

    @classmethod
    def of(cls, leg: Leg) -> LegOut:
        """Show a leg."""
        return cls(name=leg.name, start_s=leg.start_s, stop_s=leg.stop_s)


class ScenarioPreviewOut(_Model):
    """Trajectories, site and one noisy recording, as charts and numbers. `POST .../preview` answers with it."""

    rows: int
    """Measurements of all targets."""
    unheard: int
    """Of them without any measurement: nobody received them and no altitude was read."""
    complete_share: float | None
    """Share of marks that all stations received; null for other kinds."""
    time_span_s: tuple[float, float]
    targets: list[str]
    legs: list[LegOut]
    site: dict[str, Any]
    charts: dict[str, dict[str, Any]]
    """Plotly figures by name, those of a recording of this kind; numbers as base64 typed arrays."""


@router.get("", name="list_scenarios", response_model=ScenarioList, responses=problems())
def list_scenarios(request: Request) -> Response:
    """List all presets with their parameters."""
    found = ScenarioList(items=[ScenarioOut.of(s) for s in scenarios().values()])
    return conditional(request, found.model_dump_json().encode(), "application/json")


@router.get("/{name}", name="get_scenario", response_model=ScenarioOut, responses=problems(404))
def get_scenario(name: str, request: Request) -> Response:
    """Show one preset."""
    scenario = scenarios().get(name)
    if scenario is None:
        raise NotFoundError(
            f"There is no scenario {name!r}.", remedy=f"There are: {', '.join(scenarios())}.", code="scenario_not_found"
        )
    return conditional(request, ScenarioOut.of(scenario).model_dump_json().encode(), "application/json")


@router.post(
    "/preview",
    name="preview_scenario",
    response_class=Response,
    responses={200: {"model": ScenarioPreviewOut, "description": "What it looks like"}, **problems(413, 415)},
)
def preview_scenario(asked: PreviewIn) -> Response:
    """Simulate one recording and draw it; nothing is stored. Fast enough to follow typing."""
    from backend.charts.catalogue import charts_of_kind
    from backend.charts.figure import figure_json
    from backend.charts.view import ChartOptions, RecordingView

    scenario, parameters, _ = checked_scenario(asked.preset, asked.parameters)
    recording = scenario.simulate(parameters, (0,), asked.seed)
    assert recording.site is not None
    options = ChartOptions(points=asked.points)
    view = RecordingView(recording)
    # As arrays and not through a model: a figure's numbers are encoded once.
    shown = {
        "rows": len(recording),
        "unheard": int((~_measured(recording)).sum()),
        "complete_share": _complete_share(recording),
        "time_span_s": [float(recording.time_s[0]), float(recording.time_s[-1])],
        "targets": list(recording.targets),
        "legs": [LegOut.of(leg).model_dump() for leg in scenario.legs(parameters)],
        "site": recording.site.to_json(),
        "charts": {c.name: c.draw(view, options) for c in charts_of_kind("recording", recording.kind)},
    }
    return Response(figure_json(shown), media_type="application/json")


@router.post(
    "/recording",
    name="store_scenario_recording",
    status_code=201,
    response_model=RecordingOut,
    responses={
        200: {"model": RecordingOut, "description": "The same recording was stored before"},
        **problems(409, 413, 415, 507),
    },
)
def store_scenario_recording(asked: RecordingIn, response: Response, services: ServicesDep) -> RecordingOut:
    """Simulate one recording and store it, as if it had been uploaded in the native format with its site.

    Marks without any measurement are no rows of a file: they are left out, and their number stands in the preview.
    """
    scenario, parameters, _ = checked_scenario(asked.preset, asked.parameters)
    recording = scenario.simulate(parameters, (0,), asked.seed)
    name = asked.name or f"{asked.preset}, seed {asked.seed}"
    measured = np.flatnonzero(_measured(recording))
    stored = uploads.from_simulation(services, recording.take(measured), name)
    response.status_code = 201 if stored.is_new else 200
    response.headers["Location"] = f"/api/v1/recordings/{stored.recording.id}"
    return shown_recording(services, stored.recording.id)


def _measured(recording: Recording) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which rows hold a measurement at all. Arrays of measurements end with the trial axis, of length one here."""
    rows = len(recording)
    held = np.zeros(rows, bool)
    for array in recording.to_arrays().values():
        if array.ndim > 1 and array.shape[0] == rows and array.shape[-1] == 1:
            held |= np.isfinite(array.reshape(rows, -1)).any(axis=1)
    return held


def _complete_share(recording: Recording) -> float | None:
    if not isinstance(recording, ToaMarks):
        return None
    return float(np.isfinite(recording.toa_s[:, :, 0]).all(axis=1).mean())
