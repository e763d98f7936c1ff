"""Editions of a category: walking over data blocks by one, and finding out by which one a file was written."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from asterix import generated

from algorithms.errors import InputError
from backend.files.asterix.categories import CATEGORIES
from backend.files.asterix.layout import RecordLayout, UndecodableError, fspec_end
from backend.files.report import Findings

_WANTED = re.compile(r"(?:(?:cat)?0*(\d{1,3})\s*[:=]\s*)?(\d{1,2})\.(\d{1,2})", re.IGNORECASE)

Block = tuple[int, int]
"""Position of the first octet of a data block, and of the one behind its last."""


class Edition:
    """One edition of a category, ready to walk over data blocks.

    CAT 001 has two layouts, and the first bit of item 020 says which one a record follows; that item stands at the
    same place in both.
    """

    def __init__(self, specification: Any) -> None:
        self.number: tuple[int, int] = specification.cv_edition
        uap = specification.cv_uap
        self.records: tuple[Any, ...] = (
            tuple(uap.cv_uaps[name] for name in ("plot", "track")) if hasattr(uap, "cv_uaps") else (uap.cv_record,)
        )
        self.layouts = [RecordLayout(r) for r in self.records]

    @property
    def text(self) -> str:
        """Such as 1.32."""
        return f"{self.number[0]}.{self.number[1]}"

    def walk(self, data: bytes, block: Block, number: int) -> tuple[int, int]:
        """Note the records of one block; the first of them is record `number` of the file.

        Returns how many decoded, and the position behind them: the end of the block, or that of a record which does
        not decode. What follows such a one in its block cannot be told apart.
        """
        position, end = block[0] + 3, block[1]
        plots, tracks = self.layouts[0], self.layouts[-1]
        count = 0
        try:
            while position < end:
                behind = position
                while data[behind] & 1:
                    behind += 1
                behind += 1
                fspec = data[position:behind]
                layout = tracks if tracks is not plots and _is_track(data, behind, fspec[0]) else plots
                form = layout.forms.get(fspec) or layout.form(fspec)
                here = [number + count, position, behind]
                behind += form.lead
                for sizer, fixed in form.steps:
                    behind = sizer(data, behind)
                    here.append(behind)
                    behind += fixed
                if behind > end:
                    break
                form.found.extend(here)
                position = behind
                count += 1
        except (IndexError, UndecodableError):
            pass
        return count, position

    def explain(self, data: bytes, position: int, end: int) -> str:
        """Say why the record at `position` does not decode."""
        block = data[position:end]
        layout = self.layouts[0]
        try:
            if _is_track(block, fspec_end(block, 0), block[0]):
                layout = self.layouts[-1]
        except IndexError:
            pass
        return layout.explain(block, 0, len(block))


def _is_track(data: bytes, behind: int, flags: int) -> bool:
    # Item 010, two octets, stands before item 020.
    return bool(flags & 0x40) and bool(data[behind + (2 if flags & 0x80 else 0)] & 0x80)


@dataclass(frozen=True)
class Wanted:
    """The option `edition`: such as "1.30" for every category that has it, or "48:1.30 34:1.27"."""

    by_category: Mapping[int, tuple[int, int]]
    anywhere: tuple[int, int] | None

    def of(self, category: int) -> tuple[int, int] | None:
        """The edition that the user wants for a category."""
        own = self.by_category.get(category)
        if own is None and self.anywhere in editions_of(category):
            own = self.anywhere
        return own


def editions_of(category: int) -> dict[tuple[int, int], Any]:
    """Editions of a category that libasterix knows, newest first."""
    manifest: Mapping[str, Any] = generated.manifest
    found = {s.cv_edition: s for s in manifest["CATS"].get(category, ())}
    return {number: found[number] for number in sorted(found, reverse=True)}


def wanted_editions(text: str | None) -> Wanted:
    """Read the option `edition`. Raises InputError where it names what does not exist."""
    by_category: dict[int, tuple[int, int]] = {}
    anywhere: tuple[int, int] | None = None
    for word in (text or "").replace(",", " ").replace(";", " ").split():
        match = _WANTED.fullmatch(word)
        number = None if match is None else (int(match[2]), int(match[3]))
        if match is not None and number is not None and match[1]:
            category = int(match[1])
            if category in CATEGORIES and number in editions_of(category):
                by_category[category] = number
                continue
        elif number is not None and any(number in editions_of(c) for c in CATEGORIES):
            anywhere = number
            continue
        known = "; ".join(f"{c}: {', '.join(_text(n) for n in editions_of(c))}" for c in sorted(CATEGORIES))
        raise InputError(
            f"There is no edition {word!r}. Known are, by category: {known}.",
            pointer="/options/edition",
            remedy='Write "1.30", or "48:1.30 34:1.27", or leave it out.',
            code="edition_unknown",
        )
    return Wanted(by_category, anywhere)


def choose_edition(
    data: bytes, category: int, tried: Sequence[Block], wanted: Wanted, findings: Findings
) -> tuple[Edition, str]:
    """Take the edition that the user wants, or the one by which most of the tried blocks decode.

    Of editions that decode equally many the newest is taken. Returns the edition and its name, with those of the
    editions that would have done as well.
    """
    known = editions_of(category)
    decoded = {number: _decoded(Edition(s), data, tried) for number, s in known.items()}
    best = max(decoded, key=lambda number: (decoded[number], number))
    name = f"CAT {category:03d}"
    own = wanted.of(category)
    if own is None:
        alike = [_text(number) for number in known if decoded[number] == decoded[best] and number != best]
        also = f" (= {', '.join(alike)})" if alike else ""
        return Edition(known[best]), f"{name} {_text(best)}{also}"
    if decoded[own] < decoded[best]:
        findings.warn(
            "edition_misfit",
            f"By edition {_text(own)} {decoded[own]} of {len(tried)} data blocks of {name} decode, by edition "
            f"{_text(best)} {decoded[best]}.",
            decoded[best] - decoded[own],
        )
    return Edition(known[own]), f"{name} {_text(own)}"


def _decoded(edition: Edition, data: bytes, blocks: Sequence[Block]) -> int:
    return sum(edition.walk(data, block, 0)[1] == block[1] for block in blocks)


def _text(number: tuple[int, int]) -> str:
    return f"{number[0]}.{number[1]}"
