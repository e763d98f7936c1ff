"""The error tree of the server, next to `algorithms.errors`.

* FilterRoomError                      (algorithms.errors) message, code, remedy
  + InputError ...                     (algorithms.errors) the user's data or parameters
  + AlgorithmError ...                 (algorithms.errors) the method could not go on
  + NotFoundError                      nothing is stored under this name or id
  + StateError                         the thing is in a state in which the operation makes no sense
  + TooLargeError                      a body, a file or a table above a limit of the settings
  + QuotaError                         too many things of one kind at once
  + StorageError                       the disk or the database refused
  + UnavailableError                   something that is needed does not answer now; it may later

`backend.http.problems` maps the types to HTTP statuses, in one place.
"""

from __future__ import annotations

from pathlib import Path

from algorithms.errors import FilterRoomError

__all__ = [
    "STORAGE_CODES",
    "NotFoundError",
    "QuotaError",
    "StateError",
    "StorageError",
    "TooLargeError",
    "UnavailableError",
    "unusable_folder",
]

# Codes of what failed because something could not be stored.
STORAGE_CODES = ("storage", "disk_full", "read_only")


class NotFoundError(FilterRoomError):
    """Nothing is stored under this name or id."""

    code = "not_found"


class StateError(FilterRoomError):
    """The thing is in a state in which the operation makes no sense, such as cancelling a finished run."""

    code = "state"


class TooLargeError(FilterRoomError):
    """A body, a file or a table is above a limit of the settings; the message names limit and setting."""

    code = "too_large"


class QuotaError(FilterRoomError):
    """Too many things of one kind at once; trying again later helps."""

    code = "quota"


class StorageError(FilterRoomError):
    """The disk or the database refused to store or to give back what was asked."""

    code = "storage"


class UnavailableError(FilterRoomError):
    """Something that is needed (a locked database, a server that is away) does not answer now; it may later."""

    code = "unavailable"


def unusable_folder(folder: Path, error: OSError) -> StorageError:
    """Return the error of a server that cannot start because its data folder cannot be written."""
    why = error.strerror or str(error)
    return StorageError(
        f"The data folder {folder} cannot be written: {why}.",
        remedy="Check its owner, permissions and disk, or give another one with --data or FILTERROOM_DATA_DIR.",
    )
