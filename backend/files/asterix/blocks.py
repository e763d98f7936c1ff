"""Data blocks: category, length, records. Where they lie in what a file or a network carried.

A length that cannot be right loses only the octets up to the next place where data blocks follow one another again.
"""

from __future__ import annotations

from array import array
from bisect import bisect_right
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints

HEADER = 3
_SHORTEST = HEADER + 1
# Categories that are assigned and met in recordings; only used to tell data blocks from chance.
_MET = (
    *(1, 2, 3, 4, 7, 8, 9, 10, 11, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 28, 30, 31, 32, 33, 34, 48),
    *(61, 62, 63, 65, 150, 205, 240, 247, 252, 253, 255),
)
KNOWN: NDArray[np.bool_] = np.isin(np.arange(256), _MET)
_IS_KNOWN = KNOWN.tolist()
_FIRST_WINDOW, _LARGEST_WINDOW = 1 << 12, 1 << 20


@dataclass(frozen=True)
class Payload:
    """Octets that hold data blocks one after another: a whole file, a datagram, one side of a connection."""

    start: int
    end: int
    time_s: float = np.nan
    """When it was received, where the container tells it."""


@dataclass(frozen=True)
class Gap:
    """Octets that are no data block."""

    start: int
    end: int
    reason: str


@dataclass
class Moved:
    """Octets that lay in pieces in the file and were put together behind it: their new places, old ones and times."""

    start: list[int] = field(default_factory=list)
    in_file: list[int] = field(default_factory=list)
    time_s: list[float] = field(default_factory=list)

    def note(self, start: int, in_file: int, time_s: float) -> None:
        """The piece that begins at `start` stood at `in_file`."""
        self.start.append(start)
        self.in_file.append(in_file)
        self.time_s.append(time_s)

    def file_position(self, position: int) -> int:
        """Where an octet stands in the file."""
        i = bisect_right(self.start, position) - 1
        return position if i < 0 else self.in_file[i] + position - self.start[i]


@dataclass(frozen=True)
class Carried:
    """What a container carried.

    Attributes
    ----------
    name : of the container
    data : the file, then what was put together from it
    payloads : in the order of the file
    times : what their times are: `utc` (of the epoch), `day` (of the day), or empty
    gaps : octets that carry nothing that is understood, each of which counts as a record
    """

    name: str
    data: bytes
    payloads: list[Payload]
    times: str = ""
    moved: Moved = field(default_factory=Moved)
    gaps: list[Gap] = field(default_factory=list)


@dataclass(frozen=True)
class Blocks:
    """Data blocks and gaps in the order of the file; a gap has the category -1."""

    start: Ints
    end: Ints
    category: Ints
    time_s: Floats
    reasons: dict[int, str]
    """Start of a gap -> why it is one."""

    def first(self, stop: int | None) -> Blocks:
        """Those before position `stop`."""
        part = slice(stop)
        return replace(
            self, start=self.start[part], end=self.end[part], category=self.category[part], time_s=self.time_s[part]
        )


def split(carried: Carried) -> Blocks:
    """Take payloads apart."""
    data = carried.data
    # Lists would take an object of its own for each number of a million blocks.
    starts, ends, times = array("q"), array("q"), array("d")
    reasons: dict[int, str] = {}
    broken: set[int] = set()

    def gap(start: int, end: int, reason: str, time_s: float) -> None:
        starts.append(start)
        ends.append(end)
        times.append(time_s)
        reasons[start] = reason
        broken.add(len(starts) - 1)

    octets = np.frombuffer(data, np.uint8)
    for payload in carried.payloads:
        position, end, time_s = payload.start, payload.end, payload.time_s
        while position < end:
            behind = _block_end(data, position, end)
            if behind:
                starts.append(position)
                ends.append(behind)
                times.append(time_s)
                position = behind
                continue
            found = next_block(octets, position + 1, end)
            gap(position, found, _reason(data, position, end), time_s)
            position = found
    for one in carried.gaps:
        gap(one.start, one.end, one.reason, np.nan)
    start = np.array(starts, np.int64)
    category = octets[np.minimum(start, len(data) - 1)].astype(np.int64)
    category[list(broken)] = -1
    time = np.array(times, np.float64)
    if carried.moved.start:
        piece = np.searchsorted(carried.moved.start, start, side="right") - 1
        time = np.where(piece >= 0, np.array(carried.moved.time_s)[piece], time)
    in_file = np.array([carried.moved.file_position(p) for p in starts]) if carried.moved.start else start
    order = np.argsort(in_file, kind="stable")
    return Blocks(start[order], np.array(ends, np.int64)[order], category[order], time[order], reasons)


def _block_end(data: bytes, position: int, end: int) -> int:
    """Position behind the data block at `position`, 0 where there is none."""
    if position + _SHORTEST > end:
        return 0
    behind = position + (data[position + 1] << 8 | data[position + 2])
    if behind < position + _SHORTEST or behind > end:
        return 0
    # A category that nobody has heard of may be one, if something known follows.
    return behind if _IS_KNOWN[data[position]] or behind == end or _IS_KNOWN[data[behind]] else 0


def _reason(data: bytes, position: int, end: int) -> str:
    if position + HEADER > end:
        return "the file ends within the header of a data block"
    length = data[position + 1] << 8 | data[position + 2]
    if length < _SHORTEST:
        return f"a data block of category {data[position]} claims a length of {length}"
    if position + length > end:
        return f"a data block of category {data[position]} claims {length} bytes, of which {end - position} are there"
    return f"no data block of a known category (octet {data[position]})"


def next_block(octets: NDArray[np.uint8], position: int, end: int) -> int:
    """First position from which three data blocks of known categories (or fewer, then the end) follow one another."""
    window = _FIRST_WINDOW
    while position + _SHORTEST <= end:
        here = np.arange(position, min(position + window, end - _SHORTEST + 1))
        good = np.ones(len(here), bool)
        at = here
        for _ in range(3):
            whole = good & (at < end - HEADER)
            near = np.where(whole, at, position)
            behind = near + (octets[near + 1].astype(np.int64) << 8 | octets[near + 2])
            fits = whole & KNOWN[octets[near]] & (behind >= near + _SHORTEST) & (behind <= end)
            good = fits | (good & (at == end))
            at = np.where(fits, behind, at)
        hits = here[good]
        if hits.size:
            return int(hits[0])
        position += len(here)
        window = min(window * 4, _LARGEST_WINDOW)
    return end


def is_chain(data: bytes, start: int, end: int, most: int = 64) -> bool:
    """Whether the octets are data blocks of known categories from the first to the last (of the first `most`)."""
    for _ in range(most):
        if start == end:
            return True
        behind = _block_end(data, start, end)
        if not behind or not _IS_KNOWN[data[start]]:
            return False
        start = behind
    return True


def is_start_of_blocks(head: bytes) -> bool:
    """Whether the beginning of a file, perhaps behind a piece of a cut block, looks like data blocks."""
    for start in (0, next_block(np.frombuffer(head, np.uint8), 1, len(head))):
        position, good = start, 0
        while behind := _block_end(head, position, len(head)):
            position, good = behind, good + 1
            if position == len(head):
                break
        if good and position + HEADER > len(head):
            return True
        # The last block may go on beyond what was looked at, or be cut off; three blocks may be followed by anything.
        if good > 2 or (good and start == 0 and _IS_KNOWN[head[position]]):
            return True
    return False
