"""All records of a category as columns."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints
from backend.files.asterix.categories import Category
from backend.files.asterix.edition import Edition
from backend.files.asterix.fields import ABSENT, Field, Octets, field_of
from backend.files.asterix.layout import RecordLayout


class Records:
    """What an edition has walked over, in the order of the file.

    Attributes
    ----------
    category : what they are
    number : (M,) int, number of the record in the file
    position : (M,) int, of its first octet
    """

    def __init__(self, category: Category, edition: Edition, octets: Octets) -> None:
        self.category = category
        self._octets = octets
        self._parts = [
            _Part(record, layout, category) for record, layout in zip(edition.records, edition.layouts, strict=True)
        ]
        number = np.concatenate([p.number for p in self._parts])
        self._order = np.argsort(number, kind="stable")
        self.number: Ints = number[self._order]
        self.position: Ints = np.concatenate([p.position for p in self._parts])[self._order]

    def __len__(self) -> int:
        return len(self.number)

    def numbers(self, role: str) -> Floats:
        """Values of a role in SI units and radians, NaN where a record has none; read-only where none has any."""
        if not self._has(role):
            return constant(np.nan, len(self))
        columns = []
        for part in self._parts:
            out = np.full(len(part.number), np.nan)
            for one, position in part.places(role):
                value = one.number(self._octets, position)
                out = np.where(np.isnan(out), value, out)
            columns.append(out)
        return np.concatenate(columns)[self._order]

    def codes(self, role: str) -> Ints:
        """Values of a role as the bits stand there, -1 where a record has none; read-only where none has any."""
        if not self._has(role):
            return constant(-1, len(self))
        columns = []
        for part in self._parts:
            out = np.full(len(part.number), -1, np.int64)
            for one, position in part.places(role):
                out = np.where(out < 0, one.raw(self._octets, position), out)
            columns.append(out)
        return np.concatenate(columns)[self._order]

    def _has(self, role: str) -> bool:
        return any((at != ABSENT).any() for part in self._parts for _, at in part.places(role))


def constant(value: float, count: int) -> NDArray[Any]:
    """One value so many times, which takes the room of one."""
    return np.broadcast_to(np.array(value), count)


class _Part:
    """The records of one layout, form after form."""

    def __init__(self, record: object, layout: RecordLayout, category: Category) -> None:
        self._found = [
            (form.places, np.frombuffer(form.found, np.int64).reshape(-1, form.width))
            for form in layout.forms.values()
            if form.found
        ]
        self._fields: dict[str, list[tuple[str, Field]]] = {
            role: [(path[0], one) for path in paths if (one := field_of(record, path)) is not None]
            for role, paths in category.places.items()
        }
        empty = np.empty(0, np.int64)
        self.number: Ints = np.concatenate([empty, *(found[:, 0] for _, found in self._found)])
        self.position: Ints = np.concatenate([empty, *(found[:, 1] for _, found in self._found)])

    def places(self, role: str) -> list[tuple[Field, Ints]]:
        """Fields of a role, each with the positions of its item."""
        return [(one, self._positions(item)) for item, one in self._fields.get(role, ())]

    def _positions(self, item: str) -> Ints:
        columns = [np.empty(0, np.int64)]
        for places, found in self._found:
            if item in places:
                column, offset = places[item]
                columns.append(found[:, column] + offset)
            else:
                columns.append(np.full(len(found), ABSENT, np.int64))
        return np.concatenate(columns)
