"""What holds a table: delimited text, Parquet, MATLAB and NumPy files, told from the first bytes."""

from __future__ import annotations

from backend.files.content import Content, unread
from backend.files.delimited_text import read_delimited_text
from backend.files.options import ReadLimits
from backend.files.packing import ZIP_MAGIC
from backend.files.rows import Rows


def open_rows(
    content: Content, limits: ReadLimits, *, pointer: str = "/file", wanted: frozenset[str] = frozenset()
) -> Rows:
    """Open the table in a file.

    Parameters
    ----------
    wanted : columns that the user named; of several tables in a file that with these columns is taken

    Raises
    ------
    InputError
        There is a table that cannot serve.
    UnsupportedFormatError
        There is none.
    """
    if content.is_text:
        return read_delimited_text(content, pointer=pointer)
    # These load a library of their own each, and know the readers, which know this module.
    from backend.files import matlab5, matlab73, numpy_arrays, parquet

    if content.head.startswith(parquet.MAGIC):
        return parquet.open_parquet(content, limits, pointer)
    if content.head.startswith(matlab5.MAGIC):
        return matlab5.open_matlab5(content, limits, pointer, wanted)
    if content.head.startswith(matlab73.MAGIC):
        return matlab73.open_matlab73(content, limits, pointer, wanted)
    # A zip archive of other files than arrays was opened before this.
    if content.head.startswith((numpy_arrays.NPY_MAGIC, ZIP_MAGIC)) and not content.file.member:
        return numpy_arrays.open_numpy(content, limits, pointer, wanted)
    raise unread(content, pointer)
