"""Presets: the same description of a scenario with other defaults."""

from __future__ import annotations

from typing import Any, TypeVar

from pydantic.fields import FieldInfo

from algorithms.spec import Parameters

P = TypeVar("P", bound=Parameters)


def preset(base: type[P], name: str, **defaults: Any) -> type[P]:
    """Return `base` under another name, with other defaults of some of its fields."""
    fields = base.model_fields
    namespace: dict[str, Any] = {
        "__annotations__": {field: fields[field].annotation for field in defaults},
        "__module__": base.__module__,
        "__doc__": base.__doc__,
    }
    for field, value in defaults.items():
        namespace[field] = FieldInfo.merge_field_infos(fields[field], default=value)
    made: type[P] = type(name, (base,), namespace)
    return made
