"""Only requests that address this server by a name it knows: the defence against DNS rebinding."""

from __future__ import annotations

from collections.abc import Sequence

from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from backend.http.problems import problem_response

# An IPv6 address stands in brackets in a Host header, and only so does it match.
ALWAYS = ("localhost", "127.0.0.1", "[::1]")


class AllowedHosts:
    """Starlette's host check, with an answer that names the host and the setting."""

    def __init__(self, app: ASGIApp, hosts: Sequence[str]) -> None:
        self.app = app
        self.check = TrustedHostMiddleware(_accepted, [*ALWAYS, *hosts], www_redirect=False)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan" or await self._accepts(scope, receive):
            await self.app(scope, receive, send)
            return
        host = dict(scope["headers"]).get(b"host", b"").decode("latin-1")
        response = problem_response(
            path=scope["path"],
            status=400,
            code="host_not_allowed",
            detail=(
                f"This server does not answer to the name {host!r}. If it should, add the name to the setting "
                "FILTERROOM_ALLOWED_HOSTS and start the server again."
            ),
        )
        await response(scope, receive, send)

    async def _accepts(self, scope: Scope, receive: Receive) -> bool:
        accepted = True

        async def refused(message: Message) -> None:
            nonlocal accepted
            accepted = False

        await self.check(scope, receive, refused)
        return accepted


async def _accepted(scope: Scope, receive: Receive, send: Send) -> None:
    """Stand for the application while the name is checked: nothing is sent, so the name is accepted."""
