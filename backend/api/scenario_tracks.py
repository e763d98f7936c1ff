"""From recorded tracks to a scenario: targets that fly what real aircraft flew, to be measured by any site."""

from __future__ import annotations

import json
from concurrent.futures import TimeoutError as StillReading
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Request
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from starlette.concurrency import run_in_threadpool

from algorithms.site import Origin
from algorithms.spec import Parameters, Scenario
from backend.api import uploads
from backend.api.recording_schemas import WarningOut
from backend.api.responses import problems
from backend.api.scenario_request import checked_scenario, scenarios
from backend.api.services import Services, ServicesDep
from backend.errors import StateError
from backend.files.options import ReadOptions
from backend.files.recorded_tracks import TrackChoice
from backend.http.multipart import Part, Parts, receive_form, received
from backend.http.problems import ProblemError, ProblemItem, items_of, summary_of
from backend.jobs.reader_process import ReadAnswer

router = APIRouter(prefix="/scenarios", tags=["scenarios"])

_PATIENCE_S = 50.0
_FIELDS = ("file", "options")
# What a preset says of its own targets and would be wrong of others.
_OF_OWN_TARGETS: dict[str, Any] = {"legs": [], "duration_s": None}


class TracksIn(BaseModel):
    """A preset whose targets are replaced, what differs from its defaults, and which tracks are meant."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    preset: Annotated[str, Field(max_length=80)]
    """Name of a preset that has targets with points."""
    parameters: dict[str, Any] = {}
    """Parameters that differ from the preset's defaults: the site, the accuracies, the origin."""
    tracks: TrackChoice = TrackChoice()
    """Which tracks become targets, and how closely they are followed."""
    reading: ReadOptions = ReadOptions()
    """How the file is read, as the truth of a recording would be: `truth_mapping`, `where`."""


