"""What is given to a command as `name=value`: JSON where it is JSON, text otherwise."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from backend.cli.terminal import UsageError

if TYPE_CHECKING:
    from pydantic import BaseModel


def assignments(given: Sequence[str], option: str) -> dict[str, Any]:
    """Return the names with their values.

    Raises
    ------
    UsageError
        One has no name or no equals sign, or a name is given twice.
    """
    out: dict[str, Any] = {}
    for text in given:
        name, sign, value = text.partition("=")
        name = name.strip()
        if not sign or not name:
            raise UsageError(f"{option} {text}: write it as name=value.")
        if name in out:
            raise UsageError(f"{option} {name} is given twice.")
        out[name] = _value(value)
    return out


def checked_model(model: type[BaseModel], given: dict[str, Any], option: str, *, strict: bool) -> Any:
    """Return the validated values, or say of the first wrong one what is wrong with it.

    `strict` takes every value for what it is: the text "10" is no number.
    """
    from pydantic import ValidationError

    from backend.http.problems import items_of

    try:
        return model.model_validate_json(json.dumps(given), strict=strict)
    except ValidationError as error:
        first, item = error.errors()[0], items_of(error)[0]
        name = ".".join(str(step) for step in first["loc"])
        if first["type"] == "extra_forbidden" and len(first["loc"]) == 1:
            raise UsageError(f"{option} {name}: there is only {', '.join(model.model_fields)}.") from error
        raise UsageError(f"{option} {name}: {item.detail}") from error


def _value(text: str) -> Any:
    try:
        value = json.loads(text, parse_constant=_no_number)
    except ValueError:
        return text
    return value


def _no_number(word: str) -> Any:
    raise ValueError(word)
