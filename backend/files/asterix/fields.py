"""Values of items, taken out of all records at a time; place, sign and scale come from libasterix's specification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from asterix import base
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints
from backend.files.asterix.layout import bits_of, part_bits, variation_of

Octets = NDArray[np.uint8]
ABSENT = -1
"""Position of an item that a record does not have."""

# To SI units and radians.
_UNITS = {
    "": 1.0,
    "s": 1.0,
    "m": 1.0,
    "m/s": 1.0,
    "NM": 1852.0,
    "NM/s": 1852.0,
    "FL": 30.48,
    "ft": 0.3048,
    "°": np.pi / 180,
}
_SIX_BIT = " ABCDEFGHIJKLMNOPQRSTUVWXYZ##### ###############0123456789######"


@dataclass(frozen=True)
class Field:
    """One value within an item.

    Attributes
    ----------
    first_bit, bits : its place, counted from the beginning of the item (or of its subitem)
    signed, scale : how the bits become a number in SI units or radians
    extensions : octets before it whose last bit must be set, in an extended item
    before : in a compound item, the lengths of the subitems that may stand before its own; None = no compound
    """

    first_bit: int
    bits: int
    signed: bool
    scale: float
    extensions: tuple[int, ...] = ()
    before: tuple[int, ...] | None = None

    def raw(self, octets: Octets, position: Ints) -> Ints:
        """The bits as numbers; -1 (or the most negative number, where it is signed) where the item is absent.

        `octets` must go on for nine bytes behind the last item.
        """
        absent = np.iinfo(np.int64).min if self.signed else -1
        out = np.full(len(position), absent, np.int64)
        where = position if self.before is None else self._subitem(octets, position)
        present = where >= 0
        for octet in self.extensions:
            present &= (octets[np.where(present, where + octet, 0)] & 1) == 1
        at = where[present] + self.first_bit // 8
        last = (self.first_bit % 8 + self.bits + 7) // 8
        value = np.zeros(len(at), np.int64)
        for i in range(last):
            value = (value << 8) | octets[at + i]
        value = (value >> (8 * last - self.first_bit % 8 - self.bits)) & ((1 << self.bits) - 1)
        if self.signed:
            value -= (value >> (self.bits - 1)) << self.bits
        out[present] = value
        return out

    def number(self, octets: Octets, position: Ints) -> Floats:
        """Values in SI units and radians, NaN where the item is absent."""
        raw = self.raw(octets, position)
        absent = raw == (np.iinfo(np.int64).min if self.signed else -1)
        return np.where(absent, np.nan, raw * self.scale)

    def _subitem(self, octets: Octets, position: Ints) -> Ints:
        assert self.before is not None
        present = position >= 0
        at = np.where(present, position, 0)
        # The subitem of interest is among the first seven, so its flag stands in the first octet.
        flags = octets[at]
        length = np.ones(len(at), np.int64)
        more = (flags & 1) == 1
        while more.any():
            more = more & ((octets[at + length] & 1) == 1)
            length += more
        length += (flags & 1) == 1
        for i, size in enumerate(self.before):
            length += np.where(flags & (0x80 >> i), size, 0)
        here = present & ((flags & (0x80 >> len(self.before))) != 0)
        return np.where(here, at + length, ABSENT)


def field_of(record: Any, path: Sequence[str]) -> Field | None:
    """Find a value such as ("040", "RHO"); None where this edition does not have it."""
    spec = record.cv_items_dict.get(path[0])
    if spec is None:
        return None
    variation = variation_of(spec)
    names = list(path[1:])
    before: tuple[int, ...] | None = None
    if issubclass(variation, base.Compound):
        listed = [None if s is None else s.cv_name for s in variation.cv_items_list]
        name = names.pop(0)
        if name not in listed[:7]:
            return None
        i = listed.index(name)
        variations = [variation_of(s) for s in variation.cv_items_list[: i + 1]]
        before = tuple(bits_of(v) // 8 for v in variations[:i])
        variation = variations[i]
    place = _within(variation, names)
    if place is None:
        return None
    first_bit, element, extensions = place
    signed, scale = _meaning(element)
    return Field(first_bit, bits_of(element), signed, scale, extensions, before)


def _within(variation: Any, names: list[str]) -> tuple[int, Any, tuple[int, ...]] | None:
    if issubclass(variation, base.Element):
        return None if names else (0, variation, ())
    if not names:
        return None
    if issubclass(variation, base.Group):
        bit = 0
        for item, bits in variation.cv_items_list:
            if _name(item) == names[0]:
                return bit, variation_of(item.cv_non_spare), ()
            bit += bits
    elif issubclass(variation, base.Extended):
        bit = 0
        extensions: tuple[int, ...] = ()
        for part in variation.cv_items_list:
            for item in part:
                if item is not None and _name(item[0]) == names[0]:
                    inner = variation_of(item[0].cv_non_spare)
                    return (bit, inner, extensions) if issubclass(inner, base.Element) else None
                bit += part_bits([item])
            extensions = (*extensions, bit // 8 - 1)
    return None


def _name(item: Any) -> str:
    return item.cv_non_spare.cv_name if issubclass(item, base.Item) else ""


def _meaning(element: Any) -> tuple[bool, float]:
    content = getattr(element.cv_rule, "cv_content", None)
    if content is None or not issubclass(content, base.ContentQuantity):
        return False, 1.0
    return content.cv_signedness is base.Signed, float(content.cv_lsb) * _UNITS[content.cv_unit]


def identifications(codes: Ints) -> tuple[Ints, tuple[str, ...]]:
    """Eight characters of six bits in each number -> index into names; -1 where there is none or it is blank."""
    found, index = np.unique(codes, return_inverse=True)
    texts = ["" if c < 0 else "".join(_SIX_BIT[(c >> s) & 63] for s in range(42, -1, -6)).strip() for c in found]
    return named(np.array(texts, object)[index])


def named(texts: NDArray[Any]) -> tuple[Ints, tuple[str, ...]]:
    """Index into the names in the order of their first appearance; -1 for an empty text."""
    found, first, index = np.unique(texts.astype(str), return_index=True, return_inverse=True)
    kept = [i for i in np.argsort(first) if found[i]]
    table = np.full(len(found), -1, np.int64)
    table[kept] = np.arange(len(kept))
    return table[index], tuple(str(found[i]) for i in kept)
