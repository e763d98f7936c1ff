"""The tables that migrations make are the tables that the program declares."""

from __future__ import annotations

from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import inspect

from backend.db import migrate, outcomes, recordings, runs
from backend.db.engine import Database
from backend.db.tables import metadata
from backend.errors import StateError


def differences(database: Database) -> list[object]:
    with database.read() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        found = list(compare_metadata(context, metadata))
        # Alembic does not see which indexes are declared for SQLite only.
        other = connection.dialect.name != "sqlite"
        return [d for d in found if not (other and d[0] == "add_index" and "search_text" in d[1].columns)]


def test_upgrade_from_empty_leaves_nothing_to_migrate(database: Database) -> None:
    assert differences(database) == []


def test_down_and_up_again(database: Database) -> None:
    migrate.downgrade(database, "base")
    with database.read() as connection:
        assert inspect(connection).get_table_names() == ["alembic_version"]
    migrate.upgrade(database)
    assert differences(database) == []


def test_upgrading_twice_keeps_the_rows(database: Database, recording: recordings.Recording) -> None:
    migrate.upgrade(database)
    with database.read() as connection:
        assert recordings.get_recording(connection, recording.id) == recording


def test_runs_of_an_older_database_are_found_by_the_name_of_their_recording(database: Database) -> None:
    with database.write() as connection:
        run = runs.create_run(
            connection, algorithms=[runs.Entry("rdf", "rdf", {})], source={"name": "Облёт.csv"}, label="first"
        )
        connection.exec_driver_sql("UPDATE runs SET search_text = 'first\nrdf'")
    migrate.downgrade(database, "0001")
    migrate.upgrade(database)
    with database.read() as connection:
        for text in ("облёт", "first", "rdf"):
            assert [r.id for r in runs.list_runs(connection, runs.RunFilter(text=text))] == [run.id]


def test_a_search_through_the_text_reads_no_whole_rows(database: Database) -> None:
    """Revision 0003 makes the index, also in a database that lacks it."""
    with database.read() as connection:
        if connection.dialect.name != "sqlite":
            pytest.skip("PostgreSQL keeps long texts apart from their rows by itself")
    index = "ix_runs_created_at_id_search_text"

    def indexes() -> set[str]:
        with database.read() as connection:
            return {str(i["name"]) for i in inspect(connection).get_indexes("runs")}

    migrate.downgrade(database, "0002")
    assert index not in indexes()
    migrate.upgrade(database)
    assert index in indexes()
    order = "ORDER BY created_at DESC, id DESC LIMIT 51"
    with database.read() as connection:
        plan = connection.exec_driver_sql(
            f"EXPLAIN QUERY PLAN SELECT summary FROM runs WHERE search_text LIKE '%x%' {order}"
        ).all()
    assert index in str(plan)
    assert "TEMP B-TREE" not in str(plan), "the index gives the order too"


def test_blocks_of_another_form_are_computed_anew(database: Database) -> None:
    with database.write() as connection:
        run = runs.create_run(connection, algorithms=[runs.Entry("rdf", "rdf", {})], source={"name": "circuit"})
        outcomes.store_block(connection, run.id, 0, "a" * 64)
    migrate.downgrade(database, "0003")
    with database.write() as connection:
        outcomes.store_block(connection, run.id, 0, "a" * 64)
    migrate.upgrade(database)
    with database.read() as connection:
        assert outcomes.finished_blocks(connection, run.id) == {}
        assert runs.get_run(connection, run.id).state == "queued"


def test_a_newer_database_is_refused_with_a_remedy(database: Database) -> None:
    with database.write() as connection:
        connection.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    with pytest.raises(StateError, match="install that one") as caught:
        migrate.upgrade(database)
    assert caught.value.code == "database_newer"


def test_a_failing_migration_changes_nothing(database: Database, tmp_path: Path) -> None:
    def fail() -> None:
        with database.migration() as connection:
            connection.exec_driver_sql("DROP TABLE run_tags")
            raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        fail()
    assert differences(database) == []
