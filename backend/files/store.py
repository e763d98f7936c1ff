"""Content-addressed store: files named by the SHA-256 of their bytes, in `<root>/<first two digits>/<rest>`.

A blob is written under a temporary name, fsynced and renamed, so it is there whole or not at all; it never
changes. The database refers to blobs. To keep a collection from taking a blob between `put` and the commit
of its first reference, both sides work under `guard()`:

    with store.guard():
        sha256 = store.put_file(path)
        with database.write() as connection:
            ...  # refer to sha256
"""

from __future__ import annotations

import errno
import hashlib
import io
import json
import os
import secrets
import shutil
import threading
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from backend.errors import NotFoundError, StorageError

# Bytes per read while hashing and copying.
_CHUNK = 1 << 20
# The earliest date that a zip file can carry: equal arrays give equal bytes at any time of day.
_ZIP_DATE = (1980, 1, 1, 0, 0, 0)


class Store:
    """Blobs under `root`; one server process at a time (see `backend.files.lock`)."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._temporary = root / "tmp"
        self._guard = threading.RLock()
        with _storage_errors():
            self._temporary.mkdir(parents=True, exist_ok=True)

    def guard(self) -> AbstractContextManager[Any]:
        """Hold off deletions from `put` until the blob is referred to; take it before a write transaction."""
        return self._guard

    def temporary(self) -> Path:
        """Return a new path on the same disk; `put_file` moves it into the store."""
        return self._temporary / secrets.token_hex(16)

    def path(self, sha256: str) -> Path:
        """Return where a blob lies, or would lie."""
        if len(sha256) != 64 or not set(sha256) <= set("0123456789abcdef"):
            raise ValueError(f"{sha256!r} is not a SHA-256 in lower-case hexadecimal digits")
        return self._root / sha256[:2] / sha256[2:]

    def put_file(self, temporary: Path) -> str:
        """Move a finished file into the store and return its hash."""
        with _storage_errors():
            digest = hashlib.sha256()
            with temporary.open("rb") as source:
                while chunk := source.read(_CHUNK):
                    digest.update(chunk)
                os.fsync(source.fileno())
            target = self.path(digest.hexdigest())
            if target.exists():
                temporary.unlink()
            else:
                target.parent.mkdir(exist_ok=True)
                temporary.chmod(0o600)
                os.replace(temporary, target)
                _sync_folder(target.parent)
        return digest.hexdigest()

    def put_bytes(self, data: bytes) -> str:
        """Store bytes and return their hash."""
        path = self.temporary()
        with _storage_errors(path):
            path.write_bytes(data)
        return self._put_or_delete(path)

    def put_arrays(self, arrays: Mapping[str, NDArray[Any]]) -> str:
        """Store named arrays as one uncompressed .npz and return its hash."""
        path = self.temporary()
        with _storage_errors(path):
            write_arrays(path, arrays)
        return self._put_or_delete(path)

    def get_bytes(self, sha256: str) -> bytes:
        """Return the bytes of a blob."""
        return self._existing(sha256).read_bytes()

    def get_contents(self, sha256: str) -> NDArray[np.uint8]:
        """Return the bytes of a blob as an array, which goes to other processes without being copied."""
        return np.fromfile(self._existing(sha256), np.uint8)

    def get_arrays(self, sha256: str) -> Mapping[str, NDArray[Any]]:
        """Return named arrays; each is read from the disk when it is asked for."""
        arrays: Mapping[str, NDArray[Any]] = np.load(self._existing(sha256), allow_pickle=False)
        return arrays

    def size(self, sha256: str) -> int | None:
        """Return the size of a blob in bytes, None where it is missing."""
        try:
            return self.path(sha256).stat().st_size
        except FileNotFoundError:
            return None

    def delete(self, sha256: str) -> None:
        """Delete a blob; one that is already gone is fine."""
        self.path(sha256).unlink(missing_ok=True)

    def hashes(self) -> Iterator[str]:
        """Yield the hash of every blob."""
        for folder in sorted(self._root.glob("[0-9a-f][0-9a-f]")):
            yield from (folder.name + blob.name for blob in sorted(folder.iterdir()))

    def clear_temporary(self) -> None:
        """Delete what an earlier server left half-written; only while nothing is being uploaded."""
        shutil.rmtree(self._temporary, ignore_errors=True)
        self._temporary.mkdir(parents=True, exist_ok=True)

    def free_bytes(self) -> int:
        """Return the free space of the store's disk."""
        return shutil.disk_usage(self._root).free

    def _put_or_delete(self, temporary: Path) -> str:
        try:
            return self.put_file(temporary)
        except StorageError:
            # Left there, it would fill the disk until the next start.
            with suppress(OSError):
                temporary.unlink()
            raise

    def _existing(self, sha256: str) -> Path:
        path = self.path(sha256)
        if not path.exists():
            raise StorageError(
                f"The stored file {sha256[:12]}... is missing from the data folder.",
                remedy="Restore the data folder from a backup, or delete what refers to it and upload again.",
                code="blob_missing",
            )
        return path


def write_arrays(path: Path | BinaryIO, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write an uncompressed .npz: members in the order given, with a fixed date, never a pickle."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
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


def json_array(value: Any) -> NDArray[np.uint8]:
    """Return JSON as an array of bytes, to travel inside an .npz."""
    return np.frombuffer(json.dumps(value, ensure_ascii=False, sort_keys=True).encode(), np.uint8)


def json_of(array: NDArray[np.uint8]) -> Any:
    """Return what `json_array` made an array of."""
    return json.loads(array.tobytes())


def _sync_folder(folder: Path) -> None:
    """Make a rename durable."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def _storage_errors(partial: Path | None = None) -> Iterator[None]:
    """Turn an error of the disk into a StorageError and leave nothing half-written."""
    try:
        yield
    except OSError as error:
        if partial is not None:
            # A read-only disk refuses this even where there is nothing to delete.
            with suppress(OSError):
                partial.unlink()
        if isinstance(error, FileNotFoundError):
            raise NotFoundError(f"{error.filename} does not exist.", code="file_not_found") from error
        raise refusal_of(error) from error


def refusal_of(error: OSError) -> StorageError:
    """Return what a disk refused as an error that says what to do."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return StorageError(
            "The disk of the data folder is full.",
            remedy="Free space, or delete runs and recordings; nothing that was stored is lost.",
            code="disk_full",
        )
    return StorageError(
        f"The data folder cannot be written: {error}.", remedy="Check the folder's owner, permissions and disk."
    )
