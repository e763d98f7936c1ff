"""Delete stored blobs that no row refers to any more."""

from __future__ import annotations

from collections.abc import Collection

from backend.db.blobs import referenced_blobs
from backend.db.engine import Database
from backend.files.store import Store


def collect(database: Database, store: Store, candidates: Collection[str] | None = None) -> int:
    """Delete the unreferenced blobs among `candidates` (what a deletion returned), or of the whole store.

    Call it after the transaction that took the references away. Returns how many blobs went.
    """
    with store.guard():
        with database.read() as connection:
            kept = referenced_blobs(connection, candidates)
        gone = set(store.hashes() if candidates is None else candidates) - kept
        for sha256 in gone:
            store.delete(sha256)
    return len(gone)
