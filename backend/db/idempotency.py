"""Idempotency keys: a repeated request gets the first answer, also after a restart."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass

from sqlalchemy import Connection, delete, insert, select

from backend.db.ids import now
from backend.db.tables import idempotency_keys


@dataclass(frozen=True)
class IdempotencyKey:
    """A key that a client sent, the hash of the request it came with, and where the answer stands."""

    key: str
    body_sha256: str
    location: str
    created_at: dt.datetime


def find_key(connection: Connection, key: str) -> IdempotencyKey | None:
    """Return what is remembered under a key."""
    row = connection.execute(select(idempotency_keys).where(idempotency_keys.c.key == key)).one_or_none()
    return None if row is None else IdempotencyKey(**row._mapping)


def remember_key(connection: Connection, key: str, body_sha256: str, location: str) -> None:
    """Remember a key; ask `find_key` in the same write transaction first."""
    connection.execute(
        insert(idempotency_keys).values(key=key, body_sha256=body_sha256, location=location, created_at=now())
    )


def forget_old_keys(connection: Connection, before: dt.datetime) -> int:
    """Delete keys older than `before` and return how many."""
    return connection.execute(delete(idempotency_keys).where(idempotency_keys.c.created_at < before)).rowcount
