"""The last net: an error that nobody expected becomes a problem without a traceback; the log has the traceback."""

from __future__ import annotations

import errno
import logging
import secrets

from starlette.types import ASGIApp, Message, Receive, Scope, Send

from backend.files.store import refusal_of
from backend.http.problems import problem_response

logger = logging.getLogger("filterroom.http")

# What a disk refuses; anything else that the operating system says is an error of the program.
_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EACCES, errno.EPERM, errno.EIO)


class UnexpectedErrors:
    """Answer 500 (507 where the disk refused) instead of breaking the connection."""

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
            refused = refusal_of(error) if isinstance(error, OSError) and error.errno in _DISK else None
            number = secrets.token_hex(4)
            logger.error(
                "error %s while answering %s %s: %s",
                number,
                scope["method"],
                scope["path"],
                error,
                # A disk that refuses is no error of the program: the line says all.
                exc_info=refused is None,
            )
            if started:
                # Half an answer is out: only a broken connection tells the client that it is not whole.
                raise
            response = (
                problem_response(
                    path=scope["path"],
                    status=507,
                    code=refused.code,
                    detail=str(refused),
                )
                if refused is not None
                else problem_response(
                    path=scope["path"],
                    status=500,
                    code="internal",
                    detail=f"An unexpected error happened; the server's log has it under number {number}.",
                )
            )
            await response(scope, receive, send)
