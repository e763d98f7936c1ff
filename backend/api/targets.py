"""The targets of a recording, and the check that an address names one of them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated

import numpy as np
from fastapi import APIRouter, Query
from pydantic import BaseModel, ConfigDict, Field

from backend.api import uploads
from backend.api.responses import problems
from backend.api.services import Services, ServicesDep
from backend.db.recordings import Recording
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
    assert recording.data_sha256 is not None
    names = target_names(services, recording)
    arrays = services.store.get_arrays(recording.data_sha256)
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


def target_names(services: Services, recording: Recording) -> tuple[str, ...]:
    """Return the names of a recording's targets without reading its marks."""
    assert recording.data_sha256 is not None
    meta = json.loads(bytes(services.store.get_arrays(recording.data_sha256)["meta"]).decode())
    return tuple(meta["targets"])


def check_target(services: Services, recordings: Sequence[Recording], target: str) -> None:
    """Refuse a target that none of these recordings has; the empty name means all targets.

    Raises
    ------
    ProblemError
        422 `unknown_target`.
    """
    if not target or any(target in target_names(services, recording) for recording in recordings):
        return
    where = " or ".join(f"`GET /api/v1/recordings/{recording.id}/targets`" for recording in recordings[:2])
    detail = f"There is no target {target!r} here; {where} lists those that there are."
    item = ProblemItem(pointer="/query/target", detail=detail, code="unknown_target")
    raise ProblemError(422, "unknown_target", detail, errors=[item])
