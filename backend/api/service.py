"""The service itself: versions, limits, state of the engine; whether the server lives and can work."""

from __future__ import annotations

import datetime as dt
from typing import Literal

from fastapi import APIRouter, Response
from pydantic import BaseModel, ConfigDict

from backend.api.responses import problems
from backend.api.services import Services, ServicesDep
from backend.db.runs import count_runs
from backend.version import library_versions, plotly_js_version, program_version

router = APIRouter(tags=["service"])
health = APIRouter(tags=["service"])


class EngineOut(BaseModel):
    """What the engine is doing."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    state: Literal["starting", "warming_up", "ready", "failed", "stopped"]
    workers: int
    running: int
    queued: int
    detail: str
    """What the state does not say."""
    warning: str
    """What is amiss though runs are computed, and what to do; empty where all is well."""


class Limits(BaseModel):
    """Limits of the settings."""

    max_upload_bytes: int
    max_json_bytes: int
    max_rows: int


class Meta(BaseModel):
    """About this server."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    name: str
    version: str
    licence: str
    plotly_js: str
    """Version of plotly.js, which is part of the address of its file."""
    versions: dict[str, str]
    """Python and the main libraries."""
    limits: Limits
    engine: EngineOut
    disk_free_bytes: int
    started_at: dt.datetime


class Health(BaseModel):
    """That the server answers."""

    status: Literal["ok"]


class Readiness(BaseModel):
    """Whether the server can take runs."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    status: Literal["ready", "not_ready"]
    detail: str
    """Why not, or what is amiss nevertheless."""


@router.get("/meta", name="get_meta", responses=problems())
def get_meta(services: ServicesDep) -> Meta:
    """Tell versions, limits and what the engine is doing."""
    settings = services.settings
    status = services.engine.status()
    return Meta(
        name="Filter Room",
        version=program_version(),
        licence="MIT",
        plotly_js=plotly_js_version(),
        versions=library_versions(),
        limits=Limits(
            max_upload_bytes=settings.max_upload_bytes,
            max_json_bytes=settings.max_json_bytes,
            max_rows=settings.max_rows,
        ),
        engine=EngineOut(
            state=status.state,
            workers=status.workers,
            running=status.running,
            queued=status.queued,
            detail=status.detail,
            warning=status.warning,
        ),
        disk_free_bytes=services.store.free_bytes(),
        started_at=services.started_at,
    )


@health.get("/healthz", name="get_health")
async def get_health() -> Health:
    """Say that the server lives; needs no token and touches nothing."""
    return Health(status="ok")


@health.get(
    "/readyz",
    name="get_readiness",
    responses={503: {"model": Readiness, "description": "The database or the workers are not there"}},
)
def get_readiness(services: ServicesDep, response: Response) -> Readiness:
    """Say whether database and workers are there; needs no token."""
    detail = _missing(services)
    if detail:
        response.status_code = 503
        return Readiness(status="not_ready", detail=detail)
    return Readiness(status="ready", detail=services.engine.status().warning)


def _missing(services: Services) -> str:
    with services.database.read() as connection:
        count_runs(connection, "queued")
    engine = services.engine.status()
    # While kernels are compiled, runs are taken and wait a little.
    if engine.state in ("ready", "warming_up"):
        return "" if engine.workers else engine.detail
    return "The workers are starting." if engine.state == "starting" else engine.detail or "There are no workers."
