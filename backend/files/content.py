"""One uploaded file as bytes or text: its label, packing and character encoding, found out from the content.

The file is read as a stream, twice: once to learn what it is (`inspect`), once by a reader. So a big file never
stands in memory as a whole.
"""

from __future__ import annotations

import codecs
import io
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import IO

from algorithms.errors import InputError, UnsupportedFormatError
from backend.files.options import ReadLimits
from backend.files.packing import (
    ZIP_MAGIC,
    NamedFile,
    Packing,
    check_expansion,
    damage_told,
    packing_of,
    unpacked,
)
from backend.files.report import Findings

__all__ = ["Content", "NamedFile", "inspect", "unread"]

_BLOCK = 1 << 20
_HEAD = 1 << 16
# So many bytes at once are looked at for a line end: half of what a line may have (see `records.MAX_LINE`).
_STRETCH = 1 << 16
# Text has line ends and tabs; more than this share of other control characters is no text.
_CONTROL_SHARE = 0.02
_CONTROL = bytes(set(range(32)) - {9, 10, 11, 12, 13})

# First bytes of files that are no text, and what to say where no reader takes them.
_BINARIES = (
    (ZIP_MAGIC, "a zip archive inside another archive", "Unpack the outer one."),
    (b"%PDF", "a PDF document", "Upload the measurements as CSV."),
    # Readable ones, told here as no text.
    (b"PAR1", "a Parquet file", "Save it again."),
    (b"MATLAB 5.0", "a MATLAB file", "Save it again."),
    (b"MATLAB 7.3", "a MATLAB file", "Save it again."),
    (b"\x93NUMPY", "a NumPy array", "Upload it by itself."),
    (b"\x89HDF", "an HDF5 file", "Save it again."),
    (b"\xd4\xc3\xb2\xa1", "a network capture", "Upload the measurements as CSV."),
    (b"7z\xbc\xaf", "a 7-Zip archive", "Unpack it, or pack it as .zip."),
    (b"Rar!", "a RAR archive", "Unpack it, or pack it as .zip."),
)


@dataclass(frozen=True)
class Content:
    """A file whose packing and encoding are known; `encoding` is empty where it is no text."""

    name: str
    file: NamedFile
    packing: Packing
    head: bytes
    encoding: str
    has_quotes: bool
    has_nul: bool
    longest_line: int
    """No line has more bytes, if line ends are single bytes."""

    @property
    def is_text(self) -> bool:
        """Whether it can be read as text."""
        return bool(self.encoding)

    @contextmanager
    def open_bytes(self) -> Iterator[IO[bytes]]:
        """Open the (unpacked) bytes as a stream."""
        with unpacked(self.file, self.packing) as stream:
            yield stream

    @contextmanager
    def open_seekable(self) -> Iterator[IO[bytes]]:
        """Open the (unpacked) bytes for a library that jumps about in them."""
        with unpacked(self.file, self.packing) as stream:
            if not self.packing:
                yield stream
                return
            with tempfile.TemporaryFile() as copy:
                shutil.copyfileobj(stream, copy, _BLOCK)
                copy.seek(0)
                yield copy

    @contextmanager
    def open_text(self) -> Iterator[IO[str]]:
        """Open the text; line ends stay as they are."""
        with unpacked(self.file, self.packing) as stream:
            yield io.TextIOWrapper(stream, encoding=self.encoding, newline="")


def inspect(file: NamedFile, limits: ReadLimits, findings: Findings, *, pointer: str = "/file") -> Content:
    """Find out packing and encoding of a file by reading it once.

    Raises
    ------
    InputError
        The file is empty, damaged, of no known encoding, or unpacks to more than the limits allow.
    """
    name = file.label
    packing = packing_of(file)
    packed_size = file.path.stat().st_size
    head = b""
    size = longest_line = open_line = 0
    has_quotes = has_nul = False
    utf8: codecs.IncrementalDecoder | None = codecs.getincrementaldecoder("utf-8")()
    with damage_told(name, packing, pointer), unpacked(file, packing) as stream:
        while block := stream.read(_BLOCK):
            size += len(block)
            if packing:
                check_expansion(name, size, packed_size, limits, pointer)
            if len(head) < _HEAD:
                head += block[: _HEAD - len(head)]
            has_quotes = has_quotes or b'"' in block
            has_nul = has_nul or b"\0" in block
            utf8 = _still_utf8(utf8, block, final=False)
            for start in range(0, len(block), _STRETCH):
                length = min(_STRETCH, len(block) - start)
                longest_line = max(longest_line, open_line + length)
                open_line = length + (open_line if block.find(b"\n", start, start + length) < 0 else 0)
        utf8 = _still_utf8(utf8, b"", final=True)
    if not head.strip(b"\xef\xbb\xbf\xff\xfe \t\r\n\0"):
        raise InputError(
            f"{name} is empty.",
            pointer=pointer,
            remedy="Upload a file with a line of column names and at least one row.",
            code="empty_file",
        )
    encoding = _encoding(head, utf8 is not None)
    if encoding.startswith("utf-16"):
        _check_decodes(name, file, packing, encoding, pointer)
        has_nul = False
    elif encoding == "cp1251":
        _check_decodes(name, file, packing, encoding, pointer)
        findings.warn(
            "encoding_guessed",
            f"{name} is not UTF-8; it was read as Windows-1251. If names look wrong, save it as UTF-8.",
        )
    return Content(name, file, packing, head, encoding, has_quotes, has_nul, longest_line)


def unread(content: Content, pointer: str) -> UnsupportedFormatError:
    """Say that a file is no text, what it is, and what to do."""
    for magic, what, remedy in _BINARIES:
        if content.head.startswith(magic):
            return UnsupportedFormatError(
                f"{content.name} is {what}, which is not read here.", pointer=pointer, remedy=remedy
            )
    return UnsupportedFormatError(
        f"{content.name} is not text and in no binary format that is read here.",
        pointer=pointer,
        remedy="Upload the measurements as CSV; docs/formats.md shows the columns.",
    )


def _still_utf8(
    decoder: codecs.IncrementalDecoder | None, block: bytes, *, final: bool
) -> codecs.IncrementalDecoder | None:
    if decoder is None:
        return None
    if block.isascii() and not final and decoder.getstate() == (b"", 0):
        return decoder
    try:
        decoder.decode(block, final)
    except UnicodeDecodeError:
        return None
    return decoder


def _encoding(head: bytes, is_utf8: bool) -> str:
    """Return the encoding of a text, or nothing where it is none."""
    if any(head.startswith(magic) for magic, _, _ in _BINARIES):
        return ""
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    # Without a mark, UTF-16 shows itself by zeros in nearly every second byte of a text that is mostly ASCII.
    sample = head[:4096]
    half = max(len(sample) // 2, 1)
    if sample[1::2].count(0) > 0.7 * half and sample[0::2].count(0) < 0.1 * half:
        return "utf-16-le"
    if sample[0::2].count(0) > 0.7 * half and sample[1::2].count(0) < 0.1 * half:
        return "utf-16-be"
    controls = len(head) - len(head.translate(None, _CONTROL))
    if controls > _CONTROL_SHARE * len(head):
        return ""
    return "utf-8-sig" if is_utf8 else "cp1251"


def _check_decodes(name: str, file: NamedFile, packing: Packing, encoding: str, pointer: str) -> None:
    decoder = codecs.getincrementaldecoder(encoding)()
    try:
        with unpacked(file, packing) as stream:
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
