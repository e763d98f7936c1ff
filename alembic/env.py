"""Run by Alembic for every migration command.

The server hands over its own connection (`backend.db.migrate`); `alembic revision --autogenerate` for
developers opens the database that the settings name.
"""

from __future__ import annotations

from typing import Any, Literal

from alembic import context
from sqlalchemy import Connection

from backend.db.engine import Database
from backend.db.tables import UtcDateTime, metadata
from backend.settings import Settings


def render(kind: str, thing: Any, _context: Any) -> str | Literal[False]:
    """Write plain types into migrations: an old migration must not change with the program."""
    return "sa.DateTime(timezone=True)" if kind == "type" and isinstance(thing, UtcDateTime) else False


def migrate(connection: Connection) -> None:
    """Run what the command asks for inside the connection's transaction."""
    # Batch mode: SQLite can alter a table only by copying it.
    context.configure(connection=connection, target_metadata=metadata, render_as_batch=True, render_item=render)
    with context.begin_transaction():
        context.run_migrations()


given: Connection | None = context.config.attributes.get("connection")
if given is not None:
    migrate(given)
else:
    database = Database(Settings().url)
    with database.migration() as own:
        migrate(own)
    database.close()
