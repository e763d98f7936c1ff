"""Server-sent events: what changes, as it changes, and from where a reader stopped."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Header, Response
from fastapi.sse import KEEPALIVE_COMMENT, format_sse_event
from starlette.concurrency import run_in_threadpool
from starlette.responses import StreamingResponse

from backend.api.responses import problems
from backend.api.services import Services, ServicesDep
from backend.db import events as stored
from backend.db import runs
from backend.errors import NotFoundError

router = APIRouter(tags=["events"])

_PING_S = 15.0
# Commits come in bursts; a stream looks at most this often.
_PAUSE_S = 0.1

LastEventId = Annotated[
    str | None,
    Header(alias="Last-Event-ID", description="Id of the last event you have; everything after it is sent again."),
]

_STREAM: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "Events `run.changed`, `run.progress`, `recording.changed`, `log`; data is JSON.",
        "content": {"text/event-stream": {"schema": {"type": "string"}}},
    }
}


@router.get("/events", name="stream_events", response_class=Response, responses=_STREAM | problems(401))
async def stream_events(services: ServicesDep, last_event_id: LastEventId = None) -> Response:
    """Stream what happens from now on, or from `Last-Event-ID` on, until you leave."""
    start = _number(last_event_id)
    if start is None:
        start = await run_in_threadpool(_newest, services)
    return _stream(services, start, None)


@router.get(
    "/runs/{run_id}/events",
    name="stream_run_events",
    response_class=Response,
    responses=_STREAM | {204: {"description": "The run is finished and you have all its events."}} | problems(401, 404),
)
async def stream_run_events(run_id: str, services: ServicesDep, last_event_id: LastEventId = None) -> Response:
    """Stream everything that happened and happens to one run; the stream ends with the run."""
    start = _number(last_event_id) or 0
    run = await run_in_threadpool(_run, services, run_id)
    if run.is_final and not (await run_in_threadpool(_look, services, start, run_id))[0]:
        # An EventSource connects again after the end of a stream; 204 tells it to stop.
        return Response(status_code=204)
    return _stream(services, start, run_id)


def _stream(services: Services, start: int, run_id: str | None) -> Response:
    return StreamingResponse(
        _events(services, start, run_id),
        media_type="text/event-stream",
        headers={"Cache-Control": "no-store", "X-Accel-Buffering": "no"},
    )


async def _events(services: Services, last: int, run_id: str | None) -> AsyncIterator[bytes]:
    yield format_sse_event(comment="open", retry=2000)
    with services.changes.woken() as flag:
        while not services.changes.closed:
            flag.clear()
            found, ended = await run_in_threadpool(_look, services, last, run_id)
            for event in found:
                last = event.id
                data = {"at": event.at.isoformat().replace("+00:00", "Z"), "run_id": event.run_id, **event.data}
                yield format_sse_event(data_str=json.dumps(data), event=event.kind, id=str(event.id))
            if ended and not found:
                return
            if found:
                await asyncio.sleep(_PAUSE_S)
                continue
            try:
                await asyncio.wait_for(flag.wait(), _PING_S)
            except TimeoutError:
                yield KEEPALIVE_COMMENT


def _number(last_event_id: str | None) -> int | None:
    # Another server's id, or nonsense, means the same as none: start with what is new.
    if last_event_id is None or not last_event_id.isascii() or not last_event_id.isdecimal():
        return None
    return min(int(last_event_id[:19]), 2**62)


def _newest(services: Services) -> int:
    with services.database.read() as connection:
        return stored.last_event_id(connection)


def _look(services: Services, last: int, run_id: str | None) -> tuple[list[stored.Event], bool]:
    """Return the events after `last`, and whether no more can come: the run is final, or deleted."""
    with services.database.read() as connection:
        found = stored.events_after(connection, last, run_id=run_id)
        if run_id is None:
            return found, False
        try:
            return found, runs.get_run(connection, run_id).is_final
        except NotFoundError:
            return found, True


def _run(services: Services, run_id: str) -> runs.Run:
    with services.database.read() as connection:
        return runs.get_run(connection, run_id)
