"""The bundled sample: a recording and a run on it, so that a new user sees tracks before having any file at hand."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

from algorithms.errors import FilterRoomError
from backend.api import uploads
from backend.api.run_schemas import EntryIn, RunIn
from backend.api.runs import queue_run
from backend.api.services import Services
from backend.http.multipart import Part, received
from backend.http.problems import ProblemError

logger = logging.getLogger("filterroom.samples")

_BACKEND = Path(__file__).resolve().parent.parent
_FILES = {"file": "sample_marks.csv", "site": "sample_site.json"}
_ALGORITHMS = ("single_mark", "rdf", "rdfv")
_MARKER = "samples-imported"


def sample_folder() -> Path:
    """Return the folder of the sample: inside the package in a wheel, at the top of a checkout."""
    installed = _BACKEND / "samples"
    return installed if installed.is_dir() else _BACKEND.parent / "examples" / "recordings"


def import_samples(services: Services) -> None:
    """Upload the sample and run three algorithms on it, once in the life of a data folder.

    Goes the way of every upload and every run. A failure is logged: the server works without a sample.
    """
    marker = services.settings.data_dir / _MARKER
    if marker.exists():
        return
    try:
        with received() as parts:
            for name, file_name in _FILES.items():
                path = services.store.temporary()
                shutil.copyfile(sample_folder() / file_name, path)
                parts.items.append(Part(name, file_name, path, path.stat().st_size))
            recording = uploads.from_form(services, parts).recording
        queue_run(
            services,
            RunIn(
                algorithms=[EntryIn(name=name) for name in _ALGORITHMS],
                recording_id=recording.id,
                label="Sample: three algorithms on simulated marks",
                tags=["sample"],
            ),
        )
    except (FilterRoomError, ProblemError, OSError):
        logger.exception("the sample could not be imported")
        return
    marker.touch()
