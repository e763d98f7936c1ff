"""Refuse changes that another site asks for in the user's browser.

The rules are those of Filippo Valsorda's "CSRF" (2025), which Go's net/http and Datasette follow: a browser says in
`Sec-Fetch-Site` where a request comes from; an old browser says it in `Origin`; a program says nothing and passes,
because only a browser sends the user's cookie without being told to.
"""

from __future__ import annotations

from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Receive, Scope, Send

from backend.http.problems import problem_response

_SAFE = ("GET", "HEAD", "OPTIONS")


class CrossSite:
    """Answer 403 to an unsafe method that comes from another origin."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        reason = _refusal(scope) if scope["type"] == "http" else ""
        if not reason:
            await self.app(scope, receive, send)
            return
        response = problem_response(path=scope["path"], status=403, code="cross_site", detail=reason)
        await response(scope, receive, send)


def _refusal(scope: Scope) -> str:
    """Return why the request is refused, or an empty text."""
    if scope["method"] in _SAFE:
        return ""
    headers = Headers(scope=scope)
    if headers.get("authorization", "").lower().startswith("bearer ") and "cookie" not in headers:
        # A browser never adds a bearer token by itself: whoever sends it, knows it.
        return ""
    site = headers.get("sec-fetch-site")
    if site is not None:
        if site in ("same-origin", "none"):
            return ""
        return f"The browser says that this request comes from another site (Sec-Fetch-Site: {site})."
    origin = headers.get("origin")
    if origin is None or urlsplit(origin).netloc == headers.get("host"):
        return ""
    return f"This request comes from {origin}, not from this server's own page."
