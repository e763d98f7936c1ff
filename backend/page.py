"""Where the files of the page are: its modules, and the texts of its languages."""

from __future__ import annotations

from pathlib import Path

_BACKEND = Path(__file__).resolve().parent


def page_folder() -> Path:
    """Return the folder of the page: inside the package in a wheel, at the top of a checkout."""
    installed = _BACKEND / "static"
    return installed if installed.is_dir() else _BACKEND.parent / "frontend"