class _Out(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class TrackOut(_Out):
    """What became of a track."""

    name: str
    reports: int
    """Reports it has in the file."""
    points: int
    """Points that the target follows; 0 where it could not become one."""
    first_s: float
    last_s: float
    left_out: dict[str, int]
    """Reports that could not be used, by reason: `unknown_place`, `same_time`, `jump`, `below_ground`."""
    problem: str
    """Why it did not become a target; empty where it did."""


class TracksOut(_Out):
    """A scenario, ready for `POST /scenarios/preview`, `POST /scenarios/recording` and `POST /runs`."""

    preset: str
    parameters: dict[str, Any]
    tracks: list[TrackOut]
    tracks_found: int
    """Tracks of the file within the time that was asked for."""
    start_utc: str | None
    """The instant from which the scenario's times count."""
    warnings: list[WarningOut]


FORM: dict[str, Any] = {
    "type": "object",
    "required": ["file", "options"],
    "additionalProperties": False,
    "properties": {
        "file": {
            "type": "string",
            "contentMediaType": "application/octet-stream",
            "description": "Tracks: OpenARIA CSV, NOP lines, ASTERIX with target reports, or a table of true paths.",
        },
        "options": {"type": "string", "description": "Preset, parameters and choice of tracks as JSON: see TracksIn."},
    },
}


@router.post(
    "/from-tracks",
    name="scenario_from_tracks",
    response_model=TracksOut,
    responses=problems(409, 413, 415, 507),
    openapi_extra={"requestBody": {"required": True, "content": {"multipart/form-data": {"schema": FORM}}}},
)
async def scenario_from_tracks(request: Request, services: ServicesDep) -> TracksOut:
    """Read a file of tracks and put them into a preset as its targets; nothing is stored or simulated."""
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if media_type != "multipart/form-data":
        detail = f"A body of type {media_type or 'unknown'!r} is not taken; send multipart/form-data."
        raise ProblemError(415, "unsupported_media_type", detail)
    with received() as parts:
        await receive_form(request, parts, services.store.temporary)
        return await run_in_threadpool(_made, services, parts)


def _made(services: Services, parts: Parts) -> TracksOut:
    file, asked = _form(services, parts)
    scenario = _preset(asked)
    answer = _read(services, file, asked)
    assert answer.tracks is not None
    given = {**{k: v for k, v in _OF_OWN_TARGETS.items() if k in scenario.parameters.model_fields}, **asked.parameters}
    tracks = answer.tracks["tracks"]
    origin, given = _origin(scenario, given, tracks)
    made = [_target(track, origin) for track in tracks]
    targets, shown = [target for target, _ in made], [out for _, out in made]
    try:
        checked_scenario(scenario.name, {**given, "targets": targets}, "/options")
    except ProblemError:
        # One of them may be at fault: each is tried alone, and those that cannot be flown are told.
        shown = [_tried(scenario, given, target, out) for target, out in made]
        targets = [target for target, out in zip(targets, shown, strict=True) if not out.problem]
        if not targets:
            detail = f"None of {len(tracks)} tracks can be a target; {shown[0].name}: {shown[0].problem}"
            item = ProblemItem(pointer="/file", detail=detail, code="no_tracks")
            raise ProblemError(422, item.code, detail, errors=[item]) from None
        checked_scenario(scenario.name, {**given, "targets": targets}, "/options")
    parameters = {**given, "targets": targets}
    return TracksOut(
        preset=scenario.name,
        parameters=parameters,
        tracks=shown,
        tracks_found=answer.tracks["found"],
        start_utc=answer.start_utc,
        warnings=[WarningOut(**w) for w in answer.warnings],
    )


def _form(services: Services, parts: Parts) -> tuple[Part, TracksIn]:
    wrong = [
        ProblemItem(
            pointer=f"/{p.name}",
            detail=f"There is no such field; fields are {', '.join(_FIELDS)}.",
            code="unknown_field",
        )
        for p in parts.items
        if p.name not in _FIELDS
    ]
    for name in _FIELDS:
        if not parts.named(name):
            wrong.append(ProblemItem(pointer=f"/{name}", detail="This field is missing.", code="missing"))
        elif len(parts.named(name)) > 1:
            wrong.append(ProblemItem(pointer=f"/{name}", detail="Give this field once.", code="repeated"))
    if wrong:
        raise ProblemError(422, "validation", summary_of(wrong), errors=wrong)
    (options,) = parts.named("options")
    if options.size > services.settings.max_json_bytes:
        item = ProblemItem(pointer="/options", detail="The options are too long.", code="too_large")
        raise ProblemError(413, "too_large", item.detail, errors=[item])
    try:
        return parts.named("file")[0], TypeAdapter(TracksIn).validate_json(options.path.read_bytes())
    except ValidationError as error:
        items = items_of(error, "/options")
        raise ProblemError(422, "validation", summary_of(items), errors=items) from error


def _preset(asked: TracksIn) -> Scenario:
    """Return the preset, whose targets can be replaced by points, after a look at the other parameters."""
    takers = [s.name for s in scenarios().values() if _takes_points(s.parameters)]
    scenario = scenarios().get(asked.preset)
    if scenario is not None and scenario.name not in takers:
        detail = f"{scenario.name} has no targets that follow points; these have: {', '.join(takers)}."
        item = ProblemItem(pointer="/options/preset", detail=detail, code="no_free_targets")
        raise ProblemError(422, item.code, detail, errors=[item])
    if "targets" in asked.parameters:
        detail = "The targets come from the file; leave them out."
        item = ProblemItem(pointer="/options/parameters/targets", detail=detail, code="parameter")
        raise ProblemError(422, item.code, detail, errors=[item])
    scenario, _, _ = checked_scenario(asked.preset, asked.parameters, "/options")
    return scenario


def _takes_points(model: type[Parameters]) -> bool:
    from algorithms.toolbox.scenario.targets import Target

    field = model.model_fields.get("targets")
    return field is not None and Target in getattr(field.annotation, "__args__", ())


def _read(services: Services, file: Part, asked: TracksIn) -> ReadAnswer:
    reading = services.engine.read_tracks(
        (file.file_name or file.name, file.path), asked.reading.model_dump(mode="json"), asked.tracks.model_dump()
    )
    try:
        answer = reading.result(timeout=_PATIENCE_S)
    except StillReading as error:
        reading.cancel()
        raise StateError(
            "The reader is busy with another file, or this one is too large for a look.",
            remedy="Try again in a moment, or give a part of it.",
            code="reader_busy",
        ) from error
    if answer.error is not None:
        raise uploads.unreadable(answer.error)
    return answer


def _origin(
    scenario: Scenario, given: dict[str, Any], tracks: list[dict[str, Any]]
) -> tuple[Origin | None, dict[str, Any]]:
    """Origin of the local frame: the given one, that of stations in WGS-84, else the middle of all points."""
    own = scenario.parameters.model_validate_json(json.dumps(given), strict=True)
    site = scenario.simulate(own, (), 0).site
    origin = None if site is None else site.frame_origin()
    geodetic = [np.array(t["place"]) for t in tracks if t["is_geodetic"]]
    if origin is not None or not geodetic:
        return origin, given
    middle = np.median(np.concatenate(geodetic), axis=0)
    origin = Origin(latitude_deg=round(float(middle[0]), 4), longitude_deg=round(float(middle[1]), 4))
    return origin, {**given, "origin": origin.model_dump()}


def _target(track: dict[str, Any], origin: Origin | None) -> tuple[dict[str, Any], TrackOut]:
    """One target of a scenario, and what it is made of."""
    from backend.files.truth_file import to_local

    time, place = np.array(track["time_s"]), np.array(track["place"])
    left_out = dict(track["left_out"])
    local = place
    if track["is_geodetic"]:
        assert origin is not None
        above = place[:, 2] >= 0
        if not above.all():
            left_out["below_ground"] = int((~above).sum())
        time, place = time[above], place[above]
        local = to_local(np.column_stack([np.radians(place[:, :2]), place[:, 2]]), origin)
    first_s, last_s = (round(float(time[i]), 3) if len(time) else 0.0 for i in (0, -1))
    height = "altitude_m" if track["is_geodetic"] else "up_m"
    points = [
        {
            "time_s": round(float(t - time[0]), 3),
            "east_m": round(float(east), 2),
            "north_m": round(float(north), 2),
            height: round(float(up), 2),
        }
        for t, (east, north, _), up in zip(time, local, place[:, 2], strict=True)
    ]
    out = TrackOut(
        name=track["name"], reports=track["reports"], points=len(points), first_s=first_s, last_s=last_s,
        left_out=left_out, problem="",
    )  # fmt: skip
    return {"name": track["name"][:80], "start_s": first_s, "points": points}, out


def _tried(scenario: Scenario, given: dict[str, Any], target: dict[str, Any], out: TrackOut) -> TrackOut:
    """Say why a track cannot be a target, where it cannot."""
    try:
        checked_scenario(scenario.name, {**given, "targets": [target]})
    except ProblemError as error:
        first = error.errors[0].detail if error.errors else error.detail
        return out.model_copy(update={"points": 0, "problem": first})
    return out
