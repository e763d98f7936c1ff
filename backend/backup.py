"""A data folder as one archive, made while a server may be using it.

The database is copied as it was at one instant; then everything that the copy refers to is held by hard links, so
that a deletion meanwhile takes nothing away, and packed. What was deleted between copy and links makes the copy be
taken once more. The archive unpacks to a data folder; the token stays out of it.
"""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
import tarfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from backend.db.snapshot import copy_database
from backend.errors import StorageError

DATABASE = "filterroom.sqlite"
# Deletions are rare and copies fast; a file that is missing this often is not coming back.
_TRIES = 5


@dataclass(frozen=True)
class Backup:
    """What was packed; `missing` and `damaged` are hashes of stored files that were not there or not whole."""

    files: int
    size_bytes: int
    missing: tuple[str, ...]
    damaged: tuple[str, ...]


class _Hashing:
    """A file that is read and hashed at once."""

    def __init__(self, stream: IO[bytes]) -> None:
        self._stream = stream
        self.digest = hashlib.sha256()

    def read(self, size: int = -1) -> bytes:
        """Read on."""
        data = self._stream.read(size)
        self.digest.update(data)
        return data


def back_up(data_dir: Path, target: Path) -> Backup:
    """Write the archive under a temporary name beside `target` and rename it; an older one is replaced only then.

    Raises
    ------
    StorageError
        There is no data folder, or the archive cannot be written.
    """
    if not (data_dir / DATABASE).is_file():
        raise StorageError(
            f"There is no database in {data_dir}.",
            remedy="Give the data folder with --data or FILTERROOM_DATA_DIR.",
            code="no_data",
        )
    if target.is_dir():
        raise StorageError(f"{target} is a folder.", remedy="Give the name of a file.", code="os_error")
    partial = target.with_name(f".{target.name}.{secrets.token_hex(4)}.part")
    # Beside the store, since a hard link cannot lead to another disk.
    staging = data_dir / f".backup-{secrets.token_hex(8)}"
    staging.mkdir(mode=0o700)
    try:
        missing = _stage(data_dir, staging)
        with _written(partial) as out:
            packed = _pack(staging, out, compress=target.suffix in (".gz", ".tgz"))
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)
        shutil.rmtree(staging)
    return Backup(packed.files, target.stat().st_size, tuple(sorted(missing)), packed.damaged)


def _stage(data_dir: Path, staging: Path) -> set[str]:
    missing: set[str] = set()
    for _ in range(_TRIES):
        for old in ("", "-wal", "-shm"):
            (staging / f"{DATABASE}{old}").unlink(missing_ok=True)
        wanted = copy_database(data_dir / DATABASE, staging / DATABASE)
        missing = {sha for sha in wanted if not _hold(data_dir / "store", staging / "store", sha)}
        if not missing:
            break
    # A try that was given up may have held what the last copy does not refer to.
    for blob in (staging / "store").glob("*/*"):
        if blob.parent.name + blob.name not in wanted:
            blob.unlink()
    return missing


def _hold(store: Path, staging: Path, sha256: str) -> bool:
    source, target = (root / sha256[:2] / sha256[2:] for root in (store, staging))
    if target.exists():
        return True
    target.parent.mkdir(parents=True, exist_ok=True)
    try:
        os.link(source, target)
    except FileNotFoundError:
        return False
    except OSError:
        # A file system without hard links.
        with suppress(FileNotFoundError):
            shutil.copyfile(source, target)
    return target.exists()


@contextmanager
def _written(path: Path) -> Iterator[IO[bytes]]:
    """Give a new file that only its owner can read, on the disk at the end of the block."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, "wb") as out:
        yield out
        out.flush()
        os.fsync(out.fileno())


@dataclass(frozen=True)
class _Packed:
    files: int
    damaged: tuple[str, ...]


def _pack(staging: Path, out: IO[bytes], *, compress: bool) -> _Packed:
    damaged: list[str] = []
    blobs = sorted((staging / "store").glob("*/*"))
    with tarfile.open(fileobj=out, mode="w:gz" if compress else "w", format=tarfile.PAX_FORMAT) as archive:
        for path in (staging / DATABASE, *blobs):
            member = tarfile.TarInfo(path.relative_to(staging).as_posix())
            member.size, member.mtime, member.mode = path.stat().st_size, int(path.stat().st_mtime), 0o600
            with path.open("rb") as stream:
                hashing = _Hashing(stream)
                archive.addfile(member, hashing)
            if path.name != DATABASE and hashing.digest.hexdigest() != path.parent.name + path.name:
                damaged.append(path.parent.name + path.name)
    return _Packed(len(blobs), tuple(damaged))
