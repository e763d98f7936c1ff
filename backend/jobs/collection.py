"""Delete stored blobs that no row refers to any more."""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterator
from contextlib import contextmanager

from algorithms.errors import FilterRoomError
from backend.db.blobs import referenced_blobs
from backend.db.engine import Database
from backend.files.store import Store

logger = logging.getLogger(__name__)


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


@contextmanager
def storing(database: Database, store: Store) -> Iterator[set[str]]:
    """Hold the store's guard and give a set for what is put; where the block fails, none of it stays unreferenced.

    A full disk refuses the row after it took the file: the file would fill it until the next start of a server.
    """
    put: set[str] = set()
    with store.guard():
        try:
            yield put
        except BaseException:
            try:
                collect(database, store, put)
            except (FilterRoomError, OSError) as error:
                # The next server's start takes them.
                logger.warning("%d stored files without a reference stay for now: %s", len(put), error)
            raise
