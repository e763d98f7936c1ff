"""MATLAB 7.3 files, which are HDF5, and other HDF5 files with datasets of the same forms.

MATLAB keeps arrays with their axes reversed, texts as 16-bit characters, and the cells of a cell array as references.
Links to other files, datasets that lie outside the file and virtual ones are never followed.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from algorithms.errors import InputError
from backend.files.array_rows import ArrayRows, lay_out
from backend.files.content import Content
from backend.files.matlab5 import damaged
from backend.files.native_csv import detect_native, read_native
from backend.files.options import ReadLimits
from backend.files.packing import check_expansion
from backend.files.reader import Reader, Source

if TYPE_CHECKING:
    import h5py

MAGIC = (b"MATLAB 7.3", b"\x89HDF")
_DEEPEST = 6


class _Variables:
    """Reads datasets and counts their bytes, so that a small file cannot fill the memory."""

    def __init__(self, name: str, packed_size: int, limits: ReadLimits, pointer: str) -> None:
        self._name = name
        self._packed_size = packed_size
        self._limits = limits
        self._pointer = pointer
        self._bytes = 0

    def group(self, group: h5py.Group, depth: int = 0) -> dict[str, Any]:
        """Members of a group that lie in the file itself."""
        import h5py

        out: dict[str, Any] = {}
        for name in group:
            if name.startswith("#"):
                continue
            link = group.get(name, getlink=True)
            inside = isinstance(link, h5py.HardLink) and depth < _DEEPEST
            out[name] = self.value(group[name], depth + 1) if inside else None
        return out

    def value(self, item: h5py.Group | h5py.Dataset, depth: int) -> Any:
        """A member as arrays, lists, texts and mappings; what is none of these as None."""
        import h5py

        kind = _text(item.attrs.get("MATLAB_class", b""))
        if "MATLAB_object_decode" in item.attrs and kind not in ("char", "logical"):
            return None
        if isinstance(item, h5py.Group):
            return self._struct(item, depth)
        if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or item.shape is None:
            return None
        if item.attrs.get("MATLAB_empty", 0):
            return np.empty((0, 0))
        self._count(item)
        if h5py.check_ref_dtype(item.dtype) is not None:
            return self._cells(item, depth)
        if h5py.check_string_dtype(item.dtype) is not None:
            return [_text(v) for v in np.ravel(item[()])]
        array = np.asarray(item[()])
        if array.dtype.names is not None:
            return {n: array[n] for n in array.dtype.names}
        if not kind:
            return array
        array = array.T
        if kind == "char":
            lines: Any = np.atleast_2d(array.astype(np.uint16)) if array.ndim <= 2 else []
            texts = ["".join(map(chr, line)).rstrip() for line in lines]
            return texts[0] if len(texts) == 1 else texts
        return array

    def _struct(self, group: h5py.Group, depth: int) -> Any:
        fields = self.group(group, depth)
        # A field of an array of structs is a list of references without a class of its own.
        rows = {n for n in fields if isinstance(fields[n], list) and "MATLAB_class" not in group[n].attrs}
        lengths = {len(fields[n]) for n in rows}
        if rows and rows == set(fields) and len(lengths) == 1:
            return [{n: fields[n][i] for n in fields} for i in range(lengths.pop())]
        return fields

    def _cells(self, item: h5py.Dataset, depth: int) -> list[Any]:
        # Reversed axes in C order are MATLAB's own order.
        if depth >= _DEEPEST:
            return [None]
        return [self.value(item.file[ref], depth + 1) if ref else None for ref in np.ravel(item[()])]

    def _count(self, item: h5py.Dataset) -> None:
        self._bytes += int(np.prod(item.shape, dtype=object)) * item.dtype.itemsize
        check_expansion(self._name, self._bytes, self._packed_size, self._limits, self._pointer)


def open_matlab73(content: Content, limits: ReadLimits, pointer: str, wanted: frozenset[str]) -> ArrayRows:
    """Lay out the datasets of a file as a table.

    Raises InputError where the file is damaged, unpacks to too much, or holds no table.
    """
    import h5py

    with content.open_seekable() as stream:
        packed_size = stream.seek(0, 2)
        stream.seek(0)
        variables = _Variables(content.name, packed_size, limits, pointer)
        try:
            with h5py.File(stream, "r") as file:
                read = variables.group(file)
        except (MemoryError, InputError):
            raise
        except Exception as e:  # what a damaged file makes HDF5 raise is not told anywhere
            raise damaged(content.name, str(e), pointer) from e
    return lay_out(content.name, read, wanted, pointer)


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _detect(source: Source) -> bool:
    return source.content.head.startswith(MAGIC) and detect_native(source)


READER = Reader(
    name="matlab73",
    title="MATLAB 7.3 and other HDF5: vectors, matrices, structs, cell arrays of plots per scan",
    kinds=("toa_marks", "polar_plots", "antenna_plots", "doppler_pairs"),
    detect=_detect,
    read=read_native,
)
