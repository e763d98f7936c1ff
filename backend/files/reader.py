"""What a reader is, and how readers are found.

To add a format, write one module in this package with a constant `READER`:

1. `detect(source)` looks at the content (never at the name) and tells whether it is in this format.
2. `read(source)` gives a `Part`: the rows of one file in the order of the file, without a site. Rows that cannot
   serve are rejected in `source.findings`, everything decided for the user is a warning there.
3. It raises InputError only where nothing of the file can serve.

Merging, sorting, the site and the truth are the same for all formats and follow in `reading`.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property

import backend.files
from algorithms.errors import UnsupportedFormatError
from algorithms.recording import Floats, Kind, Recording
from algorithms.site import Origin, Site
from backend.files.containers import open_rows
from backend.files.content import Content
from backend.files.options import ReadLimits, ReadOptions
from backend.files.report import Findings
from backend.files.rows import Rows
from backend.files.truth_file import TruthPoints
from backend.files.turns import TurnMarks


@dataclass(frozen=True)
class Source:
    """One file on its way into a recording."""

    content: Content
    options: ReadOptions
    limits: ReadLimits
    findings: Findings
    origin: Origin | None = None
    """Zero of the local frame, where the site or the options tell it."""

    @cached_property
    def rows(self) -> Rows:
        """The table in the file; raises UnsupportedFormatError where there is none."""
        return open_rows(self.content, self.limits, wanted=self.options.columns())

    def has_columns(self, *names: str) -> bool:
        """Whether the content is a table with these columns."""
        try:
            return set(names) <= set(self.rows.names)
        except UnsupportedFormatError:
            return False


@dataclass(frozen=True)
class Part:
    """The rows of one file.

    Attributes
    ----------
    recording : rows in the order of the file; `row` counts from 1 within it
    epoch_s : the Unix second from which `time_s` counts; None = unknown start
    rows_in_file : all rows, those that the user's filter leaves out too
    rows_read : accepted and rejected rows
    truth_geodetic : (M, 3) float, latitude and longitude in rad, height in m: truth that still needs an origin
    plots_geodetic : (M, 2) float, latitude and longitude in rad: plots that still need an origin, NaN for the others
    station_columns : station -> column that names it in the file's header; empty where stations occur in the data
    site_defaults : accuracies that the format is known for, used where the site gives none
    site : the site that the file itself tells, used where the user gives none
    truth : true paths that the file holds beside its measurements
    marks : when the antennas of radars looked where; not None = the scans of the plots are to be numbered
    """

    recording: Recording
    epoch_s: int | None
    rows_in_file: int
    rows_read: int
    truth_geodetic: Floats | None = None
    plots_geodetic: Floats | None = None
    station_columns: Mapping[str, str] = field(default_factory=dict)
    site_defaults: Mapping[str, float] = field(default_factory=dict)
    site: Site | None = None
    truth: TruthPoints | None = None
    marks: TurnMarks | None = None


@dataclass(frozen=True)
class Reader:
    """A format: its stable name, words for it, what it can hold, how it is recognised and read.

    `options` names fields of `ReadOptions` that mean something to this format only; a page offers them. `read_truth`
    reads a file of this format that is given as truth.
    """

    name: str
    title: str
    kinds: tuple[Kind, ...]
    detect: Callable[[Source], bool]
    read: Callable[[Source], Part]
    options: tuple[str, ...] = ()
    read_truth: Callable[[Source], TruthPoints] | None = None


@cache
def readers_by_name() -> dict[str, Reader]:
    """All readers of this package."""
    out: dict[str, Reader] = {}
    for found in pkgutil.iter_modules(backend.files.__path__, "backend.files."):
        declared = getattr(importlib.import_module(found.name), "READER", None)
        if isinstance(declared, Reader):
            if declared.name in out:
                raise RuntimeError(f"two readers are called {declared.name!r}; the second is in {found.name}")
            out[declared.name] = declared
    # Lines without names are looked for first: to the readers of tables their first one looks like a line of names.
    return dict(sorted(out.items(), key=lambda item: bool(item[1].kinds)))
