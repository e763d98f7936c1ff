"""What a database refuses, as errors that say what to do: a full disk, a lock, a server that is away, a wrong text."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy import URL
from sqlalchemy.exc import DataError, DBAPIError, TimeoutError

from algorithms.errors import FilterRoomError, InputError
from backend.errors import StorageError, UnavailableError


@contextmanager
def translated(url: URL, *, writing: bool) -> Iterator[None]:
    """Turn what the database refuses into errors of the program; what they do not name is raised as it is."""
    try:
        yield
    except TimeoutError as error:
        raise _locked("A transaction of this server does not end.") from error
    except DBAPIError as error:
        is_sqlite = url.get_backend_name() == "sqlite"
        refusal = _of_sqlite(error, writing) if is_sqlite else _of_postgresql(error, url, writing)
        if refusal is None:
            raise
        raise refusal from error


def _of_sqlite(error: DBAPIError, writing: bool) -> FilterRoomError | None:
    name = getattr(error.orig, "sqlite_errorname", "")
    text = str(error.orig)
    if name == "SQLITE_FULL":
        return _full(text)
    if name.startswith(("SQLITE_BUSY", "SQLITE_LOCKED")):
        return _locked("Another program keeps the database locked.")
    # A connection for reading refuses to write with the same code: that would be an error of the program.
    if (name.startswith("SQLITE_READONLY") and writing) or name.startswith(("SQLITE_CANTOPEN", "SQLITE_PERM")):
        return StorageError(
            f"The database cannot be written: {text}.",
            remedy="Check the owner, the permissions and the disk of the data folder.",
            code="read_only",
        )
    if name.startswith("SQLITE_IOERR"):
        # Also where the write-ahead log cannot grow: SQLite does not say that the disk is full.
        return StorageError(
            f"The disk of the database does not do what it is told: {text}.",
            remedy="Free space and look at the disk; nothing that was stored is lost.",
            code="disk_full",
        )
    if name in ("SQLITE_CORRUPT", "SQLITE_NOTADB"):
        return StorageError(
            f"The database is damaged: {text}.", remedy="Restore the last backup.", code="database_damaged"
        )
    return None


def _of_postgresql(error: DBAPIError, url: URL, writing: bool) -> FilterRoomError | None:
    state = getattr(error.orig, "sqlstate", None) or ""
    text = " ".join(str(error.orig).split()).rstrip(".")
    if state == "53100":
        return _full(text)
    if state == "55P03":
        return _locked("Another program keeps a table of the database locked.")
    if state == "25006" and writing:
        return StorageError(
            f"The database takes no changes: {text}.",
            remedy="Give the address of the primary server, not of a copy that only reads.",
            code="read_only",
        )
    if state.startswith("42501"):
        return StorageError(
            f"The database denies the rights that are needed: {text}.",
            remedy="Make the role of FILTERROOM_DATABASE_URL the owner of the database.",
            code="database_rights",
        )
    if isinstance(error, DataError):
        return InputError(
            f"A text cannot be stored: {text}.",
            remedy="Leave out control characters and shorten what is long.",
            code="text",
        )
    if not state or state.startswith(("08", "53", "57P")) or error.connection_invalidated:
        return UnavailableError(
            f"The database {url.render_as_string(hide_password=True)} does not answer: {text}.",
            remedy="Start it or mend the way to it; the server tries again by itself.",
            code="database_unreachable",
        )
    return None


def _full(text: str) -> StorageError:
    return StorageError(
        f"The database cannot be written: {text}.",
        remedy="Free space on its disk; nothing that was stored is lost.",
        code="disk_full",
    )


def _locked(detail: str) -> UnavailableError:
    return UnavailableError(
        detail,
        remedy="Close it (a database browser, a backup tool) and try again.",
        code="database_locked",
    )
