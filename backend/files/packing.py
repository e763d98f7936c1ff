"""Packed files: gzip, bzip2, xz, Zstandard and zip as streams, and limits on what they unpack to.

Packing is told from the first bytes, never from the name. A zip archive is a folder: each file in it is read as if it
had been uploaded by itself. NumPy's `.npz` is a zip archive too, but one file.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import zipfile
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Literal, cast

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.options import ReadLimits

Packing = Literal["", "gzip", "bzip2", "xz", "zstd", "zip"]

_MAGIC: tuple[tuple[bytes, Packing], ...] = (
    (b"\x1f\x8b", "gzip"),
    (b"BZh", "bzip2"),
    (b"\xfd7zXZ\x00", "xz"),
    (b"\x28\xb5\x2f\xfd", "zstd"),
)
ZIP_MAGIC = b"PK\x03\x04"
# Expansion is judged only from this size on: a short file of equal lines packs very well and harms nobody.
_HARMLESS_BYTES = 16 << 20
_MOST_MEMBERS = 1000
# What a damaged archive makes the libraries raise; an OSError with a number is the disk's and no damage.
_DAMAGE = (EOFError, zlib.error, lzma.LZMAError, zipfile.BadZipFile, NotImplementedError, RuntimeError, OSError)


@dataclass(frozen=True)
class NamedFile:
    """A file to read: `name` is only a label (the uploader's), `path` is where the bytes are.

    `member` names a file inside the zip archive at `path`.
    """

    name: str
    path: Path
    member: str = ""

    @property
    def label(self) -> str:
        """Last component of the name, whatever system it came from."""
        return self.name.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1][:200] or "file"


def packing_of(file: NamedFile) -> Packing:
    """Tell how a file is packed."""
    if file.member:
        return "zip"
    with file.path.open("rb") as raw:
        head = raw.read(6)
    return next((packing for magic, packing in _MAGIC if head.startswith(magic)), "")


@contextmanager
def unpacked(file: NamedFile, packing: Packing) -> Iterator[IO[bytes]]:
    """Open the bytes of a file as a stream, unpacked."""
    if packing == "":
        with file.path.open("rb") as plain:
            yield plain
    elif packing == "zip":
        with zipfile.ZipFile(file.path) as archive, archive.open(file.member) as member:
            yield member
    elif packing == "zstd":
        # The standard library has no Zstandard before Python 3.14; pyarrow brings it.
        import pyarrow

        with pyarrow.input_stream(str(file.path), compression="zstd") as stream:
            yield cast(IO[bytes], stream)
    else:
        openers: dict[str, Callable[..., Any]] = {"gzip": gzip.open, "bzip2": bz2.open, "xz": lzma.open}
        with openers[packing](file.path, "rb") as stream:
            yield cast(IO[bytes], stream)


@contextmanager
def damage_told(name: str, packing: Packing, pointer: str) -> Iterator[None]:
    """Turn what a damaged archive raises into an InputError."""
    try:
        yield
    except _DAMAGE as e:
        if not packing or (isinstance(e, OSError) and e.errno is not None):
            raise
        raise InputError(
            f"{name} is a damaged, cut-off or encrypted {packing} file: {e}.",
            pointer=pointer,
            remedy="Pack it again, without a password, and upload it whole.",
            code="damaged_archive",
        ) from e


def check_expansion(name: str, size: int, packed_size: int, limits: ReadLimits, pointer: str) -> None:
    """Raise InputError where `size` unpacked bytes are more than the limits allow."""
    too_dense = size > _HARMLESS_BYTES and size > limits.max_expansion * packed_size
    if size > limits.max_expanded_bytes or too_dense:
        raise InputError(
            f"{name} unpacks to more than is allowed ({size >> 20} MiB and more from {packed_size} bytes).",
            pointer=pointer,
            remedy="Upload it in smaller parts; several files are merged.",
            code="expands_too_much",
        )


def with_members(files: Sequence[NamedFile], limits: ReadLimits, *, pointer: str = "/file") -> list[NamedFile]:
    """Put the files of a zip archive in its place, in the order of their names.

    Raises
    ------
    InputError
        An archive is damaged, holds nothing, too many files, or more bytes than the limits allow.
    UnsupportedFormatError
        It is an office document, or holds archives.
    """
    out: list[NamedFile] = []
    for file in files:
        with file.path.open("rb") as raw:
            is_zip = raw.read(4) == ZIP_MAGIC
        out += _members(file, limits, pointer) if is_zip and not file.member else [file]
    return out


def _members(file: NamedFile, limits: ReadLimits, pointer: str) -> list[NamedFile]:
    name = file.label
    with damage_told(name, "zip", pointer), zipfile.ZipFile(file.path) as archive:
        members = [m for m in archive.infolist() if not m.is_dir() and not _is_litter(m.filename)]
    names = sorted(m.filename for m in members)
    if "[Content_Types].xml" in names or "mimetype" in names:
        raise UnsupportedFormatError(
            f"{name} is an office document, which is not read here.", pointer=pointer, remedy="Save the sheet as CSV."
        )
    check_expansion(name, sum(m.file_size for m in members), file.path.stat().st_size, limits, pointer)
    if names and all(n.endswith(".npy") for n in names):
        return [file]
    if not names or len(names) > _MOST_MEMBERS:
        raise InputError(
            f"{name} holds {len(names) or 'no'} files; an archive may hold up to {_MOST_MEMBERS}.",
            pointer=pointer,
            remedy="Pack the files of one recording.",
            code="archive_members",
        )
    return [NamedFile(n, file.path, member=n) for n in names]


def _is_litter(name: str) -> bool:
    """Whether some system put the file into the archive by itself."""
    last = name.rsplit("/", 1)[-1]
    return name.startswith("__MACOSX/") or last in (".DS_Store", "Thumbs.db") or last.startswith("._")
