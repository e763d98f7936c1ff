"""Finished blocks of interrupted runs of simulated trials have another form from this version on: compute them anew."""

from __future__ import annotations

from alembic import op

revision = "0004"
down_revision = "0003"
branch_labels = None
depends_on = None

# What is finished succeeds unchanged; a run that was interrupted in the middle of an upgrade starts over.
_FORGET = "DELETE FROM run_blocks"


def upgrade() -> None:
    op.execute(_FORGET)


def downgrade() -> None:
    op.execute(_FORGET)
