"""What a run gives to other tools: Parquet, MATLAB, tracks for maps and globes, and a report that stands alone."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from fastapi import APIRouter, Query, Request, Response
from pydantic import BaseModel, ConfigDict
from starlette.background import BackgroundTask
from starlette.responses import FileResponse

from algorithms.errors import InputError
from algorithms.recording import Recording
from algorithms.result import Table
from algorithms.site import Origin
from backend.api import uploads
from backend.api.charts import TargetQuery
from backend.api.measurements import of_run
from backend.api.responses import Responses, content, problems
from backend.api.services import Services, ServicesDep
from backend.api.tables import finished, rows_of_table
from backend.api.targets import check_target
from backend.db import runs as stored
from backend.http.etag import etag_of, matches, not_modified
from backend.version import program_version

if TYPE_CHECKING:
    from backend.files.geo_tracks import GeoPlace, GeoTrack

router = APIRouter(prefix="/runs/{run_id}", tags=["results"])

PARQUET = "application/vnd.apache.parquet"
MATLAB = "application/x-matlab-data"
GEOJSON = "application/geo+json"
KML = "application/vnd.google-earth.kml+xml"
BYTES: dict[str, Any] = {"type": "string", "contentMediaType": "application/octet-stream"}


class NoQuery(BaseModel):
    """No query parameters."""

    model_config = ConfigDict(extra="forbid")


_TRACKS: Responses = problems(404, 409)


@router.get(
    "/tables/{table}.parquet",
    name="get_table_parquet",
    response_class=Response,
    responses=content(PARQUET, "The table as Parquet, null where something does not apply", BYTES) | problems(404, 409),
)
def get_table_parquet(
    run_id: str, table: str, request: Request, services: ServicesDep, query: Annotated[TargetQuery, Query()]
) -> Response:
    """Give a table, or its rows of one target, as Parquet."""
    run = finished(services, run_id)
    found = rows_of_table(services, run, None, table, query.target)

    def write(path: Path) -> None:
        from backend.files.parquet_writer import write_parquet

        write_parquet(found, path, about={"run_id": run.id, "table": table, "filterroom": program_version()})

    return sent(services, request, write, PARQUET, f"{table}-{run_id}.parquet", _version(run, table, query.target))


@router.get(
    "/result.mat",
    name="get_result_matlab",
    response_class=Response,
    responses=content(MATLAB, "MATLAB file: a struct per algorithm, `tables`, `labels`, `about`", BYTES)
    | problems(404, 409, 413),
)
def get_result_matlab(
    run_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give all arrays and tables of a run as a MATLAB file."""
    run = finished(services, run_id)

    def write(path: Path) -> None:
        from backend.files.matlab_writer import write_matlab

        write_matlab(_matlab_variables(services, run), path)

    return sent(services, request, write, MATLAB, f"run-{run_id}.mat", _version(run))


@router.get(
    "/tracks.geojson",
    name="get_tracks_geojson",
    response_class=Response,
    responses=content(GEOJSON, "GeoJSON (RFC 7946): tracks, true paths, stations", {"type": "object"}) | _TRACKS,
)
def get_tracks_geojson(
    run_id: str, request: Request, services: ServicesDep, query: Annotated[TargetQuery, Query()]
) -> Response:
    """Give the tracks as GeoJSON; 422 where the recording's frame has no place on the globe."""
    run = finished(services, run_id)
    known = _Located.of(services, run, query.target)
    states = rows_of_table(services, run, None, "states", query.target)

    def write(path: Path) -> None:
        from backend.files.geojson import write_geojson

        with path.open("w", encoding="utf-8") as out:
            write_geojson(known.tracks(states), known.places(), out, start_utc=known.recording.start_utc)

    return sent(services, request, write, GEOJSON, f"tracks-{run_id}.geojson", _version(run, query.target))


