"""Conditional answers: who has the present version gets 304 and no body."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from fastapi import Request
from starlette.responses import Response

# A finished run never changes, so what is made of it alone is good for ever.
IMMUTABLE = "private, max-age=31536000, immutable"
# Kept by the browser, but asked for again: what is drawn may change with the program's version.
REVALIDATE = "private, no-cache"


def etag_of(*parts: str | bytes) -> str:
    """Return a weak entity tag (a compressed body counts as the same) of everything that decides the content."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "big") + data)
    return f'W/"{digest.hexdigest()[:32]}"'


def matches(request: Request, etag: str) -> bool:
    """Whether the client already has this version."""
    header = request.headers.get("if-none-match", "")
    tags = [t.strip().removeprefix("W/") for t in header.split(",")]
    return "*" in tags or etag.removeprefix("W/") in tags


def not_modified(etag: str, cache_control: str = REVALIDATE) -> Response:
    """Return 304."""
    return Response(status_code=304, headers={"ETag": etag, "Cache-Control": cache_control})


def conditional(
    request: Request,
    content: bytes,
    media_type: str,
    *,
    cache_control: str = REVALIDATE,
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Return content that is at hand, or 304 where the client has the same."""
    etag = etag_of(content)
    if matches(request, etag):
        return not_modified(etag, cache_control)
    return Response(
        content,
        media_type=media_type,
        headers={"ETag": etag, "Cache-Control": cache_control, **(headers or {})},
    )
