"""Write arrays and tables as a MATLAB file (version 5, compressed), which Octave, SciPy and `load` read.

MATLAB spells names with letters, digits and underscores, at most 63 of them, so names that are spelled otherwise are
changed; `column_names` of a table (what is
written, what it stands for) and `labels` of a run keep them as they were. A column of texts becomes whole
numbers, 0 for none, beside a cell array `COLUMN_names`: `categorical(t.status, 1:numel(t.status_names),
t.status_names)` makes one column of the two.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from algorithms.result import Column, Table
from backend.errors import TooLargeError
from backend.files.array_rows import COLUMN_NAMES, NAMES_SUFFIX

_LONGEST_NAME = 63
# Lengths of version 5 are signed 32-bit numbers.
_MOST_BYTES = 2**31 - 2**20


def write_matlab(variables: Mapping[str, Any], path: Path) -> None:
    """Write variables: arrays, texts, sequences of texts (cell arrays), and mappings (structs) of these.

    Raises TooLargeError where one array is more than a file of version 5 can hold.
    """
    import scipy.io

    scipy.io.savemat(
        path, {n: _value(v) for n, v in variables.items()}, do_compression=True, long_field_names=True, oned_as="column"
    )


def matlab_names(names: Sequence[str], *, room: int = 0) -> list[str]:
    """Spell names as MATLAB wants them, each once, with room for so many characters behind."""
    out: list[str] = []
    for name in names:
        spelled = re.sub(r"\W", "_", name, flags=re.ASCII)
        spelled = spelled if re.match(r"[A-Za-z]", spelled) else f"x{spelled}"
        spelled = stem = spelled[: _LONGEST_NAME - room]
        number = 1
        while spelled in out:
            number += 1
            spelled = f"{stem[: _LONGEST_NAME - room - 1 - len(str(number))]}_{number}"
        out.append(spelled)
    return out


def matlab_table(table: Table) -> dict[str, Any]:
    """Return a table as a struct of columns."""
    spelled = matlab_names(table.names, room=len(NAMES_SUFFIX))
    out: dict[str, Any] = {COLUMN_NAMES: np.array([spelled, table.names], object).T}
    for name, column in zip(spelled, table.columns.values(), strict=True):
        if isinstance(column, np.ndarray):
            out[name] = column
        else:
            out[name], out[f"{name}{NAMES_SUFFIX}"] = _coded(column)
    return out


def _coded(column: Column) -> tuple[np.ndarray[Any, Any], list[str]]:
    known: dict[str, int] = {}
    codes = [0 if v is None else known.setdefault(v, len(known) + 1) for v in column]
    return np.array(codes, np.float64), list(known)


def _value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {n: _value(v) for n, v in value.items()}
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray):
        if value.nbytes > _MOST_BYTES:
            raise TooLargeError(
                "An array is larger than the 2 GiB that a MATLAB file of version 5 can hold.",
                remedy="Take result.npz or the Parquet tables.",
            )
        return value
    cells = np.empty((len(value), 1), object)
    cells[:, 0] = list(value)
    return cells
