"""Named arrays as one uncompressed .npz: written, hashed beside the writing, read from the memory or where they lie."""

from __future__ import annotations

import contextlib
import hashlib
import io
import mmap
import os
import struct
import zipfile
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import IO, Any, BinaryIO, Literal

import numpy as np
from numpy.typing import NDArray

# Bytes that are written or hashed at once: they stay in the processor's cache.
_CHUNK = 1 << 20
# The earliest date that a zip file can carry: equal arrays give equal bytes at any time of day.
_ZIP_DATE = (1980, 1, 1, 0, 0, 0)
# Bytes of what stands before a member: its header without name, the field of large files, the field that fills up to
# the next multiple (number, length, multiple, as Android's packages have it). So arrays can be used where they lie.
_LOCAL_HEADER, _ZIP64_FIELD, _ALIGNMENT = 30, 20, struct.Struct("<HHH")
_ALIGNMENT_FIELD, _ALIGNED = 0xD935, 64
# Of a local header: lengths of name and further fields.
_LENGTHS = struct.Struct("<26xHH")
# The header of an array is shorter.
_ARRAY_HEADER = 4096


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
    before = archive.start_dir + _LOCAL_HEADER + len(member.filename.encode()) + _ZIP64_FIELD + _ALIGNMENT.size
    fill = -before % _ALIGNED
    member.extra = _ALIGNMENT.pack(_ALIGNMENT_FIELD, 2 + fill, _ALIGNED) + bytes(fill)
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


class MappedArrays(Mapping[str, NDArray[Any]]):
    """Arrays of an .npz where they lie in the file: read from the disk as far as somebody looks at them.

    Writing to one changes nothing but this view. Members of other programs, or of earlier versions, are copied.
    """

    def __init__(self, path: Path) -> None:
        with path.open("rb") as file:
            with zipfile.ZipFile(file) as archive:
                self._members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            self._memory = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_COPY)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return an array; KeyError where there is none."""
        member = self._members[name]
        if member.compress_type != zipfile.ZIP_STORED:
            raise ValueError(f"{name} is compressed: no file of this program")
        lengths: tuple[int, int] = _LENGTHS.unpack_from(self._memory, member.header_offset)
        start = member.header_offset + _LOCAL_HEADER + sum(lengths)
        head = io.BytesIO(self._memory[start : start + _ARRAY_HEADER])
        version = np.lib.format.read_magic(head)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, is_fortran, dtype = read(head)
        if dtype.hasobject:
            raise ValueError(f"{name}: pickles are not read (allow_pickle)")
        order: Literal["F", "C"] = "F" if is_fortran else "C"
        array: NDArray[Any] = np.ndarray(shape, dtype, self._memory, start + head.tell(), order=order)
        return array if array.flags.aligned else array.copy()

    def __iter__(self) -> Iterator[str]:
        """Yield the names in order."""
        return iter(self._members)

    def __len__(self) -> int:
        """Return the number of arrays."""
        return len(self._members)


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
