"""MATLAB files of versions 5 to 7.2 (`save` without -v7.3), read by SciPy; nothing in them is ever executed."""

from __future__ import annotations

import struct
import warnings
import zlib
from typing import IO, Any

import numpy as np

from algorithms.errors import InputError
from backend.files.array_rows import ArrayRows, lay_out
from backend.files.content import Content
from backend.files.native_csv import detect_native, read_native
from backend.files.options import ReadLimits
from backend.files.packing import check_expansion
from backend.files.reader import Reader, Source

MAGIC = b"MATLAB 5.0"
_HEADER_BYTES = 128
_COMPRESSED = 15
_BLOCK = 1 << 18


def open_matlab5(content: Content, limits: ReadLimits, pointer: str, wanted: frozenset[str]) -> ArrayRows:
    """Lay out the variables of a file as a table.

    Raises InputError where the file is damaged, unpacks to too much, or holds no table.
    """
    import scipy.io

    with content.open_seekable() as stream:
        _check_size(content.name, stream, limits, pointer)
        stream.seek(0)
        try:
            with warnings.catch_warnings():
                # A name that is there twice, which MATLAB does not write.
                warnings.simplefilter("error")
                read = scipy.io.loadmat(stream, chars_as_strings=True, mat_dtype=True)
        except MemoryError:
            raise
        except np.exceptions.ComplexWarning as e:
            raise InputError(
                f"{content.name} holds complex numbers, and no column of a recording does.",
                pointer=pointer,
                remedy="Save what was measured as real variables of their own, and the complex ones elsewhere.",
                code="complex_numbers",
            ) from e
        except Exception as e:  # what a damaged file makes SciPy raise is not told anywhere
            raise damaged(content.name, str(e), pointer) from e
    variables = {name: _plain(value) for name, value in read.items() if not name.startswith("__")}
    return lay_out(content.name, variables, wanted, pointer)


def damaged(name: str, why: str, pointer: str) -> InputError:
    """Say that a binary file cannot be read to its end; of what a library says of it the first sentence."""
    said = why.strip().partition("\n")[0].partition(". ")[0].rstrip(".")
    return InputError(
        f"{name} is damaged or cut off: {said or 'it ends too early'}.",
        pointer=pointer,
        remedy="Save it again and upload it whole.",
        code="damaged_file",
    )


def _check_size(name: str, stream: IO[bytes], limits: ReadLimits, pointer: str) -> None:
    """Unpack the variables once without keeping anything, to know how much they are."""
    packed_size = stream.seek(0, 2)
    header = stream.seek(0) or stream.read(_HEADER_BYTES)
    order = ">" if isinstance(header, bytes) and header[126:128] == b"MI" else "<"
    size = 0
    while len(tag := stream.read(8)) == 8:
        kind, length = struct.unpack(f"{order}II", tag)
        if kind != _COMPRESSED:
            stream.seek(length, 1)
            continue
        unpack, rest = zlib.decompressobj(), length
        try:
            while rest > 0 and (block := stream.read(min(rest, _BLOCK))):
                rest -= len(block)
                while block:
                    size += len(unpack.decompress(block, _BLOCK))
                    check_expansion(name, size, packed_size, limits, pointer)
                    block = unpack.unconsumed_tail
        except zlib.error as e:
            raise damaged(name, str(e), pointer) from e


def _plain(value: Any) -> Any:
    """A value as arrays, lists, texts and mappings; what is none of these (objects, functions) as None."""
    if not isinstance(value, np.ndarray) or type(value).__name__ in ("MatlabOpaque", "MatlabFunction"):
        return None
    if value.dtype.names is not None:
        structs = [{n: _plain(item[n]) for n in value.dtype.names} for item in value.ravel(order="F")]
        return structs[0] if len(structs) == 1 else structs
    if value.dtype == object:
        items = [_plain(v) for v in value.ravel(order="F")]
        return [t for (t,) in items] if items and all(_is_text(v) for v in items) else items
    return value


def _is_text(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind == "U" and value.size == 1


def _detect(source: Source) -> bool:
    return source.content.head.startswith(MAGIC) and detect_native(source)


READER = Reader(
    name="matlab",
    title="MATLAB 5 to 7.2: vectors, matrices, structs, cell arrays of plots per scan",
    kinds=("toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"),
    detect=_detect,
    read=read_native,
)
