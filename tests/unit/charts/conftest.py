from collections.abc import Callable
from typing import Any

import pytest

from backend.charts.view import Figure


@pytest.fixture
def traces_of() -> Callable[..., list[dict[str, Any]]]:
    """Traces of a figure by role and, where given, by a part of their name."""

    def find(drawn: Figure, role: str, name: str = "") -> list[dict[str, Any]]:
        return [t for t in drawn["data"] if t["meta"]["role"] == role and name in t["name"]]

    return find


@pytest.fixture
def note_of() -> Callable[[Figure, str], str | None]:
    """Text of the note with this code, None where the figure has no such note."""

    def find(drawn: Figure, code: str) -> str | None:
        return next((n["text"] for n in drawn["layout"]["meta"]["notes"] if n["code"] == code), None)

    return find
