"""The last net: an error that nobody expected becomes a problem without a traceback; the log has the traceback."""

from __future__ import annotations

import errno
import logging
import secrets

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from backend.http.problems import problem_response

logger = logging.getLogger("filterroom.http")

_DISK = {
    errno.ENOSPC: "The disk is full.",
    errno.EDQUOT: "The disk quota is used up.",
    errno.EROFS: "The disk is read-only.",
}


class UnexpectedErrors:
    """Answer 500 (507 where the disk is full) instead of breaking the connection."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        started = False

        async def watch(message: Message) -> None:
            nonlocal started
            started = started or message["type"] == "http.response.start"
            await send(message)

        try:
            await self.app(scope, receive, watch)
        except Exception as error:
            number = secrets.token_hex(4)
            logger.exception("error %s while answering %s %s", number, scope["method"], scope["path"])
            if started:
                # Half an answer is out: only a broken connection tells the client that it is not whole.
                raise
            response = (
                problem_response(
                    path=scope["path"],
                    status=507,
                    code="storage",
                    detail=f"{_DISK[error.errno]} Free some space in the data folder and try again.",
                )
                if isinstance(error, OSError) and error.errno in _DISK
                else problem_response(
                    path=scope["path"],
                    status=500,
                    code="internal",
                    detail=f"An unexpected error happened; the server's log has it under number {number}.",
                )
            )
            await response(scope, receive, send)
