"""Where the items of a record lie, told from libasterix's specification of an edition.

libasterix decodes an item into objects, some 15 000 records a second. A file has millions, and few of their items are
needed, so its specification is turned into lengths here: a record is walked over from item to item, and only where
the wanted ones begin is kept. Records with the same field specification (FSPEC) have the same items, and between two
items of variable length everything has a fixed place; so a record costs one look-up and one step for each variable
item. Values are taken out afterwards, all records at a time (`fields`).

A record is taken as whole or not at all (libasterix's strict parsing); a test holds the two against each other.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from asterix import base

Sizer = Callable[[bytes, int], int]
"""(data, position of the item) -> position behind it."""


class UndecodableError(ValueError):
    """The bytes are no record of this edition."""


@dataclass
class Form:
    """All records with one FSPEC, and where their items lie.

    `found` holds for each record its number, its position, the position behind the FSPEC, and the position behind each
    variable item: `width` numbers. `places` gives for an item which of these it follows (2 = the FSPEC) and how many
    bytes later it begins.
    """

    lead: int
    steps: tuple[tuple[Sizer, int], ...]
    places: dict[str, tuple[int, int]]
    found: array[int] = field(default_factory=lambda: array("q"))

    @property
    def width(self) -> int:
        """Numbers kept for one record."""
        return 3 + len(self.steps)


@dataclass(frozen=True)
class _Item:
    name: str
    size: int
    """Fixed length in bytes; 0 = variable."""
    sizer: Sizer


class RecordLayout:
    """The items of one user application profile (UAP), and the forms of the records met so far."""

    def __init__(self, record: Any) -> None:
        self._items = _items_of(record)
        self._longest = int(record.cv_fspec_max_bytes)
        self.forms: dict[bytes, Form] = {}

    def form(self, fspec: bytes) -> Form:
        """Lay out the records with this FSPEC. Raises UndecodableError where the edition has no such items."""
        lead = 0
        steps: list[tuple[Sizer, int]] = []
        places: dict[str, tuple[int, int]] = {}
        for item in self._present(fspec):
            places[item.name] = (2 + len(steps), steps[-1][1] if steps else lead)
            if not item.size:
                steps.append((item.sizer, 0))
            elif steps:
                steps[-1] = (steps[-1][0], steps[-1][1] + item.size)
            else:
                lead += item.size
        form = self.forms[fspec] = Form(lead, tuple(steps), places)
        return form

    def _present(self, fspec: bytes) -> list[_Item]:
        if len(fspec) > self._longest:
            raise UndecodableError(f"its field specification has {len(fspec)} octets, and {self._longest} are allowed")
        out: list[_Item] = []
        for frn in _frns(fspec):
            item = self._items[frn] if frn < len(self._items) else None
            if item is None:
                raise UndecodableError(f"its field specification asks for field {frn + 1}, which is not defined")
            out.append(item)
        if not out:
            raise UndecodableError("it has no items")
        return out

    def explain(self, data: bytes, position: int, end: int) -> str:
        """Say what is wrong with the record at `position`."""
        block = data[:end]
        try:
            behind = fspec_end(block, position)
            for item in self._present(block[position:behind]):
                name = item.name
                behind = item.sizer(block, behind)
                if behind > end:
                    return f"item {name} runs {behind - end} bytes past the end of the data block"
        except IndexError:
            return "it is cut off by the end of the data block"
        except UndecodableError as e:
            return str(e)
        return "it decodes by itself, but not in its place"


def fspec_end(data: bytes, position: int) -> int:
    """Position behind the field specification. Raises IndexError where the data end within it."""
    while data[position] & 1:
        position += 1
    return position + 1


def _frns(fspec: bytes) -> list[int]:
    """Positions (from 0) of the fields that are present."""
    return [7 * i + bit for i, octet in enumerate(fspec) for bit in range(7) if octet & (0x80 >> bit)]


def _items_of(record: Any) -> list[_Item | None]:
    items: list[_Item | None] = []
    for uap_item in record.cv_items_list:
        if issubclass(uap_item, base.UapItem):
            spec = uap_item.cv_non_spare
            size, sizer = _size(variation_of(spec))
            items.append(_Item(spec.cv_name, size, sizer))
        elif issubclass(uap_item, base.UapItemRFS):
            items.append(_Item("RFS", 0, _random_fields(items)))
        else:
            items.append(None)
    return items


def variation_of(spec: Any) -> Any:
    """The structure of an item; where it depends on other items, the one that libasterix parses by default."""
    rule = spec.cv_rule
    return getattr(rule, "cv_variation", None) or rule.cv_default_variation


def bits_of(variation: Any) -> int:
    """Length of an element or a group in bits."""
    return int(variation.cv_bit_size)


def _size(variation: Any) -> tuple[int, Sizer]:
    """Fixed length in bytes (0 = variable) and the sizer of a structure."""
    if issubclass(variation, base.Element | base.Group):
        size = bits_of(variation) // 8
        return size, lambda _, position: position + size
    if issubclass(variation, base.Extended):
        return 0, _extended(variation)
    if issubclass(variation, base.Repetitive):
        return 0, _repetitive(variation)
    if issubclass(variation, base.Explicit):
        return 0, _explicit
    return 0, _compound(variation)


def part_bits(part: Sequence[Any]) -> int:
    """Length in bits of one part of an extended item; None stands for its extension bit."""
    return sum(1 if item is None else item[1] for item in part)


def _extended(variation: Any) -> Sizer:
    parts = [(part_bits(p) // 8, p[-1] is None) for p in variation.cv_items_list]
    if all(part == (1, True) for part in parts):
        most = len(parts)

        def octets(data: bytes, position: int) -> int:
            last = position + most
            while data[position] & 1:
                position += 1
                if position == last:
                    raise UndecodableError("an extended item goes on longer than its edition allows")
            return position + 1

        return octets

    def sized(data: bytes, position: int) -> int:
        for size, has_extension in parts:
            position += size
            if not (has_extension and data[position - 1] & 1):
                return position
        raise UndecodableError("an extended item goes on longer than its edition allows")

    return sized


def _repetitive(variation: Any) -> Sizer:
    inner = variation.cv_variation
    if variation.cv_rep_bytes is None:
        size = (bits_of(inner) + 1) // 8

        def until_last(data: bytes, position: int) -> int:
            position += size
            while data[position - 1] & 1:
                position += size
            return position

        return until_last
    counter = int(variation.cv_rep_bytes)
    size, sizer = _size(inner)

    def counted(data: bytes, position: int) -> int:
        count = data[position] if counter == 1 else int.from_bytes(data[position : position + counter], "big")
        position += counter
        if size:
            return position + count * size
        for _ in range(count):
            position = sizer(data, position)
        return position

    return counted


def _explicit(data: bytes, position: int) -> int:
    size = data[position]
    if not size:
        raise UndecodableError("an explicit item claims a length of zero")
    return position + size


def _compound(variation: Any) -> Sizer:
    parts = [None if spec is None else _size(variation_of(spec)) for spec in variation.cv_items_list]
    longest = int(variation.cv_fspec_max_bytes)
    known: dict[bytes, tuple[int, tuple[Sizer, ...]]] = {}

    def lay_out(fspec: bytes) -> tuple[int, tuple[Sizer, ...]]:
        present = [parts[i] if i < len(parts) else None for i in _frns(fspec)]
        if len(fspec) > longest or None in present:
            raise UndecodableError("a compound item has subitems that its edition does not define")
        sizes = [p for p in present if p is not None]
        if all(size for size, _ in sizes):
            known[fspec] = (sum(size for size, _ in sizes), ())
        else:
            known[fspec] = (0, tuple(sizer for _, sizer in sizes))
        return known[fspec]

    def sized(data: bytes, position: int) -> int:
        behind = fspec_end(data, position)
        fspec = data[position:behind]
        fixed, sizers = known.get(fspec) or lay_out(fspec)
        behind += fixed
        for sizer in sizers:
            behind = sizer(data, behind)
        return behind

    return sized


def _random_fields(items: list[_Item | None]) -> Sizer:
    """Sizer of the random field sequence: a count, then as many field numbers with their items."""

    def sized(data: bytes, position: int) -> int:
        count = data[position]
        position += 1
        for _ in range(count):
            frn = data[position]
            item = items[frn - 1] if 0 < frn <= len(items) else None
            if item is None or item.name == "RFS":
                raise UndecodableError(f"its random field sequence names field {frn}, which is not defined")
            position = item.sizer(data, position + 1)
        return position

    return sized
