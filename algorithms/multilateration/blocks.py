"""What stands side by side in the lanes of a filter: trials of one target, or the targets of a single trial.

Lanes do not know of each other, so a recording of many targets is filtered sixteen targets at a time, and gives the
same bytes as one target at a time. Where targets have marks of different number the shorter lanes end earlier: what
they are given beyond their last mark is empty, and what they then report is not read.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.altitudes import Altitudes
from algorithms.multilateration.lanes import Marks, Report
from algorithms.recording import ToaMarks
from algorithms.toolbox.kernels import LANES

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class TrialsOfTarget:
    """The marks of one target, its trials first <= i < stop side by side."""

    target: int
    rows: Ints
    """Positions of its marks in the recording"""
    trials: slice
    whole: bool
    """Whether the recording has no other marks: rows in a block of memory are copied several times faster."""

    @property
    def size(self) -> int:
        """Marks of the longest lane."""
        return int(self.rows.size)

    @property
    def firsts(self) -> Ints:
        """(L,) position of each lane's first mark."""
        return np.repeat(self.rows[:1], self.trials.stop - self.trials.start)

    @property
    def numbers(self) -> Ints:
        """(L,) trial of each lane."""
        return np.arange(self.trials.start, self.trials.stop)

    def marks(self, recording: ToaMarks, toa_s: Floats, altitudes: Altitudes, k: int, stop: int) -> Marks:
        """Marks k <= i < stop of each lane."""
        chosen = self._chosen(k, stop)
        toa = np.ascontiguousarray(toa_s[chosen][:, :, self.trials])
        time = np.repeat(recording.time_s[chosen][:, None], toa.shape[2], axis=1)
        of = [
            np.ascontiguousarray(values[chosen][:, self.trials])
            for values in (altitudes.altitude_m, altitudes.extra_m2, altitudes.biased)
        ]
        return Marks(time, toa, *of)

    def put(self, into: Report, report: Report, highest: Ints, k: int, stop: int) -> int:
        """Write what the filter reported of these marks; return how many marks of trials they were."""
        chosen = self._chosen(k, stop)
        for ours, theirs in _pairs(into, report):
            ours[chosen, ..., self.trials] = theirs
        most = report.track.max(axis=0, initial=0)
        highest[self.target, self.trials] = np.maximum(highest[self.target, self.trials], most)
        return (stop - k) * most.size

    def _chosen(self, k: int, stop: int) -> slice | Ints:
        return slice(k, stop) if self.whole else self.rows[k:stop]


@dataclass(frozen=True)
class TargetsOfTrial:
    """The marks of several targets of a recording with a single trial, one target a lane; the longest first."""

    targets: tuple[int, ...]
    rows: tuple[Ints, ...]

    @property
    def size(self) -> int:
        """Marks of the longest lane."""
        return int(self.rows[0].size)

    @property
    def firsts(self) -> Ints:
        """(L,) position of each lane's first mark."""
        return np.array([rows[0] for rows in self.rows])

    @property
    def numbers(self) -> Ints:
        """(L,) trial of each lane."""
        return np.zeros(len(self.rows), np.int64)

    def marks(self, recording: ToaMarks, toa_s: Floats, altitudes: Altitudes, k: int, stop: int) -> Marks:
        """Marks k <= i < stop of each lane; empty ones where a lane has ended."""
        lanes = len(self.rows)
        marks = Marks(
            np.full((stop - k, lanes), np.nan),
            np.full((stop - k, toa_s.shape[1], lanes), np.nan),
            np.full((stop - k, lanes), np.nan),
            np.zeros((stop - k, lanes)),
            np.zeros((stop - k, lanes)),
        )
        for lane, rows in enumerate(self.rows):
            here = rows[k:stop]
            marks.time[: here.size, lane] = recording.time_s[here]
            marks.toa[: here.size, :, lane] = toa_s[here, :, 0]
            marks.altitude[: here.size, lane] = altitudes.altitude_m[here, 0]
            marks.altitude_extra[: here.size, lane] = altitudes.extra_m2[here, 0]
            marks.altitude_biased[: here.size, lane] = altitudes.biased[here, 0]
        return marks

    def put(self, into: Report, report: Report, highest: Ints, k: int, stop: int) -> int:
        """Write what the filter reported of these marks; return how many there were."""
        done = 0
        for lane, (target, rows) in enumerate(zip(self.targets, self.rows, strict=True)):
            here = rows[k:stop]
            done += here.size
            for ours, theirs in _pairs(into, report):
                ours[here, ..., 0] = theirs[: here.size, ..., lane]
            most = report.track[: here.size, lane].max(initial=0)
            highest[target, 0] = max(highest[target, 0], most)
        return done


def _pairs(into: Report, report: Report) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]:
    """Arrays of the same name that are kept at all."""
    for name in Report._fields:
        ours, theirs = getattr(into, name), getattr(report, name)
        if ours.shape[0]:
            yield ours, theirs


Block = TrialsOfTarget | TargetsOfTrial


def blocks_of(recording: ToaMarks, trials: int) -> Iterator[Block]:
    """Cut a recording into blocks of at most LANES lanes."""
    rows = recording.rows_by_target()
    present = [target for target, here in enumerate(rows) if here.size]
    if trials == 1 and len(present) > 1:
        # Lanes of like length: little is computed in vain.
        longest = sorted(present, key=lambda target: -rows[target].size)
        for first in range(0, len(longest), LANES):
            chosen = tuple(longest[first : first + LANES])
            yield TargetsOfTrial(chosen, tuple(rows[target] for target in chosen))
        return
    for target in present:
        for first in range(0, trials, LANES):
            part = slice(first, min(first + LANES, trials))
            yield TrialsOfTarget(target, rows[target], part, rows[target].size == len(recording))


def run_beside(run: Callable[[Iterator[Block]], None], blocks: Sequence[Block], *, threads: int) -> None:
    """Let so many threads run blocks, each taking the next one that is left; kernels do not hold the interpreter.

    Blocks do not know of each other and write to rows of their own: whoever runs them, the bytes are the same.
    """
    if threads == 1 or len(blocks) == 1:
        run(iter(blocks))
        return
    # A deque gives each of its members to one thread.
    left = deque(blocks)

    def taken() -> Iterator[Block]:
        with suppress(IndexError):
            while True:
                yield left.popleft()

    with ThreadPoolExecutor(threads, thread_name_prefix="blocks") as pool:
        for end in [pool.submit(run, taken()) for _ in range(threads)]:
            end.result()
