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
import json
import os
import secrets
import shutil
import threading
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend.errors import NotFoundError, StorageError
from backend.files.array_file import MappedArrays, write_arrays

# Bytes per read while hashing.
_CHUNK = 1 << 20


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

    @contextmanager
    def adopted(self, temporary: Path, sha256: str) -> Iterator[None]:
        """Move a file into the store whose writer has hashed and synced it; where the block fails, it goes back.

        So whoever could not refer to it may try again.
        """
        target = self.path(sha256)
        with self._guard:
            is_new = not target.exists()
            if is_new:
                with _storage_errors():
                    target.parent.mkdir(exist_ok=True)
                    temporary.chmod(0o600)
                    os.replace(temporary, target)
                    _sync_folder(target.parent)
            try:
                yield
            except BaseException:
                if is_new:
                    with suppress(OSError):
                        os.replace(target, temporary)
                raise
            with suppress(OSError):
                temporary.unlink(missing_ok=True)

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
        return self.existing(sha256).read_bytes()

    def get_contents(self, sha256: str) -> NDArray[np.uint8]:
        """Return the bytes of a blob as an array, which goes to other processes without being copied."""
        return np.fromfile(self.existing(sha256), np.uint8)

    def get_arrays(self, sha256: str) -> Mapping[str, NDArray[Any]]:
        """Return named arrays; they are read from the disk as far as somebody looks at them."""
        return MappedArrays(self.existing(sha256))

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

    def existing(self, sha256: str) -> Path:
        """Return where a blob lies; StorageError where it is missing."""
        path = self.path(sha256)
        if not path.exists():
            raise StorageError(
                f"The stored file {sha256[:12]}... is missing from the data folder.",
                remedy="Restore the data folder from a backup, or delete what refers to it and upload again.",
                code="blob_missing",
            )
        return path


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
