"""Everything under /api needs the token: as `Authorization: Bearer`, or as the cookie that the page got for it.

Open without it: the page itself with its scripts, /healthz, /readyz, /problems, and the description of the API
(/docs, /openapi.json), which says nothing about this server's data.

`GET /?token=...` swaps the token for a cookie and drops it from the address. The cookie holds a keyed hash, so the
token is not kept by the browser, and carries the data folder's id in its name because cookies ignore ports: two
servers on one host keep apart.
"""

from __future__ import annotations

import hashlib
import hmac
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.requests import cookie_parser
from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from backend.http.problems import problem_response

PROTECTED = "/api"
_COOKIE_AGE_S = 365 * 86400


class TokenGate:
    """Let through who knows the token; `token` None lets everybody through."""

    def __init__(self, app: ASGIApp, *, token: str | None, instance_id: str) -> None:
        self.app = app
        self.token = token
        self.cookie_name = f"filterroom_{instance_id}"
        self.cookie_value = (
            hmac.new(token.encode(), b"filterroom cookie", hashlib.sha256).hexdigest() if token is not None else ""
        )

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        if scope["path"] == "/" and b"token=" in scope["query_string"]:
            await self._swap(scope, receive, send)
            return
        is_protected = scope["path"] == PROTECTED or scope["path"].startswith(PROTECTED + "/")
        if self.token is None or not is_protected:
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        kind, _, given = headers.get("authorization", "").partition(" ")
        if kind.lower() == "bearer":
            if self._is_token(given.strip()):
                await self.app(scope, receive, send)
                return
            code, detail = "token_wrong", "The token is not the one of this server."
        elif hmac.compare_digest(self._cookie(headers).encode(), self.cookie_value.encode()):
            await self.app(scope, receive, send)
            return
        else:
            code, detail = "token_required", "This needs the server's token."
        response = problem_response(
            path=scope["path"],
            status=401,
            code=code,
            detail=f"{detail} Send it as `Authorization: Bearer TOKEN`, or open the address that the server prints.",
            headers={"WWW-Authenticate": 'Bearer realm="filterroom"'},
        )
        await response(scope, receive, send)

    async def _swap(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Set the cookie where the token is right, and go to the page either way: it asks for a token if it must."""
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
        response = RedirectResponse("./", status_code=303, headers={"Cache-Control": "no-store"})
        if self.token is not None and self._is_token(given):
            response.set_cookie(
                self.cookie_name, self.cookie_value, max_age=_COOKIE_AGE_S, httponly=True, samesite="strict"
            )
        await response(scope, receive, send)

    def _is_token(self, given: str) -> bool:
        return self.token is not None and hmac.compare_digest(given.encode(), self.token.encode())

    def _cookie(self, headers: Headers) -> str:
        return cookie_parser(headers.get("cookie", "")).get(self.cookie_name, "")
