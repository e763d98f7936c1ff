"""Every code that an error of the server itself can carry, with what it means; served at /problems/CODE.

Codes of readers and algorithms that are not listed here carry all they have to say in their detail.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """The kind of a problem: a title that never changes, and what it means in general."""

    title: str
    meaning: str


PROBLEMS: dict[str, Kind] = {
    # The protocol.
    "malformed_request": Kind("The request cannot be taken apart", "The body is not what its headers say it is."),
    "malformed_json": Kind("The body is not JSON", "The body was announced as JSON and is none."),
    "host_not_allowed": Kind(
        "Unknown host name",
        "The request names a host that this server does not answer to; otherwise any site could reach it through "
        "a name of its own. Add your name to FILTERROOM_ALLOWED_HOSTS.",
    ),
    "token_required": Kind(
        "The token is missing",
        "Everything under /api needs the token that `filterroom serve` prints, as `Authorization: Bearer`.",
    ),
    "token_wrong": Kind("The token is wrong", "The token is not the one of this server; it prints it at its start."),
    "forbidden": Kind("Not allowed", "The server understood the request and refuses it."),
    "cross_site": Kind(
        "Another site asked for a change",
        "A browser says that a page of another site sent this request. Only the server's own page and programs "
        "with the token may change anything.",
    ),
    "not_found": Kind("There is nothing here", "No such address, or nothing is stored under this name."),
    "method_not_allowed": Kind("The method is not possible here", "The header `Allow` lists what is possible."),
    "unsupported_media_type": Kind(
        "The body is of a type that is not taken", "The detail names the types that this endpoint takes."
    ),
    "validation": Kind("Something in the request is not as it must be", "`errors` lists each field with its reason."),
    "cursor": Kind("The cursor cannot be used", "Start the list again without it, or keep the filters of its page."),
    "idempotency_key_reused": Kind(
        "The Idempotency-Key was used with another body", "A key stands for one request; make a new one."
    ),
    "internal": Kind("An unexpected error", "The server's log has it, under the number in the detail."),
    # Limits and storage.
    "too_large": Kind("Too large", "The detail names the limit and the setting that holds it."),
    "quota": Kind("Too much at once", "Wait for some of it to finish."),
    "storage": Kind("The data folder cannot be used", "Its disk is full or does not allow writing."),
    "disk_full": Kind("The disk is full", "Free space, or delete runs and recordings; nothing stored is lost."),
    "database_locked": Kind("The database is locked", "Another program holds it open for writing."),
    "blob_missing": Kind("A stored file is missing", "Something outside the program removed it from the data folder."),
    "file_not_found": Kind("A file is missing", "It was there a moment ago."),
    # States.
    "state": Kind("Not possible in this state", "The detail names the state."),
    "recording_not_found": Kind("No such recording", "It was deleted, or its id is misspelt."),
    "recording_not_ready": Kind("The recording is still being read", "Wait until its state is `ready`."),
    "recording_failed": Kind("The recording could not be read", "Its `error` says why."),
    "recording_in_use": Kind("Runs use the recording", "Delete them first, or repeat with `runs=delete`."),
    "run_not_found": Kind("No such run", "It was deleted, or its id is misspelt."),
    "run_live": Kind("The run is not finished", "Cancel it first."),
    "run_finished": Kind("The run is finished", "A finished run cannot be cancelled any more."),
    "no_result": Kind("The run has no result", "It is not finished, or it did not succeed."),
    "table_not_found": Kind("No such table", "GET /api/v1/runs/ID/tables lists the tables of a run."),
    "chart_not_found": Kind("No such chart", "GET /api/v1/runs/ID/charts lists the charts of a run."),
    # Runs.
    "algorithm_not_found": Kind("No such algorithm", "GET /api/v1/algorithms lists them."),
    "kind_mismatch": Kind(
        "The algorithm does not take this kind of recording", "Its `takes` lists the kinds that it takes."
    ),
    "label_repeated": Kind("A label is used twice", "Charts and tables tell entries apart by their labels."),
    "source_missing": Kind("The run has no source, or several", "Give exactly one."),
    "site_missing": Kind(
        "The recording has no site",
        "Measured times and frequencies mean nothing without the places of the stations. Read the recording again "
        "with its site.",
    ),
    "trials_of_a_recording": Kind("A recording is one trial", "Many trials need a scenario."),
    "scenario_not_available": Kind("Scenarios cannot be run yet", "Give a recording."),
    "study_not_available": Kind("Studies cannot be run yet", "Give algorithms and a recording."),
    "sweep_not_available": Kind("Sweeps cannot be run yet", "Give one entry per value."),
    "recordings_not_available": Kind("Several recordings cannot be run together yet", "Give one."),
    # Data and parameters.
    "input": Kind("The data or the parameters cannot be used", "The detail says which and why."),
    "parameter": Kind("A parameter cannot be used", "The detail names it and its limits."),
    "recording": Kind("The recording cannot serve", "It lacks something that the algorithm needs."),
    "mark_format": Kind("A line of a file is not as it must be", "The detail names line and column."),
    "unsupported_format": Kind("No reader knows this format", "The detail says what was recognised."),
    "frame": Kind("A coordinate is outside of what a conversion can do", "Check units and origin."),
    "algorithm": Kind("The method could not go on", "The detail names the instant and the track."),
    "singular_geometry": Kind("Nothing can be solved from these stations", "They stand on a line, or on one point."),
    "not_positive_definite": Kind("A covariance lost its meaning", "Usually the noise parameters are unrealistic."),
}
