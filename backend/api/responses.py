"""How the API's description names the errors of an endpoint."""

from __future__ import annotations

from typing import Any

from backend.http.problems import MEDIA_TYPE, Problem

_MEANING = {
    400: "The request cannot be taken apart, or names a host that this server does not answer to",
    401: "The token is missing or wrong",
    403: "A browser asks on behalf of another site",
    404: "There is nothing of this name",
    409: "The state of the thing does not allow this",
    413: "The body is above a limit",
    415: "The body is of a type that this endpoint does not take",
    422: "The content cannot be used; `errors` names the fields",
    429: "Too much at once",
    500: "Something unexpected; the server's log has it",
    507: "The disk is full",
}

Responses = dict[int | str, dict[str, Any]]


def problems(*statuses: int) -> Responses:
    """Describe the given error statuses, and those that every endpoint under /api has."""
    schema = {"$ref": f"#/components/schemas/{Problem.__name__}"}
    return {
        status: {"description": _MEANING[status], "content": {MEDIA_TYPE: {"schema": schema}}}
        for status in sorted({400, 401, 422, 500, *statuses})
    }


def content(media_type: str, description: str, schema: dict[str, Any] | None = None) -> Responses:
    """Describe a successful answer that is not JSON of a declared model."""
    return {200: {"description": description, "content": {media_type: {"schema": schema or {"type": "string"}}}}}
