"""What a run worked on, as far as charts and tables need it: one recording, joined ones, or the first trial."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from algorithms.recording import Recording, recording_from_arrays
from backend.api import uploads
from backend.api.run_recordings import is_joined
from backend.api.services import Services
from backend.db import runs as stored
from backend.db.recordings import Recording as StoredRecording

if TYPE_CHECKING:
    from backend.jobs.partial_results import PartialRun

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True)
class Measurements:
    """Measurements that can be loaded when they are needed.

    Attributes
    ----------
    id : what a person tells them by
    key : the same for the same measurements, site and truth
    recording_id : None where they were simulated or come from several recordings
    site, start_utc : as stored
    arrays : gives them, each array read when it is asked for
    """

    id: str
    key: str
    recording_id: str | None
    name: str
    start_utc: str | None
    site: Mapping[str, Any] | None
    arrays: Callable[[], Arrays]

    @property
    def targets(self) -> tuple[str, ...]:
        """Names of the targets, without reading the marks."""
        return tuple(json.loads(bytes(self.arrays()["meta"]).decode())["targets"])

    def load(self) -> Recording:
        """Load all of it."""
        return recording_from_arrays(self.arrays())


def of_recording(services: Services, recording: StoredRecording) -> Measurements:
    """Return the measurements of a recording that has been read."""
    sha256 = recording.data_sha256
    assert sha256 is not None
    return Measurements(
        id=recording.id,
        key=sha256,
        recording_id=recording.id,
        name=recording.name,
        start_utc=recording.start_utc,
        site=recording.site,
        arrays=lambda: services.store.get_arrays(sha256),
    )


def of_run(services: Services, run: stored.Run, partial: PartialRun | None = None) -> Measurements:
    """Return what a run worked on; `partial` is given where its trials still run."""
    if "recording_id" in run.source:
        return of_recording(services, uploads.ready(services, str(run.source["recording_id"])))
    own = _in_result(services, run) if partial is None else partial.first
    meta = json.loads(bytes(own["meta"]).decode())
    if is_joined(run.source):
        origin = json.dumps(run.source["recording_ids"])
    else:
        origin = json.dumps([run.source["scenario"], run.source.get("sweep"), run.seed], sort_keys=True)
    key = hashlib.sha256(origin.encode()).hexdigest()
    return Measurements(
        id=key[:16],
        key=key,
        recording_id=None,
        name=str(run.source["name"]),
        start_utc=meta["start_utc"],
        site=meta["site"],
        arrays=lambda: own,
    )


def _in_result(services: Services, run: stored.Run) -> Arrays:
    from backend.jobs.results import load_arrays

    arrays = load_arrays(services.store, run)
    prefix = "recording/"
    return {name.removeprefix(prefix): arrays[name] for name in arrays if name.startswith(prefix)}
