"""One uploaded file as bytes or text: its label, packing and character encoding, found out from the content.

The file is read as a stream, twice: once to learn what it is (`inspect`), once by a reader. So a big file never
stands in memory as a whole.
"""

from __future__ import annotations

import codecs
import gzip
import io
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, cast

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.options import ReadLimits
from backend.files.report import Findings

_BLOCK = 1 << 20
_HEAD = 1 << 16
# Expansion is judged only from this size on: a short file of equal lines packs very well and harms nobody.
_HARMLESS_BYTES = 16 << 20
# Text has line ends and tabs; more than this share of other control characters is no text.
_CONTROL_SHARE = 0.02
_CONTROL = bytes(set(range(32)) - {9, 10, 11, 12, 13})

_KNOWN_BINARIES = (
    (b"PK\x03\x04", "a zip archive (or an Excel workbook)", "Unpack it, or save the sheet as CSV."),
    (b"%PDF", "a PDF document", "Upload the measurements as CSV."),
    (b"PAR1", "a Parquet file", "Save the table as CSV."),
    (b"MATLAB 5.0", "a MATLAB file", "Save the variables as CSV."),
    (b"\x89HDF", "an HDF5 file", "Save the table as CSV."),
    (b"\xd4\xc3\xb2\xa1", "a network capture", "Upload the measurements as CSV."),
    (b"7z\xbc\xaf", "a 7-Zip archive", "Unpack it."),
    (b"Rar!", "a RAR archive", "Unpack it."),
)


@dataclass(frozen=True)
class NamedFile:
    """A file to read: `name` is only a label (the uploader's), `path` is where the bytes are."""

    name: str
    path: Path

    @property
    def label(self) -> str:
        """Last component of the name, whatever system it came from."""
        return self.name.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1][:200] or "file"


@dataclass(frozen=True)
class Content:
    """A file whose packing and encoding are known."""

    name: str
    path: Path
    packed: bool
    head: bytes
    encoding: str
    has_quotes: bool
    has_nul: bool

    @contextmanager
    def open_bytes(self) -> Iterator[IO[bytes]]:
        """Open the (unpacked) bytes."""
        with _open(self.path, self.packed) as stream:
            yield stream

    @contextmanager
    def open_text(self) -> Iterator[IO[str]]:
        """Open the text; line ends stay as they are."""
        with _open(self.path, self.packed) as stream:
            yield io.TextIOWrapper(stream, encoding=self.encoding, newline="")


@contextmanager
def _open(path: Path, packed: bool) -> Iterator[IO[bytes]]:
    if packed:
        with gzip.open(path, "rb") as stream:
            yield cast(IO[bytes], stream)
    else:
        with path.open("rb") as stream:
            yield stream


def inspect(file: NamedFile, limits: ReadLimits, findings: Findings, *, pointer: str = "/file") -> Content:
    """Find out packing and encoding of a file by reading it once.

    Raises
    ------
    InputError
        The file is empty, damaged, or unpacks to more than the limits allow.
    UnsupportedFormatError
        The file is not text.
    """
    name = file.label
    with file.path.open("rb") as raw:
        packed = raw.read(2) == b"\x1f\x8b"
    packed_size = file.path.stat().st_size
    head = b""
    size = 0
    has_quotes = has_nul = False
    utf8: codecs.IncrementalDecoder | None = codecs.getincrementaldecoder("utf-8")()
    try:
        with _open(file.path, packed) as stream:
            while block := stream.read(_BLOCK):
                size += len(block)
                _check_expansion(name, packed, size, packed_size, limits, pointer)
                head = head or block[:_HEAD]
                has_quotes = has_quotes or b'"' in block
                has_nul = has_nul or b"\0" in block
                utf8 = _still_utf8(utf8, block, final=False)
            utf8 = _still_utf8(utf8, b"", final=True)
    except (gzip.BadGzipFile, EOFError, zlib.error) as e:
        raise InputError(
            f"{name} is a damaged or cut-off gzip file: {e}.",
            pointer=pointer,
            remedy="Pack it again and upload it whole.",
            code="damaged_archive",
        ) from e
    if not head.strip(b"\xef\xbb\xbf\xff\xfe \t\r\n\0"):
        raise InputError(
            f"{name} is empty.",
            pointer=pointer,
            remedy="Upload a file with a line of column names and at least one row.",
            code="empty_file",
        )
    _refuse_known_binary(name, head, pointer)
    encoding = _encoding(head, utf8 is not None)
    if encoding.startswith("utf-16"):
        _check_decodes(name, file.path, packed, encoding, pointer)
        has_nul = False
    else:
        controls = len(head) - len(head.translate(None, _CONTROL))
        if controls > _CONTROL_SHARE * len(head):
            raise UnsupportedFormatError(
                f"{name} is not text and in no binary format that is read here.",
                pointer=pointer,
                remedy="Upload the measurements as CSV; docs/formats.md shows the columns.",
            )
        if encoding == "cp1251":
            _check_decodes(name, file.path, packed, encoding, pointer)
            findings.warn(
                "encoding_guessed",
                f"{name} is not UTF-8; it was read as Windows-1251. If names look wrong, save it as UTF-8.",
            )
    return Content(name, file.path, packed, head, encoding, has_quotes, has_nul)


def _check_expansion(name: str, packed: bool, size: int, packed_size: int, limits: ReadLimits, pointer: str) -> None:
    if not packed:
        return
    too_dense = size > _HARMLESS_BYTES and size > limits.max_expansion * packed_size
    if size > limits.max_expanded_bytes or too_dense:
        raise InputError(
            f"{name} unpacks to more than is allowed ({size >> 20} MiB and more from {packed_size} bytes).",
            pointer=pointer,
            remedy="Upload it in smaller parts; several files are merged.",
            code="expands_too_much",
        )


def _still_utf8(
    decoder: codecs.IncrementalDecoder | None, block: bytes, *, final: bool
) -> codecs.IncrementalDecoder | None:
    if decoder is None:
        return None
    try:
        decoder.decode(block, final)
    except UnicodeDecodeError:
        return None
    return decoder


def _refuse_known_binary(name: str, head: bytes, pointer: str) -> None:
    for magic, what, remedy in _KNOWN_BINARIES:
        if head.startswith(magic):
            raise UnsupportedFormatError(f"{name} is {what}, which is not read here.", pointer=pointer, remedy=remedy)


def _encoding(head: bytes, is_utf8: bool) -> str:
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    # Without a mark, UTF-16 shows itself by zeros in nearly every second byte of a text that is mostly ASCII.
    sample = head[:4096]
    half = max(len(sample) // 2, 1)
    if sample[1::2].count(0) > 0.7 * half and sample[0::2].count(0) < 0.1 * half:
        return "utf-16-le"
    if sample[0::2].count(0) > 0.7 * half and sample[1::2].count(0) < 0.1 * half:
        return "utf-16-be"
    return "utf-8-sig" if is_utf8 else "cp1251"


def _check_decodes(name: str, path: Path, packed: bool, encoding: str, pointer: str) -> None:
    decoder = codecs.getincrementaldecoder(encoding)()
    try:
        with _open(path, packed) as stream:
            while block := stream.read(_BLOCK):
                decoder.decode(block)
            decoder.decode(b"", True)
    except UnicodeDecodeError as e:
        raise InputError(
            f"{name} is neither UTF-8 nor UTF-16 nor Windows-1251 text: {e.reason}.",
            pointer=pointer,
            remedy="Save it as UTF-8.",
            code="encoding",
        ) from e
