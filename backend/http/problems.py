"""Problem details (RFC 9457): every error answer of the server, and the one place that maps errors to statuses."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ConfigDict, ValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

from algorithms.errors import AlgorithmError, FilterRoomError, InputError
from backend.errors import NotFoundError, QuotaError, StateError, StorageError, TooLargeError, UnavailableError
from backend.http.allowed_methods import allowed_methods
from backend.http.problem_codes import PROBLEMS

MEDIA_TYPE = "application/problem+json"

# The first match along a class's method resolution order counts.
STATUS: dict[type[FilterRoomError], int] = {
    InputError: 422,
    AlgorithmError: 422,
    NotFoundError: 404,
    StateError: 409,
    TooLargeError: 413,
    QuotaError: 429,
    StorageError: 507,
    UnavailableError: 503,
    FilterRoomError: 500,
}

# Codes of the statuses that routing and parsing answer with.
_PLAIN = {
    400: "malformed_request",
    401: "token_required",
    403: "forbidden",
    404: "not_found",
    405: "method_not_allowed",
    413: "too_large",
    415: "unsupported_media_type",
    422: "validation",
    429: "quota",
}


class ProblemItem(BaseModel):
    """One of several things that are wrong."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    pointer: str
    """JSON pointer to the field; `/query/...` and `/header/...` point to a query parameter or a header."""
    detail: str
    """What is wrong and what to do."""
    code: str
    """Stable code."""


class Problem(BaseModel):
    """An error, as `application/problem+json`."""

    model_config = ConfigDict(use_attribute_docstrings=True)

    type: str
    """Address of a page on this kind of problem."""
    title: str
    """The kind of problem in a few words; the same for every problem of this code."""
    status: int
    """HTTP status."""
    detail: str
    """What happened, where, and what to do."""
    instance: str
    """Path of the request."""
    code: str
    """Stable code, for scripts and translations."""
    errors: list[ProblemItem] = []
    """Everything that is wrong, where that can be listed."""


class ProblemError(Exception):
    """An error of the protocol itself, with its status; errors of the program are of `FilterRoomError`'s tree."""

    def __init__(
        self,
        status: int,
        code: str,
        detail: str,
        *,
        errors: Sequence[ProblemItem] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(detail)
        self.status = status
        self.code = code
        self.detail = detail
        self.errors = list(errors)
        self.headers = dict(headers or {})


def status_of(error: FilterRoomError) -> int:
    """Return the HTTP status of an error of the program."""
    return next(STATUS[t] for t in type(error).__mro__ if t in STATUS)


def problem_response(
    *,
    path: str,
    status: int,
    code: str,
    detail: str,
    errors: Sequence[ProblemItem] = (),
    headers: Mapping[str, str] | None = None,
) -> Response:
    """Return a problem as an HTTP response that no cache keeps."""
    title = PROBLEMS[code].title if code in PROBLEMS else PROBLEMS[_PLAIN.get(status, "internal")].title
    problem = Problem(
        type=f"/problems/{code}",
        title=title,
        status=status,
        detail=detail,
        instance=path,
        code=code,
        errors=list(errors),
    )
    return Response(
        # JSON that is valid UTF-8 even where the path or the detail carries lone surrogates.
        json.dumps(problem.model_dump(), ensure_ascii=True),
        status_code=status,
        media_type=MEDIA_TYPE,
        headers={"Cache-Control": "no-store", **(headers or {})},
    )


def items_of(error: ValidationError | RequestValidationError, prefix: str = "") -> list[ProblemItem]:
    """Translate pydantic's list of errors; `prefix` is the pointer of the validated value."""
    return [
        ProblemItem(pointer=prefix + pointer_of(tuple(e["loc"])), detail=_sentence(e), code=_item_code(e["type"]))
        for e in error.errors()
    ]


def pointer_of(location: Sequence[str | int]) -> str:
    """Return the JSON pointer of a place in a request."""
    parts = list(location)
    if parts and parts[0] == "body":
        parts = parts[1:]
    return "".join("/" + str(p).replace("~", "~0").replace("/", "~1") for p in parts)


def _sentence(error: Mapping[str, Any]) -> str:
    message = str(error["msg"]).removeprefix("Value error, ")
    if error["type"] == "extra_forbidden":
        return "There is no such field; check its spelling or leave it out."
    return message if message.endswith((".", "!", "?")) else message + "."


def _item_code(kind: str) -> str:
    return {"missing": "missing", "extra_forbidden": "unknown_field", "value_error": "invalid"}.get(kind, kind)


def _on_program_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, FilterRoomError)
    items = []
    if isinstance(error, InputError) and error.pointer:
        items.append(ProblemItem(pointer=error.pointer, detail=str(error), code=error.code))
    headers = {"Retry-After": "5"} if isinstance(error, QuotaError | UnavailableError) else {}
    return problem_response(
        path=request.url.path,
        status=status_of(error),
        code=error.code,
        detail=str(error),
        errors=items,
        headers=headers,
    )


def _on_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, ProblemError)
    return problem_response(
        path=request.url.path,
        status=error.status,
        code=error.code,
        detail=error.detail,
        errors=error.errors,
        headers=error.headers,
    )


def _on_invalid(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    errors = error.errors()
    media_type = request.headers.get("content-type", "").split(";")[0].strip().lower()
    if any(e["loc"][:1] == ("body",) for e in errors) and media_type != "application/json":
        named = f"not {media_type!r}" if media_type else "and the request does not say its type"
        return problem_response(
            path=request.url.path,
            status=415,
            code="unsupported_media_type",
            detail=f"The body must be JSON with `Content-Type: application/json`, {named}.",
        )
    if any(e["type"] == "json_invalid" for e in errors):
        reason = errors[0].get("ctx", {}).get("error", "it could not be parsed")
        return problem_response(
            path=request.url.path,
            status=400,
            code="malformed_json",
            detail=f"The body is not valid JSON: {reason}.",
        )
    items = items_of(error)
    return problem_response(
        path=request.url.path, status=422, code="validation", detail=summary_of(items), errors=items
    )


def summary_of(items: Sequence[ProblemItem]) -> str:
    """Return one line for a list of errors: the first, and how many more there are."""
    first = f"{items[0].pointer or 'The body'}: {items[0].detail}"
    return first if len(items) == 1 else f"{first} ({len(items) - 1} more)"


def _on_http(request: Request, error: Exception) -> Response:
    assert isinstance(error, HTTPException)
    status = error.status_code
    headers = dict(error.headers or {})
    detail = str(error.detail)
    if status == 404:
        detail = f"There is nothing at {request.url.path}."
    elif status == 405:
        methods = allowed_methods(request)
        headers = {"Allow": ", ".join(methods)}
        detail = f"{request.method} is not possible at {request.url.path}; possible: {', '.join(methods)}."
    return problem_response(
        path=request.url.path,
        status=status,
        code=_PLAIN.get(status, "malformed_request" if status < 500 else "internal"),
        detail=detail,
        headers=headers,
    )


def install(app: FastAPI) -> None:
    """Make every error of `app` a problem. What none of these knows is caught by `UnexpectedErrors`."""
    app.add_exception_handler(FilterRoomError, _on_program_error)
    app.add_exception_handler(ProblemError, _on_problem)
    app.add_exception_handler(RequestValidationError, _on_invalid)
    app.add_exception_handler(HTTPException, _on_http)
