"""The page: static files of the dashboard, and plotly.js from the installed plotly package."""

from __future__ import annotations

import gzip
import os
import secrets
from pathlib import Path

from fastapi import APIRouter, FastAPI, Request, Response
from starlette.responses import FileResponse

from backend.api.services import ServicesDep
from backend.errors import NotFoundError
from backend.http.etag import matches, not_modified
from backend.page import page_folder
from backend.version import plotly_js_path, plotly_js_version

router = APIRouter(prefix="/assets", include_in_schema=False)

# The version is part of the address, so the file never changes.
_FOR_EVER = "public, max-age=31536000, immutable"


def serve_page(app: FastAPI) -> None:
    """Serve the page's files wherever no route matches; an unknown path stays 404."""
    app.frontend("/", directory=page_folder(), fallback=None)


@router.get("/plotly-{version}.min.js", name="plotly_versioned")
def plotly_versioned(version: str, request: Request, services: ServicesDep) -> Response:
    """Give plotly.js of the version that /api/v1/meta names."""
    if version != plotly_js_version():
        raise NotFoundError(f"plotly.js {version} is not here.", remedy=f"This server has {plotly_js_version()}.")
    return _plotly(request, services.settings.data_dir, _FOR_EVER)


@router.get("/plotly.min.js", name="plotly_latest")
def plotly_latest(request: Request, services: ServicesDep) -> Response:
    """Give plotly.js whatever its version."""
    return _plotly(request, services.settings.data_dir, "no-cache")


def _plotly(request: Request, data_dir: Path, cache_control: str) -> Response:
    etag = f'W/"plotly-{plotly_js_version()}"'
    headers = {"ETag": etag, "Cache-Control": cache_control, "Vary": "Accept-Encoding"}
    if matches(request, etag):
        return not_modified(etag, cache_control)
    path = plotly_js_path()
    if "gzip" in request.headers.get("accept-encoding", ""):
        path = compressed(path, data_dir / "cache" / f"plotly-{plotly_js_version()}.min.js.gz")
        headers["Content-Encoding"] = "gzip"
    return FileResponse(path, media_type="text/javascript; charset=utf-8", headers=headers)


def compressed(source: Path, target: Path) -> Path:
    """Return `target`, the compressed `source`; it is made once and then kept."""
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f"{target.name}.{secrets.token_hex(4)}")
        part.write_bytes(gzip.compress(source.read_bytes(), 9, mtime=0))
        os.replace(part, target)
    return target
