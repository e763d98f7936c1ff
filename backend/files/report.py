"""What a reader found: rows that it refused, things the user must know, and the totals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from algorithms.recording import Kind

# A warning names this many examples; its count says how many there are.
_EXAMPLES = 8


@dataclass(frozen=True)
class Rejection:
    """One row that was not used. `row` counts data rows from 1 and goes on from file to file, as `Recording.row`."""

    row: int
    code: str
    detail: str
    file: str = ""


@dataclass(frozen=True)
class ReadWarning:
    """Something that was noticed, or decided for the user: stable code, words, how often."""

    code: str
    detail: str
    count: int = 1


@dataclass(frozen=True)
class ReadReport:
    """Totals of one reading. Each row read is either accepted or among the rejections."""

    kind: Kind
    format: str
    rows_read: int
    rows_accepted: int
    rejections: tuple[Rejection, ...]
    warnings: tuple[ReadWarning, ...]
    time_span_s: tuple[float, float]
    """First and last `time_s`."""

    @property
    def rows_rejected(self) -> int:
        """How many rows were refused."""
        return self.rows_read - self.rows_accepted


@dataclass
class Findings:
    """Collects rejections and warnings while one file (or what was merged from several) is worked on."""

    file: str = ""
    rejections: list[Rejection] = field(default_factory=list)
    warnings: list[ReadWarning] = field(default_factory=list)

    def reject(self, row: int, code: str, detail: str, *, file: str | None = None) -> None:
        """List one row as not used."""
        self.rejections.append(Rejection(row, code, detail, self.file if file is None else file))

    def warn(self, code: str, detail: str, count: int = 1) -> None:
        """Add a warning."""
        self.warnings.append(ReadWarning(code, detail, count))

    def absorb(self, other: Findings, row_offset: int) -> None:
        """Take over what was found in one file; its rows follow `row_offset` earlier ones."""
        self.rejections += [replace(r, row=r.row + row_offset) for r in other.rejections]
        self.warnings += other.warnings


def some(items: Iterable[object]) -> str:
    """Return the first few items as text, and how many more there are."""
    texts = [str(i) for i in items]
    shown = ", ".join(texts[:_EXAMPLES])
    return shown if len(texts) <= _EXAMPLES else f"{shown} and {len(texts) - _EXAMPLES} more"
