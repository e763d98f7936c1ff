"""Write a recording so that the readers give the same recording again: CSV, Parquet, MATLAB or NumPy."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

import numpy as np

from algorithms.recording import Recording
from backend.files.array_rows import COLUMN_NAMES, START_UTC
from backend.files.matlab_writer import matlab_names, matlab_table, write_matlab
from backend.files.native_csv_writer import write_native_csv
from backend.files.native_table import native_table
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
    table = native_table(recording)
    about: dict[str, str] = {"kind": recording.kind}
    if recording.start_utc is not None:
        about[START_UTC] = recording.start_utc
    if recording.site is not None:
        about["site_json"] = json.dumps(recording.site.to_json())
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
