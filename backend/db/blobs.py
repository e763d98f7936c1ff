"""Which stored blobs the database still refers to."""

from __future__ import annotations

from collections.abc import Collection

from sqlalchemy import Connection, select

from backend.db.tables import recordings, run_blocks, runs


def referenced_blobs(connection: Connection, among: Collection[str] | None = None) -> set[str]:
    """Return the hashes that some row refers to; only those in `among` if it is given."""
    columns = (recordings.c.data_sha256, runs.c.result_sha256, run_blocks.c.sha256)
    found = {sha for column in columns for sha in connection.scalars(select(column).where(column.is_not(None)))}
    for files in connection.scalars(select(recordings.c.files)):
        found |= {f["sha256"] for f in files}
    return found if among is None else found & set(among)
