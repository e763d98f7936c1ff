"""Events: what changed, in order, so that a browser can be told and a reader can look up what happened."""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import Connection, delete, func, insert, select

from backend.db.ids import now
from backend.db.tables import run_events

EventKind = Literal["run.changed", "run.progress", "log", "recording.changed"]
LogLevel = Literal["info", "warning", "error"]


@dataclass(frozen=True)
class Event:
    """One thing that happened; `id` grows and is never used twice."""

    id: int
    run_id: str | None
    at: dt.datetime
    kind: EventKind
    data: Mapping[str, Any]


@dataclass(frozen=True)
class LogLine:
    """One line of a run's log."""

    at: dt.datetime
    level: LogLevel
    text: str


def append_event(connection: Connection, kind: EventKind, data: Mapping[str, Any], *, run_id: str | None = None) -> int:
    """Store an event and return its id. Of a run's progress only the latest is kept."""
    if kind == "run.progress":
        connection.execute(delete(run_events).where(run_events.c.run_id == run_id, run_events.c.kind == "run.progress"))
    result = connection.execute(insert(run_events).values(run_id=run_id, at=now(), kind=kind, data=dict(data)))
    key = result.inserted_primary_key
    assert key is not None
    return int(key[0])


def append_log(connection: Connection, run_id: str, text: str, level: LogLevel = "info") -> int:
    """Add a line to a run's log."""
    return append_event(connection, "log", {"id": run_id, "level": level, "text": text}, run_id=run_id)


def last_event_id(connection: Connection) -> int:
    """Return the id of the newest event, 0 where there is none."""
    return int(connection.scalar(select(func.max(run_events.c.id))) or 0)


def events_after(connection: Connection, after: int, *, run_id: str | None = None, limit: int = 500) -> list[Event]:
    """Return the events that follow id `after`, oldest first; of one run if `run_id` is given."""
    query = select(run_events).where(run_events.c.id > after).order_by(run_events.c.id).limit(limit)
    if run_id is not None:
        query = query.where(run_events.c.run_id == run_id)
    return [Event(**row._mapping) for row in connection.execute(query)]


def log_lines(connection: Connection, run_id: str) -> list[LogLine]:
    """Return the log of a run, oldest line first."""
    query = (
        select(run_events.c.at, run_events.c.data)
        .where(run_events.c.run_id == run_id, run_events.c.kind == "log")
        .order_by(run_events.c.id)
    )
    return [LogLine(at, data["level"], data["text"]) for at, data in connection.execute(query)]


def forget_old_events(connection: Connection, before: dt.datetime) -> int:
    """Delete events that belong to no run (a run takes its own with it) and return how many."""
    return connection.execute(
        delete(run_events).where(run_events.c.run_id.is_(None), run_events.c.at < before)
    ).rowcount
