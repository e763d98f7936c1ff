"""A column of texts: codes into a few distinct ones, four bytes a row however long the texts are."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Texts(Sequence[str | None]):
    """Reads like a tuple of texts, None where there is none.

    Attributes
    ----------
    codes : (n,) int32, index into `categories`
    categories : the distinct texts; one may be unused
    """

    codes: NDArray[np.int32]
    categories: tuple[str | None, ...]

    @classmethod
    def of(cls, values: Iterable[str | None]) -> Texts:
        """Number texts in the order in which they first appear."""
        if isinstance(values, Texts):
            return values
        seen: dict[str | None, int] = {}
        codes = np.fromiter((seen.setdefault(v, len(seen)) for v in values), np.int32)
        return cls(codes, tuple(seen))

    @classmethod
    def coded(cls, codes: NDArray[np.integer], categories: Sequence[str | None]) -> Texts:
        """Take codes as they are; the empty text becomes None."""
        return cls(codes.astype(np.int32), tuple(text or None for text in categories))

    @classmethod
    def repeated(cls, value: str | None, count: int) -> Texts:
        """One text in every row."""
        return cls(np.zeros(count, np.int32), (value,))

    @classmethod
    def joined(cls, parts: Iterable[Texts]) -> Texts:
        """Put columns under each other."""
        seen: dict[str | None, int] = {}
        codes = [np.empty(0, np.int32)]
        for part in parts:
            new = np.array([seen.setdefault(text, len(seen)) for text in part.categories], np.int32)
            codes.append(new[part.codes] if len(new) else part.codes)
        return cls(np.concatenate(codes), tuple(seen))

    def __len__(self) -> int:
        """Return the number of rows."""
        return int(self.codes.size)

    @overload
    def __getitem__(self, at: int) -> str | None: ...

    @overload
    def __getitem__(self, at: slice | NDArray[np.integer] | NDArray[np.bool_]) -> Texts: ...

    def __getitem__(self, at: int | slice | NDArray[np.integer] | NDArray[np.bool_]) -> str | Texts | None:
        """Return the text of a row, or the column of some rows."""
        if isinstance(at, slice | np.ndarray):
            return Texts(self.codes[at], self.categories)
        return self.categories[int(self.codes[at])]

    def __iter__(self) -> Iterator[str | None]:
        """Yield the text of each row."""
        return map(self.categories.__getitem__, self.codes.tolist())

    def __eq__(self, other: object) -> bool:
        """Compare row by row with any sequence of texts."""
        if not isinstance(other, Sequence) or isinstance(other, str):
            return NotImplemented
        return len(self) == len(other) and all(a == b for a, b in zip(self, other, strict=True))

    __hash__ = None  # type: ignore[assignment]  # as a list: it is compared by its rows

    def are(self, text: str | None) -> NDArray[np.bool_]:
        """(n,): the rows that hold this text; None and the empty text are the same."""
        return self.mapped(np.array([(category or "") == (text or "") for category in self.categories], np.bool_))

    def mapped(self, values: NDArray[Any]) -> NDArray[Any]:
        """(n,): what stands in `values` for the category of each row."""
        return values[self.codes] if len(self.categories) else values[:0]

    def words(self) -> NDArray[np.object_]:
        """(n,) of str, empty where there is none."""
        return self.mapped(np.array([text or "" for text in self.categories], object))
