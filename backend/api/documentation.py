"""The description of the API as a page, without a network: Swagger UI from the installed package.

Open without the token, as /openapi.json is: it describes the program, not this server's data.
"""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter, Request, Response
from starlette.responses import FileResponse

from backend.http.etag import conditional

router = APIRouter(include_in_schema=False)

_PAGE = b"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Filter Room API</title>
<link rel="icon" type="image/png" href="docs/favicon-32x32.png">
<link rel="stylesheet" href="docs/swagger-ui.css">
<script src="docs/swagger-ui-bundle.js" defer></script>
<script src="docs/start.js" defer></script>
</head>
<body><div id="api"></div></body>
</html>
"""
_START = b"""SwaggerUIBundle({
  url: "openapi.json", dom_id: "#api", deepLinking: true, validatorUrl: null,
  presets: [SwaggerUIBundle.presets.apis], layout: "BaseLayout",
});
"""


def _resource(name: str) -> Path:
    return Path(str(files("fastapi_swagger"))) / "resources" / name


@router.get("/docs", name="docs_page")
def docs_page(request: Request) -> Response:
    """Show the description of the API."""
    return conditional(request, _PAGE, "text/html; charset=utf-8")


@router.get("/docs/start.js", name="docs_start")
def docs_start(request: Request) -> Response:
    """Give the script that starts Swagger UI; the page's policy allows none inline."""
    return conditional(request, _START, "text/javascript; charset=utf-8")


@router.get("/docs/swagger-ui.css", name="docs_style")
def docs_style() -> Response:
    """Give Swagger UI's style sheet."""
    return FileResponse(_resource("swagger-ui.css"), media_type="text/css; charset=utf-8")


@router.get("/docs/swagger-ui-bundle.js", name="docs_script")
def docs_script() -> Response:
    """Give Swagger UI."""
    return FileResponse(_resource("swagger-ui-bundle.js"), media_type="text/javascript; charset=utf-8")


@router.get("/docs/favicon-32x32.png", name="docs_icon")
def docs_icon() -> Response:
    """Give Swagger UI's icon."""
    return FileResponse(_resource("favicon-32x32.png"), media_type="image/png")
