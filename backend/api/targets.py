"""The targets of a recording, and the check that an address names one of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field

from backend.api import uploads
from backend.api.measurements import Measurements, of_recording
from backend.api.responses import problems
from backend.api.services import ServicesDep
from backend.http.problems import ProblemError, ProblemItem

router = APIRouter(prefix="/recordings/{recording_id}", tags=["recordings"])

TargetName = Annotated[str, Field(max_length=200)]


class TargetOut(BaseModel):
    """A target of a recording."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    name: str
    marks: int
    time_span_s: tuple[float, float]
    """Its first and last mark."""


class TargetList(BaseModel):
    """Targets in the order of their names; none where the recording does not tell its targets apart."""

    items: list[TargetOut]


class TargetsQuery(BaseModel):
    """Which targets."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    row: Annotated[int, Field(ge=1, le=10**12)] | None = None
    """Only the target of this row of the source."""


@router.get("/targets", name="list_targets", responses=problems(404, 409))
def list_targets(recording_id: str, services: ServicesDep, query: Annotated[TargetsQuery, Query()]) -> TargetList:
    """List the targets of a recording, or the one that a row is of."""
    recording = uploads.ready(services, recording_id)
    measurements = of_recording(services, recording)
    names, arrays = measurements.targets, measurements.arrays()
    target, time_s = np.asarray(arrays["target"]), np.asarray(arrays["time_s"])
    wanted = np.unique(target) if query.row is None else np.unique(target[np.asarray(arrays["row"]) == query.row])
    marks = np.bincount(target, minlength=len(names))
    first, last = np.full(len(names), np.inf), np.full(len(names), -np.inf)
    np.minimum.at(first, target, time_s)
    np.maximum.at(last, target, time_s)
    items = [
        TargetOut(name=names[i], marks=int(marks[i]), time_span_s=(float(first[i]), float(last[i])))
        for i in wanted.tolist()
        if names[i]
    ]
    return TargetList(items=sorted(items, key=lambda item: item.name))


def check_target(measured: Sequence[Measurements], target: str) -> None:
    """Refuse a target that none of these measurements has; the empty name means all targets.

    Raises
    ------
    ProblemError
        422 `unknown_target`.
    """
    if not target or any(target in one.targets for one in measured):
        return
    stored = [f"`GET /api/v1/recordings/{one.recording_id}/targets`" for one in measured[:2] if one.recording_id]
    known = list(dict.fromkeys(name for one in measured for name in one.targets if name))
    where = (
        f"{' or '.join(stored)} lists those that there are."
        if stored
        else f"There are {', '.join(known[:20])}."
        if known
        else "The scenario does not name its targets."
    )
    detail = f"There is no target {target!r} here; {where}"
    item = ProblemItem(pointer="/query/target", detail=detail, code="unknown_target")
    raise ProblemError(422, "unknown_target", detail, errors=[item])
