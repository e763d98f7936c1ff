from __future__ import annotations

import pytest
from sqlalchemy.exc import IntegrityError

from backend.db import events, recordings, runs
from backend.db.blobs import referenced_blobs
from backend.db.engine import Database
from backend.errors import NotFoundError, StateError

PARSED = recordings.Parsed(
    kind="toa_marks",
    format="csv",
    rows_read=5,
    rows_accepted=3,
    time_first_s=0.0,
    time_last_s=9.5,
    start_utc=None,
    site={"stations": []},
    has_truth=True,
    warnings=[{"code": "out_of_order", "detail": "2 rows", "count": 2}],
    rejections=[
        recordings.Rejection(4, "not_a_number", "time_s is 'x'", "marks.csv"),
        recordings.Rejection(2, "duplicate", "same as row 1", "marks.csv"),
    ],
    data_sha256="d" * 64,
)


def add_run(database: Database, recording_id: str) -> runs.Run:
    with database.write() as connection:
        return runs.create_run(
            connection,
            algorithms=[runs.Entry("rdf", "rdf", {})],
            source={"recording_id": recording_id},
            recording_ids=[recording_id],
        )


def test_parsed_once(database: Database, recording: recordings.Recording) -> None:
    assert recording.state == "parsing"
    assert recording.size_bytes == 120
    with database.write() as connection:
        assert recordings.set_parsed(connection, recording.id, PARSED)
        assert not recordings.set_failed(connection, recording.id, {"code": "late"})
        found = recordings.find_by_fingerprint(connection, recording.fingerprint)
        assert found is not None
        assert (found.state, found.rows_rejected, found.has_truth, found.error) == ("ready", 2, True, None)
        assert found.warnings == tuple(PARSED.warnings)
        assert found.site == {"stations": []}
        states = [e.data["state"] for e in events.events_after(connection, 0)]
        assert states == ["parsing", "ready"]


def test_rejections_keep_their_order_and_page(database: Database, recording: recordings.Recording) -> None:
    with database.write() as connection:
        recordings.set_parsed(connection, recording.id, PARSED)
        assert recordings.list_rejections(connection, recording.id) == list(PARSED.rejections)
        assert recordings.list_rejections(connection, recording.id, start=1, limit=1) == [PARSED.rejections[1]]


def test_failed_keeps_its_error(database: Database, recording: recordings.Recording) -> None:
    error = {"code": "unsupported_format", "detail": "no reader", "pointer": "/file"}
    with database.write() as connection:
        assert recordings.set_failed(connection, recording.id, error, PARSED.rejections)
        failed = recordings.get_recording(connection, recording.id)
    assert (failed.state, failed.error, failed.rows_rejected) == ("failed", error, 2)


def test_the_same_fingerprint_cannot_come_twice(database: Database, recording: recordings.Recording) -> None:
    with pytest.raises(IntegrityError), database.write() as connection:
        recordings.create_recording(
            connection, name="x", sha256="e" * 64, fingerprint=recording.fingerprint, files=[], options={}
        )


def test_listing_pages_without_gaps_while_rows_arrive(database: Database) -> None:
    def add(name: str) -> recordings.Recording:
        with database.write() as connection:
            return recordings.create_recording(
                connection, name=name, sha256="f" * 64, fingerprint=f"{name:0>64}", files=[], options={}
            )

    made = [add(str(n)) for n in range(5)]
    with database.read() as connection:
        first = recordings.list_recordings(connection, limit=2)
    add("late")
    with database.read() as connection:
        rest = recordings.list_recordings(connection, limit=9, after=(first[-1].created_at, first[-1].id))
        oldest = recordings.list_recordings(connection, limit=2, oldest_first=True)
        named = recordings.list_recordings(connection, text="LATE")
    assert [r.name for r in first + rest] == ["4", "3", "2", "1", "0"]
    assert oldest == made[:2]
    assert [r.name for r in named] == ["late"]


def test_deleting_is_refused_while_runs_use_it(database: Database, recording: recordings.Recording) -> None:
    run = add_run(database, recording.id)
    with pytest.raises(StateError, match="1 run uses") as caught, database.write() as connection:
        recordings.delete_recording(connection, recording.id)
    assert caught.value.code == "recording_in_use"
    with pytest.raises(StateError, match="queued"), database.write() as connection:
        recordings.delete_recording(connection, recording.id, with_runs=True)
    with database.write() as connection:
        runs.cancel_run(connection, run.id)
        deleted = recordings.delete_recording(connection, recording.id, with_runs=True)
        assert deleted.run_ids == (run.id,)
        assert deleted.blobs == {"a" * 64, "c" * 64}
        assert referenced_blobs(connection, deleted.blobs) == set()
        with pytest.raises(NotFoundError):
            recordings.get_recording(connection, recording.id)
        with pytest.raises(NotFoundError):
            runs.get_run(connection, run.id)


def test_blobs_of_another_recording_stay_referenced(database: Database, recording: recordings.Recording) -> None:
    with database.write() as connection:
        recordings.create_recording(
            connection, name="again", sha256="a" * 64, fingerprint="1" * 64, files=recording.files, options={}
        )
        deleted = recordings.delete_recording(connection, recording.id)
        assert referenced_blobs(connection, deleted.blobs) == deleted.blobs
