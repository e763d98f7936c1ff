"""Keyset pagination: a cursor names the last row seen, so that rows added meanwhile neither repeat nor hide others."""

from __future__ import annotations

import base64
import binascii
import datetime as dt
import hashlib
import json
from typing import Annotated, Any

from fastapi import Request, Response
from pydantic import BaseModel, ConfigDict, Field

from backend.http.problems import ProblemError, ProblemItem


class PageQuery(BaseModel):
    """Query parameters of every list; an unknown name is refused, so that no misspelt filter goes unnoticed."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True)

    limit: Annotated[int, Field(ge=1, le=500)] = 50
    """Entries per page."""
    cursor: Annotated[str, Field(max_length=400)] = ""
    """`next_cursor` of the page before."""

    def position(self) -> tuple[dt.datetime, str] | None:
        """Return (created_at, id) of the last row of the page before, None on the first page."""
        if not self.cursor:
            return None
        try:
            instant, row_id, digest = json.loads(base64.urlsafe_b64decode(self.cursor.encode()))
            created_at = dt.datetime.fromisoformat(instant)
        except (binascii.Error, ValueError, TypeError) as error:
            raise _bad_cursor("The cursor is not one that this server gave.") from error
        if not isinstance(row_id, str) or created_at.tzinfo is None:
            raise _bad_cursor("The cursor is not one that this server gave.")
        if digest != self._digest():
            raise _bad_cursor("The cursor belongs to a list with other filters; start again without it.")
        return created_at, row_id

    def next_cursor(self, created_at: dt.datetime, row_id: str) -> str:
        """Return the cursor that continues after this row."""
        content = json.dumps([created_at.isoformat(), row_id, self._digest()], separators=(",", ":"))
        return base64.urlsafe_b64encode(content.encode()).decode()

    def _digest(self) -> str:
        filters = self.model_dump_json(exclude={"limit", "cursor"})
        return hashlib.sha256(filters.encode()).hexdigest()[:12]


def _bad_cursor(detail: str) -> ProblemError:
    items = [ProblemItem(pointer="/query/cursor", detail=detail, code="cursor")]
    return ProblemError(422, "cursor", detail, errors=items)


def cut(query: PageQuery, rows: list[Any], request: Request, response: Response) -> tuple[list[Any], str | None]:
    """Cut a list that was asked for with one row too many; return the page and the cursor of the next one."""
    if len(rows) <= query.limit:
        return rows, None
    rows = rows[: query.limit]
    cursor = query.next_cursor(rows[-1].created_at, rows[-1].id)
    url = request.url.include_query_params(cursor=cursor)
    response.headers["Link"] = f'<{url.path}?{url.query}>; rel="next"'
    return rows, cursor
