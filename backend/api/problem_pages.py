"""A short page on each kind of problem: what `type` of a problem points to."""

from __future__ import annotations

import html
import json

from fastapi import APIRouter, Request, Response

from backend.errors import NotFoundError
from backend.http.etag import conditional
from backend.http.problem_codes import PROBLEMS

router = APIRouter(prefix="/problems", include_in_schema=False)


@router.get("", name="list_problems")
def list_problems(request: Request) -> Response:
    """List all kinds of problems as JSON."""
    items = [{"code": code, "title": kind.title, "meaning": kind.meaning} for code, kind in PROBLEMS.items()]
    return conditional(request, json.dumps({"items": items}).encode(), "application/json")


@router.get("/{code}", name="show_problem")
def show_problem(code: str, request: Request) -> Response:
    """Explain one kind: as a page to browsers, as JSON to everything else."""
    kind = PROBLEMS.get(code)
    if kind is None:
        raise NotFoundError(f"There is no page on the code {code!r}.", remedy="GET /problems lists all.")
    if "text/html" in request.headers.get("accept", ""):
        title, meaning = html.escape(kind.title), html.escape(kind.meaning)
        page = (
            f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title></head>'
            f"<body><h1>{title}</h1><p>{meaning}</p><p><code>{html.escape(code)}</code></p></body></html>"
        )
        answer = conditional(request, page.encode(), "text/html; charset=utf-8")
    else:
        content = {"code": code, "title": kind.title, "meaning": kind.meaning}
        answer = conditional(request, json.dumps(content).encode(), "application/json")
    answer.headers["Vary"] = "Accept"
    return answer
