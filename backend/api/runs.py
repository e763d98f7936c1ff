"""Runs: start, list, look at, rename, cancel, delete, log."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from pydantic_core import to_json

from backend.api.algorithms import references_of
from backend.api.responses import content, problems
from backend.api.run_request import checked
from backend.api.run_schemas import RunIn, RunOut, RunPage, RunPatch, RunQuery, TagItem, TagList, listed
from backend.api.services import Services, ServicesDep
from backend.db import events, idempotency
from backend.db import runs as stored
from backend.db.ids import now
from backend.http.etag import etag_of, matches, not_modified
from backend.http.idempotency import IdempotencyKeyHeader, body_digest, key_reused
from backend.http.pagination import cut
from backend.jobs.collection import collect

router = APIRouter(prefix="/runs", tags=["runs"])
tags_router = APIRouter(prefix="/tags", tags=["runs"])


@router.post("", name="create_run", status_code=202, responses=problems(409, 413, 415, 507))
def create_run(
    body: RunIn,
    response: Response,
    services: ServicesDep,
    key: IdempotencyKeyHeader = None,
) -> RunOut:
    """Queue a run; the answer comes at once, poll `Location` or listen to its events."""
    digest = body_digest("/api/v1/runs", body.model_dump_json(exclude_unset=True).encode())
    if key is not None:
        # Before everything else: the recording may be gone by now, the first answer stands.
        with services.database.read() as connection:
            earlier = idempotency.find_key(connection, key)
        if earlier is not None:
            return _repeated(services, response, earlier, digest)
    run = queue_run(services, body, key=key, digest=digest)
    if isinstance(run, idempotency.IdempotencyKey):
        return _repeated(services, response, run, digest)
    return _accepted(services, response, run)


def queue_run(
    services: Services, body: RunIn, *, key: str | None = None, digest: str = ""
) -> stored.Run | idempotency.IdempotencyKey:
    """Check and queue a run; return the key instead where another request was faster with it."""
    run_in = checked(services, body)
    with services.database.write() as connection:
        if key is not None:
            earlier = idempotency.find_key(connection, key)
            if earlier is not None:
                return earlier
        run = stored.create_run(
            connection,
            algorithms=run_in.entries,
            source=run_in.source,
            recording_ids=run_in.recording_ids,
            label=run_in.request.label,
            tags=body.tags,
            seed=run_in.request.seed or 0,
            trials=run_in.trials,
            progress_total=run_in.progress_total,
        )
        if key is not None:
            idempotency.remember_key(connection, key, digest, f"/api/v1/runs/{run.id}")
    services.engine.notify()
    return run


def _repeated(services: Services, response: Response, earlier: idempotency.IdempotencyKey, digest: str) -> RunOut:
    if earlier.body_sha256 != digest:
        raise key_reused()
    with services.database.read() as connection:
        run = stored.get_run(connection, earlier.location.rsplit("/", 1)[-1])
    return _accepted(services, response, run)


def _accepted(services: Services, response: Response, run: stored.Run) -> RunOut:
    response.headers["Location"] = f"/api/v1/runs/{run.id}"
    response.headers["Retry-After"] = "1"
    return _shown(services, run.id)


@router.get("", name="list_runs", response_model=RunPage, responses=problems())
def list_runs(
    request: Request, response: Response, services: ServicesDep, query: Annotated[RunQuery, Query()]
) -> Response:
    """List runs, newest first."""
    with services.database.read() as connection:
        rows = stored.list_runs(
            connection,
            query.only(),
            limit=query.limit + 1,
            after=query.position(),
            oldest_first=query.order == "created_at",
        )
    rows, cursor = cut(query, rows, request, response)
    at = now()
    items = [listed(r, at=at, size_bytes=_size(services, r)) for r in rows]
    content = to_json({"items": items, "next_cursor": cursor})
    return Response(content, media_type="application/json", headers=dict(response.headers))


@tags_router.get("", name="list_tags", responses=problems())
def list_tags(services: ServicesDep) -> TagList:
    """List the tags of all runs."""
    with services.database.read() as connection:
        return TagList(items=[TagItem(tag=tag, runs=count) for tag, count in stored.list_tags(connection)])


@router.get("/{run_id}", name="get_run", response_model=RunOut, responses=problems(404))
def get_run(run_id: str, request: Request, services: ServicesDep) -> Response:
    """Show a run: state, progress, headline."""
    shown = _shown(services, run_id)
    # The estimate of the time to go changes with every look; it alone is no news.
    etag = etag_of(shown.model_dump_json(exclude={"progress": {"eta_s"}}))
    if matches(request, etag):
        return not_modified(etag)
    return Response(shown.model_dump_json(), media_type="application/json", headers={"ETag": etag})


@router.patch("/{run_id}", name="update_run", responses=problems(404, 413, 415))
def update_run(run_id: str, body: RunPatch, services: ServicesDep) -> RunOut:
    """Give a run another label or other tags."""
    with services.database.write() as connection:
        stored.rename_run(connection, run_id, label=body.label, tags=body.tags)
    return _shown(services, run_id)


@router.post(
    "/{run_id}/cancel",
    name="cancel_run",
    status_code=202,
    responses={200: {"model": RunOut, "description": "It is cancelled already"}, **problems(404, 409)},
)
def cancel_run(run_id: str, response: Response, services: ServicesDep) -> RunOut:
    """Cancel a run that is queued or running."""
    if not services.engine.cancel(run_id):
        response.status_code = 200
    return _shown(services, run_id)


@router.delete("/{run_id}", name="delete_run", status_code=204, responses=problems(404, 409))
def delete_run(run_id: str, services: ServicesDep) -> None:
    """Delete a finished run and its result."""
    with services.database.write() as connection:
        gone = stored.delete_run(connection, run_id)
    collect(services.database, services.store, gone)


@router.get(
    "/{run_id}/log",
    name="get_run_log",
    response_class=Response,
    responses=content("text/plain", "Lines of time, level, text") | problems(404),
)
def get_run_log(run_id: str, services: ServicesDep) -> Response:
    """Give the log of a run as text."""
    with services.database.read() as connection:
        stored.get_run(connection, run_id)
        lines = events.log_lines(connection, run_id)
    text = "".join(
        f"{line.at.isoformat(timespec='milliseconds').replace('+00:00', 'Z')} {line.level:<7} {line.text}\n"
        for line in lines
    )
    return Response(text, media_type="text/plain; charset=utf-8")


def _shown(services: Services, run_id: str) -> RunOut:
    with services.database.read() as connection:
        run = stored.get_run(connection, run_id)
        position = stored.queue_position(connection, run)
    return RunOut.of(
        run,
        at=now(),
        size_bytes=_size(services, run),
        queue_position=position,
        references=references_of(entry.name for entry in run.algorithms),
    )


def _size(services: Services, run: stored.Run) -> int | None:
    return None if run.result_sha256 is None else services.store.size(run.result_sha256)
