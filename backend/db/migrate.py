"""Bring the database to the tables of this version, at start and from the command line."""

from __future__ import annotations

from pathlib import Path

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from alembic.util import CommandError

from backend.db.engine import Database
from backend.errors import StateError

_HERE = Path(__file__).resolve().parent


def migrations_folder() -> Path:
    """Return the folder of the migrations: inside the package in a wheel, at the top of a checkout."""
    installed = _HERE / "migrations"
    return installed if installed.is_dir() else _HERE.parent.parent / "alembic"


def alembic_config() -> Config:
    """Return Alembic's configuration; there is no .ini file."""
    config = Config()
    # Alembic interpolates percent signs.
    config.set_main_option("script_location", str(migrations_folder()).replace("%", "%%"))
    return config


def upgrade(database: Database, revision: str = "head") -> None:
    """Run the migrations that the database lacks, all of them or none.

    Raises
    ------
    StateError
        A newer version of the program has written this database.
    """
    config = alembic_config()
    scripts = ScriptDirectory.from_config(config)
    with database.migration() as connection:
        current = MigrationContext.configure(connection).get_current_revision()
        if current is not None and current == scripts.get_current_head() and revision == "head":
            return
        config.attributes["connection"] = connection
        try:
            command.upgrade(config, revision)
        except CommandError as error:
            raise StateError(
                f"The database is at revision {current!r}, which this version does not know.",
                remedy="It was written by a newer version: install that one, or use another data folder.",
                code="database_newer",
            ) from error


def downgrade(database: Database, revision: str = "-1") -> None:
    """Undo migrations."""
    config = alembic_config()
    with database.migration() as connection:
        config.attributes["connection"] = connection
        command.downgrade(config, revision)