@router.get(
    "/tracks.kml",
    name="get_tracks_kml",
    response_class=Response,
    responses=content(KML, "KML with gx:Track, to be played in time") | _TRACKS,
)
def get_tracks_kml(
    run_id: str, request: Request, services: ServicesDep, query: Annotated[TargetQuery, Query()]
) -> Response:
    """Give the tracks as KML; 422 where the recording's frame has no place on the globe."""
    run = finished(services, run_id)
    known = _Located.of(services, run, query.target)
    states = rows_of_table(services, run, None, "states", query.target)

    def write(path: Path) -> None:
        from backend.files.kml import write_kml

        with path.open("w", encoding="utf-8") as out:
            write_kml(
                known.tracks(states),
                known.places(),
                out,
                name=run.label or known.name,
                labels=[e.label for e in run.algorithms],
                start_utc=known.recording.start_utc,
            )

    return sent(services, request, write, KML, f"tracks-{run_id}.kml", _version(run, run.label, query.target))


class _Located:
    """What a run worked on, in a frame that has an origin."""

    def __init__(self, name: str, recording: Recording, origin: Origin) -> None:
        self.name = name
        self.recording = recording
        self.origin = origin

    @classmethod
    def of(cls, services: Services, run: stored.Run, target: str) -> _Located:
        """Load it, or this target of it; raises InputError where the origin is not known."""
        from backend.charts.target import recording_of

        measured = of_run(services, run)
        check_target([measured], target)
        recording = measured.load()
        origin = recording.site.frame_origin() if recording.site is not None else None
        if origin is None and measured.recording_id is not None:
            given = uploads.ready(services, measured.recording_id).options.get("origin")
            origin = None if given is None else Origin.model_validate(given)
        if origin is None:
            raise InputError(
                f"The measurements of {measured.name!r} are in a local frame without a place on the globe.",
                pointer="/recording/site/origin",
                remedy="Give the site an origin, or read the recording again with the option origin.",
                code="origin_missing",
            )
        return cls(measured.name, recording_of(recording, target) if target else recording, origin)

    def tracks(self, states: Table) -> Iterator[GeoTrack]:
        """Yield true paths, then estimated tracks."""
        from backend.files.geo_tracks import estimated_tracks, true_tracks

        yield from true_tracks(self.recording, self.origin)
        yield from estimated_tracks(states, self.origin)

    def places(self) -> list[GeoPlace]:
        """Give the stations."""
        from backend.files.geo_tracks import places_of

        return places_of(self.recording.site, self.origin)


def _matlab_variables(services: Services, run: stored.Run) -> dict[str, Any]:
    from backend.files.matlab_writer import matlab_names, matlab_table
    from backend.jobs.results import load_entry_arrays, load_table, table_names

    labels = [e.label for e in run.algorithms]
    taken = ["about", "labels", "tables"]
    spelled = matlab_names([*taken, *labels])[len(taken) :]
    variables: dict[str, Any] = {
        "about": {
            "run_id": run.id,
            "label": run.label or "",
            "recording": str(run.source.get("name", "")),
            "software": json.dumps(run.software),
        },
        "labels": np.array([spelled, labels], object).T,
        "tables": {
            name: matlab_table(load_table(services.database, services.store, run, name))
            for name in table_names(services.database, run)
        },
    }
    for name, label in zip(spelled, labels, strict=True):
        variables[name] = load_entry_arrays(services.store, run, label)
    return variables


def _version(run: stored.Run, *more: str) -> tuple[str, ...]:
    return (program_version(), run.id, run.result_sha256 or "", *more)


def sent(
    services: Services,
    request: Request,
    write: Callable[[Path], None],
    media_type: str,
    file_name: str,
    version: tuple[str, ...],
    headers: dict[str, str] | None = None,
) -> Response:
    """Answer with a file that `write` makes, or that the client has it already; the file is gone once it is sent."""
    etag = etag_of(media_type, file_name, *version)
    if matches(request, etag):
        return not_modified(etag)
    path = services.store.temporary()
    try:
        write(path)
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    return FileResponse(
        path,
        media_type=media_type,
        filename=file_name,
        headers={"ETag": etag, "Cache-Control": "private, no-cache", **(headers or {})},
        background=BackgroundTask(path.unlink, missing_ok=True),
    )
