"""Names for new rows, and the clock that dates them."""

from __future__ import annotations

import datetime as dt
import secrets


def new_id() -> str:
    """Return 16 random hexadecimal digits: short in an address, and not to be guessed from another."""
    return secrets.token_hex(8)


def now() -> dt.datetime:
    """Return the present instant in UTC."""
    return dt.datetime.now(dt.UTC)
