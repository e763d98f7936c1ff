"""A consistent copy of an SQLite database that others may be writing, and what the copy refers to."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

from backend.db.blobs import referenced_blobs
from backend.db.engine import Database
from backend.errors import StorageError


def copy_database(source: Path, target: Path) -> set[str]:
    """Copy the database as it was at one instant; return the hashes of the blobs that the copy refers to.

    Raises
    ------
    StorageError
        It cannot be read, or is none of this program.
    """
    try:
        with (
            closing(sqlite3.connect(f"file:{source}?mode=ro", uri=True)) as reading,
            closing(sqlite3.connect(target)) as writing,
        ):
            reading.backup(writing)
            # One file, without a log beside it, wherever it is unpacked.
            writing.execute("PRAGMA journal_mode=DELETE")
            tables = {name for (name,) in writing.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
    except sqlite3.Error as error:
        raise StorageError(f"{source} cannot be read: {error}.", remedy="Look at the data folder.") from error
    if "recordings" not in tables:
        raise StorageError(
            f"{source} is no database of this program.", remedy="Give the data folder with --data.", code="no_data"
        )
    database = Database(f"sqlite:///{target}")
    try:
        with database.read() as connection:
            return referenced_blobs(connection)
    finally:
        database.close()
