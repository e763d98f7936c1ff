"""Write a recording so that the readers give the same recording again: CSV, Parquet, MATLAB or NumPy."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

import numpy as np

from algorithms.recording import Recording
from algorithms.result import Table
from backend.errors import NotFoundError
from backend.files.array_rows import COLUMN_NAMES, START_UTC
from backend.files.matlab_writer import matlab_names, matlab_table, write_matlab
from backend.files.native_csv_writer import write_native_columns, write_native_csv
from backend.files.native_table import native_table, truth_columns_of, truth_table
from backend.files.parquet_writer import write_parquet

RecordingForm = Literal["csv", "parquet", "mat", "npz"]


def write_recording(recording: Recording, path: Path, form: RecordingForm) -> None:
    """Write the rows of a recording, its truth included.

    All forms but CSV, which has no place for them, tell the start and the kind, and carry the site as JSON for those
    who read the file elsewhere; here a site is given by itself.
    """
    if form == "csv":
        with path.open("w", encoding="utf-8", newline="") as stream:
            write_native_csv(recording, stream)
        return
    about = {"kind": recording.kind, **_start(recording)}
    if recording.site is not None:
        about["site_json"] = json.dumps(recording.site.to_json())
    _write(native_table(recording), about, path, form)


def write_truth(recording: Recording, path: Path, form: RecordingForm) -> None:
    """Write the true paths of a recording, whole, as a file that is read as its truth.

    Raises
    ------
    NotFoundError
        It has none.
    """
    tracks = recording.truth_tracks
    if tracks is None:
        raise NotFoundError(
            "The recording has no true paths of its own.",
            remedy="What truth its rows have stands beside them, in data.csv.",
            code="no_true_paths",
        )
    if form == "csv":
        with path.open("w", encoding="utf-8", newline="") as stream:
            write_native_columns(truth_columns_of(tracks), stream)
        return
    _write(truth_table(tracks), _start(recording), path, form)


def _start(recording: Recording) -> dict[str, str]:
    return {} if recording.start_utc is None else {START_UTC: recording.start_utc}


def _write(table: Table, about: Mapping[str, str], path: Path, form: RecordingForm) -> None:
    if form == "parquet":
        write_parquet(table, path, about=about)
    elif form == "mat":
        write_matlab({"recording": matlab_table(table), **about}, path)
    else:
        spelled = matlab_names(table.names)
        arrays = {COLUMN_NAMES: np.array([spelled, table.names]).T} | {n: np.array(v) for n, v in about.items()}
        for name, column in zip(spelled, table.columns.values(), strict=True):
            arrays[name] = column if isinstance(column, np.ndarray) else np.array([v or "" for v in column])
        with path.open("wb") as out:
            np.savez_compressed(out, **arrays)  # type: ignore[arg-type]
