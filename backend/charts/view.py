"""What a chart is given, and what a chart declares about itself.

To add a chart, write one module in this package with a constant `CHART`. Its `draw(view, options)` returns a Plotly
figure as a plain dictionary whose numbers are NumPy arrays; `backend.charts.figure` has the parts it is made of. A
chart never fails for want of data: it returns a figure that says why it is empty (`figure.not_applicable`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Kind, Recording
from algorithms.result import Table
from algorithms.texts import Texts

Figure = dict[str, Any]
Source = Literal["run", "recording"]
# What recordings must share so that runs on them can be drawn into one chart: everything, the origin of time, or
# that and the origin of the local frame.
Overlay = Literal["recording", "time", "frame"]

# Marks are drawn as points of their own up to this many times `points` in a chart; beyond, every k-th one is drawn.
MARKS_PER_POINT = 3
# So many entries have `points` for each of their curves; more share them.
FULL_CURVES = 4
FEWEST_POINTS = 100


@dataclass(frozen=True)
class ChartOptions:
    """How much to draw: `points` for each curve; `full` = everything, in double precision.

    What stands for marks is shared among the `entries` of the chart: a browser takes its time by points, whosever
    they are.
    """

    points: int = 2000
    full: bool = False
    entries: int = 1

    @property
    def curve_points(self) -> int | None:
        """Most points of one entry's curve, None = all."""
        if self.full:
            return None
        return max(self.points * FULL_CURVES // max(self.entries, FULL_CURVES), min(self.points, FEWEST_POINTS))

    @property
    def marks(self) -> int | None:
        """Most points of one entry that stand for marks, None = all."""
        return None if self.full else max(self.points * MARKS_PER_POINT // max(self.entries, 1), FEWEST_POINTS)

    @property
    def doubted(self) -> int | None:
        """Most points of one entry that stand for marks it did not simply use, None = all."""
        return None if self.marks is None else self.marks // 4

    def number(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values for drawing: 4 bytes each (8 mm at 100 km), or as they are where `full` is asked for."""
        return values if self.full else values.astype(np.float32)


@dataclass(frozen=True)
class Entry:
    """One algorithm of a run: its label, its place among the entries (colour and dash), its result on demand.

    `table(name)` gives the entry's rows alone; an unknown name gives a table without columns.
    """

    label: str
    index: int
    algorithm: str
    table: Callable[[str], Table]
    arrays: Callable[[], Mapping[str, NDArray[Any]]]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    """As the run gave them; what is missing has its default."""
    key: str = ""
    """The same for the same tables; empty where nobody vouches for that."""


def swept_columns(table: Table) -> list[str]:
    """Columns of swept values, `scenario.NAME` or `LABEL.NAME`; a point in a model's name (cv_0.05) makes none."""
    return [name for name in table.names if "." in name and name.rpartition(".")[2].isidentifier()]


@dataclass(frozen=True)
class RunView:
    """What the charts of a run see; entries may come from several runs.

    Where these worked on different recordings, `others` holds those after the first; a chart gets such a view only
    as far as its `overlay` allows.
    """

    recording: Recording
    entries: tuple[Entry, ...]
    others: tuple[Recording, ...] = ()
    legs: tuple[tuple[str, float, float], ...] = ()
    """Named intervals of a scenario: name, start and stop in seconds."""
    scenario: str = ""
    """Name of the preset that trials were simulated from."""

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """All recordings that the entries worked on."""
        return (self.recording, *self.others)

    @property
    def time_s(self) -> NDArray[np.float64]:
        """(M,) instants of the marks of all recordings, s."""
        return np.concatenate([recording.time_s for recording in self.recordings])


@dataclass(frozen=True)
class RecordingView:
    """What the charts of a recording see."""

    recording: Recording


@dataclass(frozen=True)
class Chart:
    """A named chart: what it is drawn from, the tables it reads, the kinds of recording it is for (empty = all).

    Of trials it may want several algorithms, a number of swept values, or one parameter of that name among them.
    """

    name: str
    title: str
    source: Source
    needs: tuple[str, ...]
    draw: Callable[[Any, ChartOptions], Figure]
    kinds: tuple[Kind, ...] = ()
    overlay: Overlay = "recording"
    least_entries: int = 1
    least_sweeps: int = 0
    swept: str = ""

    def suits(self, entries: int, sweep: Collection[str]) -> bool:
        """Whether so many algorithms and these swept values (`scenario.sigma_m`) give it something to show."""
        names = {name.rpartition(".")[2] for name in sweep}
        return (
            entries >= self.least_entries
            and len(sweep) >= self.least_sweeps
            and (not self.swept or self.swept in names)
        )

    def takes(self, kind: Kind) -> bool:
        """Whether the chart has anything to say about recordings of this kind."""
        return not self.kinds or kind in self.kinds


def rows_of_label(table: Table, label: str) -> Table:
    """One entry's rows of a table that holds the rows of all entries, without the column `label`."""
    if "label" not in table.columns:
        return table
    labels = table.columns["label"]
    assert isinstance(labels, Texts)
    return table.without("label").take(labels.are(label))
