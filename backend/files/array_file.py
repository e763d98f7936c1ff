"""Named arrays as one uncompressed .npz: written, hashed beside the writing, and read from the memory."""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import zipfile
from collections.abc import Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

# Bytes that are written or hashed at once: they stay in the processor's cache.
_CHUNK = 1 << 20
# The earliest date that a zip file can carry: equal arrays give equal bytes at any time of day.
_ZIP_DATE = (1980, 1, 1, 0, 0, 0)


def write_arrays(path: Path | BinaryIO, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write an uncompressed .npz: members in the order given, with a fixed date, never a pickle."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            _add(archive, name, array)


class HashedArrays:
    """An .npz like that of `write_arrays`, of arrays that come one after another, and its SHA-256.

    Members are written, and read again for the hash, by two threads beside the caller, who computes the next ones.
    """

    def __init__(self, path: Path) -> None:
        self._out = path.open("xb")
        # Without a buffer: it would hold bytes behind the end of a member, which still change.
        self._source = path.open("rb", buffering=0)
        self._archive = zipfile.ZipFile(self._out, "w", zipfile.ZIP_STORED)
        self._digest = hashlib.sha256()
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="writer")
        self._hasher = ThreadPoolExecutor(1, thread_name_prefix="hasher")
        self._pending: list[Future[Any]] = []

    def add(self, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Let these arrays be written; they must not change any more."""
        self._pending += [self._writer.submit(self._write, name, array) for name, array in arrays.items()]

    def finish(self) -> str:
        """Wait for all of it, have it on the disk, and return the hash; OSError where the disk refuses."""
        for done in self._pending:
            done.result().result()
        self._archive.close()
        self._out.flush()
        self._hash(self._out.tell())
        os.fsync(self._out.fileno())
        return self._digest.hexdigest()

    def close(self) -> None:
        """End the threads and close the file, finished or not."""
        self._writer.shutdown(cancel_futures=True)
        self._hasher.shutdown(cancel_futures=True)
        self._source.close()
        # Of a file that nobody will read: what a full disk did not take before it does not take now.
        for part in (self._archive, self._out):
            with contextlib.suppress(OSError, ValueError):
                part.close()

    def _write(self, name: str, array: NDArray[Any]) -> Future[None]:
        _add(self._archive, name, array)
        self._out.flush()
        # What lies before the end of a closed member does not change any more.
        return self._hasher.submit(self._hash, self._out.tell())

    def _hash(self, end: int) -> None:
        while left := end - self._source.tell():
            self._digest.update(self._source.read(min(_CHUNK, left)))


def _add(archive: zipfile.ZipFile, name: str, array: NDArray[Any]) -> None:
    member = zipfile.ZipInfo(f"{name}.npy", date_time=_ZIP_DATE)
    with archive.open(member, "w", force_zip64=True) as out:
        _write_array(out, np.ascontiguousarray(array))


def _write_array(out: IO[bytes], array: NDArray[Any]) -> None:
    """Write the form of a .npy file, which NumPy itself would copy twice on the way; a pickle is a ValueError."""
    if array.dtype.hasobject:
        raise ValueError(f"{array.dtype}: pickles are not written (allow_pickle)")
    np.lib.format.write_array_header_1_0(out, np.lib.format.header_data_from_array_1_0(array))
    data = array.reshape(-1).view(np.uint8)
    # In pieces that stay in the processor's cache from the checksum to the copy.
    for start in range(0, data.size, _CHUNK):
        out.write(data[start : start + _CHUNK].data)


def read_arrays(content: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    """Return all arrays of an .npz whose bytes stand in the memory; they are not copied on the way."""
    with np.load(io.BufferedReader(_InMemory(content)), allow_pickle=False) as archive:
        return dict(archive)


class _InMemory(io.RawIOBase):
    """Bytes of an array as a file; `io.BytesIO` would copy them."""

    def __init__(self, content: NDArray[np.uint8]) -> None:
        self._content = content
        self._at = 0

    def readable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._content.size}[whence]
        return self._at

    def readinto(self, target: Any) -> int:
        piece = self._content[self._at : self._at + len(target)]
        target[: piece.size] = piece.data
        self._at += piece.size
        return int(piece.size)
