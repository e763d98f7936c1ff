"""The tables, in portable types: SQLite by default, PostgreSQL by URL.

What a run is searched by (algorithm names, tags, recordings) stands in tables of its own with an index, so
that listing stays fast with ten thousand runs; what is only shown stands in JSON columns.
"""

from __future__ import annotations

import datetime as dt

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    Column,
    DateTime,
    Dialect,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    String,
    Table,
    Text,
    TypeDecorator,
)

metadata = MetaData(
    # Names for every constraint: SQLite and PostgreSQL then agree and a later migration can drop one.
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s",
        "pk": "pk_%(table_name)s",
    }
)


class UtcDateTime(TypeDecorator[dt.datetime]):
    """An instant: goes in with any time zone, comes out in UTC. Naive times are refused."""

    impl = DateTime(timezone=True)
    cache_ok = True

    def process_bind_param(self, value: dt.datetime | None, dialect: Dialect) -> dt.datetime | None:
        """Convert to UTC."""
        if value is None:
            return None
        if value.tzinfo is None:
            raise ValueError("a time without a time zone cannot be stored")
        return value.astimezone(dt.UTC)

    def process_result_value(self, value: dt.datetime | None, dialect: Dialect) -> dt.datetime | None:
        """Give back the time zone that SQLite does not keep."""
        if value is None:
            return None
        return value.replace(tzinfo=dt.UTC) if value.tzinfo is None else value.astimezone(dt.UTC)


# SQLite numbers rows automatically only where the type is exactly INTEGER.
_Serial = BigInteger().with_variant(Integer(), "sqlite")
# None is SQL NULL, never the JSON word null: `IS NULL` must find it.
_Json = JSON(none_as_null=True)
_Id = String(32)
_Sha256 = String(64)


recordings = Table(
    "recordings",
    metadata,
    Column("id", _Id, primary_key=True),
    Column("created_at", UtcDateTime, nullable=False),
    Column("name", Text, nullable=False),
    Column("state", String(16), nullable=False),
    Column("kind", String(32)),
    Column("format", String(64)),
    Column("sha256", _Sha256, nullable=False),
    Column("fingerprint", _Sha256, nullable=False, unique=True),
    Column("size_bytes", BigInteger, nullable=False),
    Column("files", _Json, nullable=False),
    Column("options", _Json, nullable=False),
    Column("error", _Json),
    Column("rows_read", BigInteger, nullable=False, default=0),
    Column("rows_accepted", BigInteger, nullable=False, default=0),
    Column("rows_rejected", BigInteger, nullable=False, default=0),
    Column("time_first_s", Float),
    Column("time_last_s", Float),
    Column("start_utc", String(40)),
    Column("site", _Json),
    Column("has_truth", Boolean, nullable=False, default=False),
    Column("warnings", _Json, nullable=False, default=list),
    Column("data_sha256", _Sha256),
    Index(None, "created_at", "id"),
)

rejections = Table(
    "rejections",
    metadata,
    Column("recording_id", _Id, ForeignKey("recordings.id", ondelete="CASCADE"), primary_key=True),
    Column("position", Integer, primary_key=True),
    Column("row", BigInteger),
    Column("code", String(64), nullable=False),
    Column("detail", Text, nullable=False),
    Column("file", Text, nullable=False),
)

runs = Table(
    "runs",
    metadata,
    Column("id", _Id, primary_key=True),
    Column("state", String(16), nullable=False),
    Column("label", Text, nullable=False),
    Column("tags", _Json, nullable=False),
    Column("created_at", UtcDateTime, nullable=False),
    Column("started_at", UtcDateTime),
    Column("finished_at", UtcDateTime),
    Column("source", _Json, nullable=False),
    Column("algorithms", _Json, nullable=False),
    Column("seed", BigInteger, nullable=False),
    Column("trials", Integer, nullable=False),
    Column("progress_done", BigInteger, nullable=False, default=0),
    Column("progress_total", BigInteger, nullable=False, default=0),
    Column("error", _Json),
    Column("summary", _Json),
    Column("entries", _Json),
    Column("software", _Json),
    Column("result_sha256", _Sha256),
    # Label, entry labels, names of algorithms and recording, tags in folded case: SQLite's LIKE folds ASCII only.
    Column("search_text", Text, nullable=False),
    Index(None, "created_at", "id"),
    Index(None, "state", "created_at", "id"),
    # SQLite keeps a row in one piece: a search through the text would read every summary with it. PostgreSQL does not,
    # and refuses so long a key.
    Index(None, "created_at", "id", "search_text").ddl_if(dialect="sqlite"),
)

run_recordings = Table(
    "run_recordings",
    metadata,
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True),
    Column("recording_id", _Id, ForeignKey("recordings.id"), primary_key=True),
    Column("position", Integer, nullable=False),
    Index(None, "recording_id", "run_id"),
)

run_algorithms = Table(
    "run_algorithms",
    metadata,
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True),
    Column("name", String(80), primary_key=True),
    Index(None, "name", "run_id"),
)

run_tags = Table(
    "run_tags",
    metadata,
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True),
    Column("tag", String(80), primary_key=True),
    Index(None, "tag", "run_id"),
)

run_blocks = Table(
    "run_blocks",
    metadata,
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True),
    Column("position", Integer, primary_key=True),
    Column("sha256", _Sha256, nullable=False),
)
"""Finished work of a run that is not finished: what a restarted server need not compute again."""

run_tables = Table(
    "run_tables",
    metadata,
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE"), primary_key=True),
    Column("name", String(64), primary_key=True),
    Column("columns", _Json, nullable=False),
    Column("rows", _Json, nullable=False),
)

run_events = Table(
    "run_events",
    metadata,
    Column("id", _Serial, primary_key=True, autoincrement=True),
    Column("run_id", _Id, ForeignKey("runs.id", ondelete="CASCADE")),
    Column("at", UtcDateTime, nullable=False),
    Column("kind", String(32), nullable=False),
    Column("data", _Json, nullable=False),
    Index(None, "run_id", "id"),
    # Ids are never used again: they are what a browser resumes from.
    sqlite_autoincrement=True,
)

idempotency_keys = Table(
    "idempotency_keys",
    metadata,
    Column("key", String(128), primary_key=True),
    Column("body_sha256", _Sha256, nullable=False),
    Column("location", Text, nullable=False),
    Column("created_at", UtcDateTime, nullable=False),
    Index(None, "created_at"),
)
