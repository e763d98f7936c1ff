"""The text that runs are searched by gains the name of the recording."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"
branch_labels = None
depends_on = None

_runs = sa.table(
    "runs",
    sa.column("id", sa.String),
    sa.column("source", sa.JSON),
    sa.column("search_text", sa.Text),
)


def upgrade() -> None:
    connection = op.get_bind()
    for run in connection.execute(sa.select(_runs)).all():
        words = [*run.search_text.split("\n"), str(run.source.get("name", "")).casefold()]
        text = "\n".join(dict.fromkeys(words))
        connection.execute(_runs.update().where(_runs.c.id == run.id).values(search_text=text))


def downgrade() -> None:
    """Nothing to undo: an older program finds more than it looks for, and writes the text anew with each change."""
