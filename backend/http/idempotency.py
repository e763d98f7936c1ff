"""The header Idempotency-Key: a request that is sent twice makes one thing."""

from __future__ import annotations

import hashlib
from typing import Annotated

from fastapi import Header

from backend.http.problems import ProblemError, ProblemItem

IdempotencyKeyHeader = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        min_length=1,
        max_length=128,
        pattern="^[!-~]+$",
        description="Any text of your own. The same key with the same body answers as the first time.",
    ),
]


def body_digest(path: str, body: bytes) -> str:
    """Return the hash that decides whether two requests are the same."""
    return hashlib.sha256(path.encode() + b"\0" + body).hexdigest()


def key_reused() -> ProblemError:
    """Return the error of a key that came with another body before."""
    detail = "This Idempotency-Key was used with another body. Use a new key for a new request."
    item = ProblemItem(pointer="/header/Idempotency-Key", detail=detail, code="idempotency_key_reused")
    return ProblemError(422, "idempotency_key_reused", detail, errors=[item])
