"""Which version of the program, and of what it is built from, is running."""

from __future__ import annotations

import importlib.util
import platform
import re
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_NAMED = ("fastapi", "starlette", "uvicorn", "pydantic", "numpy", "scipy", "numba", "plotly", "dask", "distributed")


@cache
def program_version() -> str:
    """Return the version of Filter Room."""
    try:
        return version("filterroom")
    except PackageNotFoundError:
        return "checkout"


@cache
def library_versions() -> dict[str, str]:
    """Return the versions of Python and of the main libraries, without importing them."""
    return {"python": platform.python_version()} | {name: version(name) for name in _NAMED}


def plotly_js_path() -> Path:
    """Return the plotly.js that comes with the installed plotly package, without importing plotly."""
    spec = importlib.util.find_spec("plotly")
    assert spec is not None
    assert spec.origin is not None
    return Path(spec.origin).parent / "package_data" / "plotly.min.js"


@cache
def plotly_js_version() -> str:
    """Return the version that plotly.js says it is, in its first lines."""
    with plotly_js_path().open(encoding="utf-8") as source:
        found = re.search(r"plotly\.js v(\d+\.\d+\.\d+)", source.read(2000))
    assert found is not None, "plotly.min.js does not name its version"
    return found.group(1)
