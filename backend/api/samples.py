"""The bundled samples: a recording of each family and a run on it, so that a new user sees results at once.

To add one, put its files into `examples/recordings/` (made by `examples/make_samples.py`) and a line into `SAMPLES`.
"""

from __future__ import annotations

import logging
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from backend.api import uploads
from backend.api.run_schemas import EntryIn, RunIn
from backend.api.runs import queue_run
from backend.api.services import Services
from backend.http.multipart import Part, received

logger = logging.getLogger("filterroom.samples")


@dataclass(frozen=True)
class Sample:
    """A bundled recording (part of the upload: file) and the run on it."""

    name: str
    files: Mapping[str, str]
    algorithms: tuple[str, ...]
    label: str
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    """By name of the algorithm, where the defaults do not fit the recording."""


# The last one stands at the top of the list of runs.
SAMPLES = (
    Sample(
        name="tracking",
        files={"file": "sample_tracking.csv", "site": "sample_tracking_radar.json"},
        algorithms=("imm_tracker", "curvature_tracker"),
        label="Sample: tracks of ten aircraft from the plots of one radar",
        parameters={"curvature_tracker": {"performance": "airliner"}},
    ),
    Sample(
        name="plots",
        files={"file": "sample_plots.csv", "site": "sample_radars.json"},
        algorithms=("pairwise_test", "assignment", "track_association"),
        label="Sample: which plots of two radars are one aircraft",
        parameters={
            "assignment": {"detection_probability": 0.92, "clutter_per_radar": 2.0, "region_area_m2": 9e8},
        },
    ),
    Sample(
        name="dopplers",
        files={"file": "sample_dopplers.csv", "site": "sample_doppler_site.json"},
        algorithms=("forward_scatter_ml", "forward_scatter_lines", "forward_scatter_angle"),
        label="Sample: three passes across a base line",
    ),
    Sample(
        name="antenna",
        files={"file": "sample_antenna.csv", "site": "sample_antenna_site.json"},
        algorithms=("multiple_model", "mma2_122", "switched_kalman", "model_smoother"),
        label="Sample: ballistic arc and a manoeuvre before an antenna",
    ),
    Sample(
        name="marks",
        files={"file": "sample_marks.csv", "site": "sample_site.json"},
        algorithms=("single_mark", "rdf", "rdfv"),
        label="Sample: three algorithms on simulated marks",
    ),
)

_BACKEND = Path(__file__).resolve().parent.parent
# Holds the names of what was imported, one a line.
_MARKER = "samples-imported"


def sample_folder() -> Path:
    """Return the folder of the samples: inside the package in a wheel, at the top of a checkout."""
    installed = _BACKEND / "samples"
    return installed if installed.is_dir() else _BACKEND.parent / "examples" / "recordings"


def import_samples(services: Services) -> None:
    """Upload each sample and run its algorithms on it, once in the life of a data folder.

    Goes the way of every upload and every run. A failure is logged: the server works without samples.
    """
    marker = services.settings.data_dir / _MARKER
    known = marker.read_text("utf-8").split() if marker.exists() else []
    # What failed is tried once more: a server that is still starting has other threads that import the same packages.
    for sample in SAMPLES + SAMPLES:
        if sample.name in known:
            continue
        try:
            _import(services, sample)
        except Exception:
            # Whatever it was, it is said, and the other samples come; an error that left here was seen by nobody.
            logger.exception("the sample %s could not be imported", sample.name)
            continue
        known.append(sample.name)
        marker.write_text("\n".join(known) + "\n", "utf-8")


def _import(services: Services, sample: Sample) -> None:
    with received() as parts:
        for name, file_name in sample.files.items():
            path = services.store.temporary()
            shutil.copyfile(sample_folder() / file_name, path)
            parts.items.append(Part(name, file_name, path, path.stat().st_size))
        recording = uploads.from_form(services, parts).recording
    if recording.state == "parsing":
        # An answer to a user has a limit of its own; here nobody waits, and a busy machine may take its time.
        recording = services.engine.read_recording(recording.id).result()
    queue_run(
        services,
        RunIn(
            algorithms=[
                EntryIn(name=name, parameters=dict(sample.parameters.get(name, {}))) for name in sample.algorithms
            ],
            recording_id=recording.id,
            label=sample.label,
            tags=["sample"],
        ),
    )
