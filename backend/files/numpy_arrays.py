"""NumPy files: `.npz` with arrays of one length, and `.npy` with a matrix or named fields. Pickles are never loaded."""

from __future__ import annotations

import zipfile
from typing import Any

import numpy as np

from algorithms.errors import InputError
from backend.files.array_rows import ArrayRows, lay_out
from backend.files.content import Content
from backend.files.matlab5 import damaged
from backend.files.native_csv import detect_native, read_native
from backend.files.options import ReadLimits
from backend.files.packing import ZIP_MAGIC, check_expansion
from backend.files.reader import Reader, Source

NPY_MAGIC = b"\x93NUMPY"


def open_numpy(content: Content, limits: ReadLimits, pointer: str, wanted: frozenset[str]) -> ArrayRows:
    """Lay out the arrays of a file as a table.

    Raises InputError where the file is damaged, unpacks to too much, or holds no table.
    """
    with content.open_seekable() as stream:
        packed_size = stream.seek(0, 2)
        stream.seek(0)
        try:
            if content.head.startswith(ZIP_MAGIC):
                with zipfile.ZipFile(stream) as archive:
                    size = sum(m.file_size for m in archive.infolist())
                check_expansion(content.name, size, packed_size, limits, pointer)
                stream.seek(0)
                with np.load(stream, allow_pickle=False) as arrays:
                    read = {name: _loaded(arrays, name) for name in arrays.files}
            else:
                read = {"data": np.load(stream, allow_pickle=False)}
        except (MemoryError, InputError):
            raise
        except Exception as e:  # what a damaged file makes NumPy raise is not told anywhere
            raise damaged(content.name, str(e), pointer) from e
    return lay_out(content.name, {n: _plain(a) for n, a in read.items()}, wanted, pointer)


def _loaded(arrays: Any, name: str) -> Any:
    try:
        return arrays[name]
    except ValueError as e:
        # An array of Python objects is a pickle, which could run anything.
        if "pickle" in str(e).lower():
            return None
        raise


def _plain(array: Any) -> Any:
    if array is None:
        return None
    if array.dtype.names is not None:
        return {n: _plain(array[n]) for n in array.dtype.names}
    if array.dtype.kind == "S":
        return np.char.decode(array, "utf-8", "replace")
    if array.dtype.kind == "M":
        return [str(v) for v in array.ravel().astype("datetime64[us]")]
    return array


def _detect(source: Source) -> bool:
    return source.content.head.startswith((NPY_MAGIC, ZIP_MAGIC)) and detect_native(source)


READER = Reader(
    name="numpy",
    title="NumPy .npz or .npy: arrays of one length, a matrix, or named fields",
    kinds=("toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"),
    detect=_detect,
    read=read_native,
)
