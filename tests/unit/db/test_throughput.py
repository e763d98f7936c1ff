from __future__ import annotations

import pytest
from sqlalchemy import update

from backend.db import runs
from backend.db.runs import Entry
from backend.db.tables import runs as table
from backend.db.throughput import throughput


def test_nothing_measured_is_none_and_the_median_is_per_row(database):
    with database.write() as connection:
        assert throughput(connection, "rdf") is None
        for seconds in (1.0, 2.0, 9.0):
            entries = [Entry("rdf", "a", {}), Entry("rdfv", "b", {})]
            run = runs.create_run(connection, algorithms=entries, source={}, progress_total=200)
            done = [{"label": "a", "seconds": seconds}, {"label": "b", "seconds": 50.0}]
            connection.execute(update(table).where(table.c.id == run.id).values(state="succeeded", entries=done))
        runs.create_run(connection, algorithms=[Entry("rdf", "a", {})], source={}, progress_total=1)
        found = throughput(connection, "rdf")
    assert found.entries == 3
    assert found.seconds_per_row == pytest.approx(0.02)
