"""Arrays that share memory travel as one: tables have columns that are views of a result's arrays, or are the same.

Pickled one by one, a column of a matrix is copied, and what two tables share is sent twice.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

# Memory of which views cover less than this is left behind, and they are copied.
_WORTH_SENDING = 0.5

Array = NDArray[Any]


@dataclass(frozen=True)
class Place:
    """Where an array lies in the memory of a bundle."""

    memory: int
    offset: int
    dtype: str
    shape: tuple[int, ...]
    strides: tuple[int, ...]


@dataclass(frozen=True)
class Bundle:
    """Pieces of memory as bytes, and places of arrays in them."""

    memory: tuple[NDArray[np.uint8], ...]
    places: tuple[Place, ...]

    @classmethod
    def of(cls, arrays: Iterable[Array]) -> Bundle:
        """Bundle arrays; the bundle refers to their memory."""
        given = list(arrays)
        owners = {id(owner): owner for owner in map(_owner, given)}
        covered = dict.fromkeys(owners, 0)
        for array in {_span(array): array for array in given}.values():
            covered[id(_owner(array))] += array.nbytes
        memory: list[NDArray[np.uint8]] = []
        known: dict[int, int] = {}
        places = []
        for array in given:
            owner = _owner(array)
            # A view of nothing may lie anywhere: there is no memory that it could be found in.
            shared = array.size > 0 and owner.flags.forc and covered[id(owner)] >= _WORTH_SENDING * owner.nbytes
            if not shared:
                array = owner = np.ascontiguousarray(array)
            if not shared or id(owner) not in known:
                known[id(owner)] = len(memory)
                memory.append(_bytes(owner))
            offset = _start(array) - _start(owner)
            places.append(Place(known[id(owner)], offset, array.dtype.str, array.shape, array.strides))
        return cls(tuple(memory), tuple(places))

    def arrays(self) -> list[Array]:
        """The arrays, in their order."""
        return [
            np.ndarray(p.shape, p.dtype, buffer=self.memory[p.memory], offset=p.offset, strides=p.strides)
            for p in self.places
        ]


def _owner(array: Array) -> Array:
    while isinstance(array.base, np.ndarray):
        array = array.base
    return array


def _start(array: Array) -> int:
    return int(array.__array_interface__["data"][0])


def _span(array: Array) -> tuple[Any, ...]:
    return _start(array), array.dtype.str, array.shape, array.strides


def _bytes(array: Array) -> NDArray[np.uint8]:
    """The memory of an array without gaps."""
    flat = np.ndarray((array.size,), array.dtype, buffer=array.data if array.flags.c_contiguous else array.T.data)
    return flat.view(np.uint8)
