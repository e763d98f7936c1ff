"""What holds a table: delimited text, Parquet, MATLAB and NumPy files, told from the first bytes."""

from __future__ import annotations

from backend.files.content import Content, unread
from backend.files.delimited_text import read_delimited_text
from backend.files.options import ReadLimits
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
    raise unread(content, pointer)
