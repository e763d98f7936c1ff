"""Refuse a body above the limit: by what it claims before a byte is read, else as soon as it grows too large."""

from __future__ import annotations

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from backend.http.problems import problem_response

UPLOAD_PATH = "/api/v1/recordings"


class _TooLargeError(Exception):
    """The body grew above the limit while it was read."""


class BodyLimit:
    """Two limits: one for uploads (multipart or raw bytes), one for everything else."""

    def __init__(self, app: ASGIApp, *, json_bytes: int, upload_bytes: int) -> None:
        self.app = app
        self.json_bytes = json_bytes
        self.upload_bytes = upload_bytes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        is_upload = (
            scope["path"] == UPLOAD_PATH
            and headers.get("content-type", "").split(";")[0].strip().lower() != "application/json"
        )
        limit = self.upload_bytes if is_upload else self.json_bytes
        setting = "FILTERROOM_MAX_UPLOAD_BYTES" if is_upload else "FILTERROOM_MAX_JSON_BYTES"

        async def refuse() -> None:
            response = problem_response(
                path=scope["path"],
                status=413,
                code="too_large",
                detail=f"The body is larger than {limit} bytes. The limit is the setting {setting}.",
                # What follows is not read, so the connection cannot be used again.
                headers={"Connection": "close"},
            )
            await response(scope, receive, send)

        claimed = headers.get("content-length", "")
        if claimed.isdecimal() and int(claimed) > limit:
            await refuse()
            return
        read = 0
        too_large = started = False

        async def counted() -> Message:
            nonlocal read, too_large
            message = await receive()
            if message["type"] == "http.request":
                read += len(message.get("body", b""))
                if read > limit:
                    too_large = True
                    raise _TooLargeError
            return message

        async def unless_too_large(message: Message) -> None:
            # What the application makes of the interrupted body is not the answer; the refusal is.
            nonlocal started
            if not too_large:
                started = True
                await send(message)

        try:
            await self.app(scope, counted, unless_too_large)
        except _TooLargeError:
            if started:
                raise
        if too_large and not started:
            await refuse()
