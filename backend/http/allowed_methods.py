"""The methods that a path really has: the router names only those of the first route that matches the path."""

from __future__ import annotations

from fastapi import Request
from starlette.routing import Match

_METHODS = ("GET", "HEAD", "POST", "PUT", "PATCH", "DELETE")


def allowed_methods(request: Request) -> list[str]:
    """Return the methods for which some route serves the request's path."""
    routes = request.app.router.routes
    # The files of the page come after all routes and are no route themselves.
    return [m for m in _METHODS if any(_serves(route, request, m) for route in routes)] or ["GET", "HEAD"]


def _serves(route: object, request: Request, method: str) -> bool:
    match, _ = route.matches({**request.scope, "method": method})  # type: ignore[attr-defined]
    return bool(match == Match.FULL)
