"""Queries about runs. Every function works inside the caller's transaction.

A run is queued, running, succeeded, failed or cancelled; the last three are final. Every change of state
is one `UPDATE ... WHERE state IN (...)`, so that whoever comes second (a cancel, a finished worker)
changes nothing.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import ColumnElement, Connection, Row, delete, exists, func, insert, null, select, tuple_, update

from backend.db import events
from backend.db.ids import new_id, now
from backend.db.tables import recordings, run_algorithms, run_blocks, run_recordings, run_tags, runs
from backend.errors import NotFoundError, StateError

RunState = Literal["queued", "running", "succeeded", "failed", "cancelled"]
LIVE: tuple[RunState, ...] = ("queued", "running")
FINAL: tuple[RunState, ...] = ("succeeded", "failed", "cancelled")


@dataclass(frozen=True)
class Entry:
    """One algorithm of a run; `label` is unique in the run and names everything that comes of it."""

    name: str
    label: str
    parameters: Mapping[str, Any]


@dataclass(frozen=True)
class Run:
    """A row of `runs`.

    Attributes
    ----------
    source : what the run works on: {"recording_id": ...}
    progress_done, progress_total : work in rows of the recording times algorithms
    error : {"code", "detail", "remedy", "pointer", "label"} of a failed run
    summary : {metric: {label: {"value", "ci95", "unit"}}}
    entries : per algorithm what was really used: {"label", "settings", "notes", "seconds"}; None in lists
    """

    id: str
    state: RunState
    label: str
    tags: tuple[str, ...]
    created_at: dt.datetime
    started_at: dt.datetime | None
    finished_at: dt.datetime | None
    source: Mapping[str, Any]
    algorithms: tuple[Entry, ...]
    seed: int
    trials: int
    progress_done: int
    progress_total: int
    error: Mapping[str, Any] | None
    summary: Mapping[str, Any] | None
    entries: Sequence[Mapping[str, Any]] | None
    software: Mapping[str, Any] | None
    result_sha256: str | None

    @property
    def is_final(self) -> bool:
        """Whether nothing about this run can change any more."""
        return self.state in FINAL

    def eta_s(self, at: dt.datetime) -> float | None:
        """Estimate the seconds still to go from the pace so far; None while there is none."""
        if self.state != "running" or self.started_at is None or self.progress_done <= 0:
            return None
        elapsed = (at - self.started_at).total_seconds()
        return max(0.0, elapsed * (self.progress_total - self.progress_done) / self.progress_done)


@dataclass(frozen=True)
class RunFilter:
    """What a list of runs is narrowed to; None or empty means any.

    Every word of `text` must stand in a label, a tag, or a name: of an algorithm, the recording, scenario or study.
    """

    state: tuple[RunState, ...] = ()
    algorithm: str | None = None
    tag: str | None = None
    recording_id: str | None = None
    text: str = ""
    created_after: dt.datetime | None = None
    created_before: dt.datetime | None = None


def create_run(
    connection: Connection,
    *,
    algorithms: Sequence[Entry],
    source: Mapping[str, Any],
    recording_ids: Sequence[str] = (),
    label: str = "",
    tags: Sequence[str] = (),
    seed: int = 0,
    trials: int = 1,
    progress_total: int = 0,
) -> Run:
    """Add a run in the state `queued`; call `Engine.notify()` after the transaction.

    Raises
    ------
    NotFoundError
        A recording has been deleted meanwhile.
    """
    for recording_id in recording_ids:
        if connection.scalar(select(recordings.c.id).where(recordings.c.id == recording_id)) is None:
            raise NotFoundError(f"There is no recording {recording_id!r}.", code="recording_not_found")
    run_id = new_id()
    tags = tuple(dict.fromkeys(tags))
    connection.execute(
        insert(runs).values(
            id=run_id,
            state="queued",
            label=label,
            tags=list(tags),
            created_at=now(),
            source=dict(source),
            algorithms=[{"name": e.name, "label": e.label, "parameters": dict(e.parameters)} for e in algorithms],
            seed=seed,
            trials=trials,
            progress_total=progress_total,
            search_text=_search_text(label, tags, algorithms, source),
        )
    )
    for table, rows in (
        (run_algorithms, [{"name": name} for name in dict.fromkeys(e.name for e in algorithms)]),
        (run_tags, [{"tag": tag} for tag in tags]),
        (run_recordings, [{"recording_id": r, "position": i} for i, r in enumerate(recording_ids)]),
    ):
        if rows:
            connection.execute(insert(table), [{"run_id": run_id, **row} for row in rows])
    _announce(connection, run_id, "queued")
    return get_run(connection, run_id)


def get_run(connection: Connection, run_id: str) -> Run:
    """Return a run or raise NotFoundError."""
    row = connection.execute(select(*_COLUMNS).where(runs.c.id == run_id)).one_or_none()
    if row is None:
        raise NotFoundError(f"There is no run {run_id!r}.", code="run_not_found")
    return _run(row)


def list_runs(
    connection: Connection,
    only: RunFilter = RunFilter(),
    *,
    limit: int = 50,
    after: tuple[dt.datetime, str] | None = None,
    oldest_first: bool = False,
) -> list[Run]:
    """Return up to `limit` runs, newest first, that follow the run with (created_at, id) `after`.

    Their `entries` are left unread (None): no list shows them, and they are half of what reading one costs.
    """
    query = _LIST.where(*_conditions(connection, only)).limit(limit)
    if oldest_first:
        query = query.order_by(runs.c.created_at, runs.c.id)
    else:
        query = query.order_by(runs.c.created_at.desc(), runs.c.id.desc())
    if after is not None:
        key = tuple_(runs.c.created_at, runs.c.id)
        query = query.where(key > after if oldest_first else key < after)
    return [_run(row) for row in connection.execute(query)]


def live_runs(connection: Connection) -> list[Run]:
    """Return the queued and running runs, oldest first: the order in which they are worked on."""
    query = select(*_COLUMNS).where(runs.c.state.in_(LIVE)).order_by(runs.c.created_at, runs.c.id)
    return [_run(row) for row in connection.execute(query)]


def list_tags(connection: Connection) -> list[tuple[str, int]]:
    """Return every tag with the number of its runs, in the order of the alphabet."""
    query = select(run_tags.c.tag, func.count()).group_by(run_tags.c.tag)
    return sorted(((tag, int(count)) for tag, count in connection.execute(query)), key=lambda t: t[0].casefold())


def count_runs(connection: Connection, state: RunState) -> int:
    """Return how many runs are in a state."""
    return int(connection.scalar(select(func.count()).select_from(runs).where(runs.c.state == state)) or 0)


def queue_position(connection: Connection, run: Run) -> int | None:
    """Return how many queued runs stand before this one; None where it does not wait."""
    if run.state != "queued":
        return None
    earlier = tuple_(runs.c.created_at, runs.c.id) < (run.created_at, run.id)
    query = select(func.count()).select_from(runs).where(runs.c.state == "queued", earlier)
    return int(connection.scalar(query) or 0)


def recording_ids_of(connection: Connection, run_id: str) -> list[str]:
    """Return the recordings of a run in the order in which they were given."""
    query = select(run_recordings.c.recording_id).where(run_recordings.c.run_id == run_id)
    return list(connection.scalars(query.order_by(run_recordings.c.position)))


def start_run(connection: Connection, run_id: str) -> bool:
    """Turn queued into running; False where the run is not queued any more."""
    started_at = func.coalesce(runs.c.started_at, now())
    return _change(connection, run_id, ("queued",), "running", started_at=started_at)


def requeue_running(connection: Connection) -> list[str]:
    """Queue again what was running when the server stopped, and return the ids."""
    ids = list(connection.scalars(select(runs.c.id).where(runs.c.state == "running").order_by(runs.c.created_at)))
    for run_id in ids:
        _change(connection, run_id, ("running",), "queued")
    return ids


def set_progress(connection: Connection, run_id: str, done: int) -> bool:
    """Store the progress of a running run and announce it."""
    statement = update(runs).where(runs.c.id == run_id, runs.c.state == "running")
    total = connection.scalar(statement.values(progress_done=done).returning(runs.c.progress_total))
    if total is None:
        return False
    events.append_event(connection, "run.progress", {"id": run_id, "done": done, "total": total}, run_id=run_id)
    return True


def finish_run(
    connection: Connection,
    run_id: str,
    *,
    result_sha256: str,
    summary: Mapping[str, Any],
    entries: Sequence[Mapping[str, Any]],
    software: Mapping[str, Any],
) -> bool:
    """Turn running into succeeded; False where it was cancelled or deleted meanwhile."""
    return _change(
        connection,
        run_id,
        ("running",),
        "succeeded",
        finished_at=now(),
        result_sha256=result_sha256,
        summary=dict(summary),
        entries=[dict(e) for e in entries],
        software=dict(software),
        progress_done=runs.c.progress_total,
    )


def fail_run(connection: Connection, run_id: str, error: Mapping[str, Any]) -> bool:
    """Turn a live run into failed, with an error {code, detail, remedy, pointer, label}."""
    return _change(connection, run_id, LIVE, "failed", finished_at=now(), error=dict(error))


def cancel_run(connection: Connection, run_id: str) -> bool:
    """Turn a live run into cancelled; False where it already was.

    Raises
    ------
    NotFoundError
        There is no such run.
    StateError
        It already succeeded or failed.
    """
    if _change(connection, run_id, LIVE, "cancelled", finished_at=now()):
        return True
    state = get_run(connection, run_id).state
    if state == "cancelled":
        return False
    raise StateError(f"The run has {state} already.", remedy="A finished run can only be deleted.", code="run_finished")


def rename_run(
    connection: Connection, run_id: str, *, label: str | None = None, tags: Sequence[str] | None = None
) -> None:
    """Give a run, finished or not, another label or other tags; None leaves them as they are."""
    run = get_run(connection, run_id)
    label = run.label if label is None else label
    kept = run.tags if tags is None else tuple(dict.fromkeys(tags))
    if (label, kept) == (run.label, run.tags):
        return
    statement = update(runs).where(runs.c.id == run_id)
    search_text = _search_text(label, kept, run.algorithms, run.source)
    connection.execute(statement.values(label=label, tags=list(kept), search_text=search_text))
    connection.execute(delete(run_tags).where(run_tags.c.run_id == run_id))
    if kept:
        connection.execute(insert(run_tags), [{"run_id": run_id, "tag": tag} for tag in kept])
    _announce(connection, run_id, run.state)


def delete_run(connection: Connection, run_id: str) -> frozenset[str]:
    """Delete a finished run and return the blobs it referred to.

    Raises
    ------
    StateError
        It is still queued or running.
    """
    run = get_run(connection, run_id)
    if not run.is_final:
        raise StateError(f"The run is {run.state}.", remedy="Cancel it before you delete it.", code="run_live")
    blobs = set(connection.scalars(select(run_blocks.c.sha256).where(run_blocks.c.run_id == run_id)))
    if run.result_sha256:
        blobs.add(run.result_sha256)
    connection.execute(delete(runs).where(runs.c.id == run_id))
    # Belongs to no run: it must outlive the one it tells of.
    events.append_event(connection, "run.changed", {"id": run_id, "state": "deleted"})
    return frozenset(blobs)


_COLUMNS = [c for c in runs.c if c.name != "search_text"]
_LIST = select(*[null().label("entries") if c.name == "entries" else c for c in _COLUMNS])
# Up to so many runs with a tag, an algorithm or a recording are looked up and sorted; where there are more, a page of
# them is found sooner by going through the runs in their order.
_FEW = 500


def _search_text(label: str, tags: Sequence[str], algorithms: Sequence[Entry], source: Mapping[str, Any]) -> str:
    origin = [str(source.get(name) or "") for name in ("name", "study")]
    origin.append(str(source.get("scenario", {}).get("preset", "")))
    words = [label, *tags, *(e.label for e in algorithms), *(e.name for e in algorithms), *origin]
    return "\n".join(dict.fromkeys(words)).casefold()


def _conditions(connection: Connection, only: RunFilter) -> list[ColumnElement[bool]]:
    conditions: list[ColumnElement[bool]] = []
    if only.state:
        conditions.append(runs.c.state.in_(only.state))
    for table, column, value in (
        (run_algorithms, run_algorithms.c.name, only.algorithm),
        (run_tags, run_tags.c.tag, only.tag),
        (run_recordings, run_recordings.c.recording_id, only.recording_id),
    ):
        if value is None:
            continue
        some = select(table.c.run_id).where(column == value)
        if len(connection.execute(some.limit(_FEW + 1)).all()) > _FEW:
            conditions.append(exists().where(table.c.run_id == runs.c.id, column == value))
        else:
            conditions.append(runs.c.id.in_(some))
    conditions += [runs.c.search_text.contains(word, autoescape=True) for word in only.text.casefold().split()]
    if only.created_after is not None:
        conditions.append(runs.c.created_at > only.created_after)
    if only.created_before is not None:
        conditions.append(runs.c.created_at < only.created_before)
    return conditions


def _change(connection: Connection, run_id: str, old: tuple[RunState, ...], new: RunState, **values: Any) -> bool:
    statement = update(runs).where(runs.c.id == run_id, runs.c.state.in_(old))
    if connection.execute(statement.values(state=new, **values)).rowcount == 0:
        return False
    _announce(connection, run_id, new)
    return True


def _announce(connection: Connection, run_id: str, state: RunState) -> None:
    events.append_event(connection, "run.changed", {"id": run_id, "state": state}, run_id=run_id)


def _run(row: Row[Any]) -> Run:
    values = dict(row._mapping)
    values["tags"] = tuple(values["tags"])
    values["algorithms"] = tuple(Entry(e["name"], e["label"], e["parameters"]) for e in values["algorithms"])
    return Run(**values)
