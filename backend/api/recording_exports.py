"""A recording for other tools, in forms that the readers read back as the same rows."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from algorithms.recording import recording_from_arrays
from backend.api import uploads
from backend.api.exports import BYTES, MATLAB, PARQUET, NoQuery, sent
from backend.api.responses import content, problems
from backend.api.services import Services, ServicesDep
from backend.files.recording_writer import RecordingForm
from backend.version import program_version

CSV = "text/csv"

router = APIRouter(prefix="/recordings/{recording_id}", tags=["recordings"])


@router.get(
    "/data.parquet",
    name="get_recording_parquet",
    response_class=Response,
    responses=content(PARQUET, "The native columns as Parquet; reads back as the same recording", BYTES)
    | problems(404, 409),
)
def get_recording_parquet(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the accepted rows as Parquet, with start and site in the metadata."""
    return _written(services, request, recording_id, "parquet", PARQUET)


@router.get(
    "/data.mat",
    name="get_recording_matlab",
    response_class=Response,
    responses=content(MATLAB, "The native columns as a MATLAB struct; reads back as the same recording", BYTES)
    | problems(404, 409, 413),
)
def get_recording_matlab(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the accepted rows as a MATLAB file, with start and site beside them."""
    return _written(services, request, recording_id, "mat", MATLAB)


@router.get(
    "/data.npz",
    name="get_recording_numpy",
    response_class=Response,
    responses=content(
        "application/octet-stream", "The native columns as NumPy arrays; reads back as the same recording", BYTES
    )
    | problems(404, 409),
)
def get_recording_numpy(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the accepted rows as a NumPy archive; `numpy.load` reads it without pickle."""
    return _written(services, request, recording_id, "npz", "application/octet-stream")


TRUTH = "The true paths, whole; given as `truth` they are read as the same paths"


@router.get(
    "/truth.csv",
    name="get_truth_csv",
    response_class=Response,
    responses=content(CSV, TRUTH) | problems(404, 409),
)
def get_truth_csv(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the true paths of a recording as CSV."""
    return _written(services, request, recording_id, "csv", f"{CSV}; charset=utf-8", truth=True)


@router.get(
    "/truth.parquet",
    name="get_truth_parquet",
    response_class=Response,
    responses=content(PARQUET, TRUTH, BYTES) | problems(404, 409),
)
def get_truth_parquet(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the true paths of a recording as Parquet, with the start in the metadata."""
    return _written(services, request, recording_id, "parquet", PARQUET, truth=True)


@router.get(
    "/truth.mat",
    name="get_truth_matlab",
    response_class=Response,
    responses=content(MATLAB, TRUTH, BYTES) | problems(404, 409, 413),
)
def get_truth_matlab(
    recording_id: str, request: Request, services: ServicesDep, query: Annotated[NoQuery, Query()]
) -> Response:
    """Give the true paths of a recording as a MATLAB file, with the start beside them."""
    return _written(services, request, recording_id, "mat", MATLAB, truth=True)


def _written(
    services: Services,
    request: Request,
    recording_id: str,
    form: RecordingForm,
    media_type: str,
    *,
    truth: bool = False,
) -> Response:
    recording = uploads.ready(services, recording_id)

    def write(path: Path) -> None:
        from backend.files.recording_writer import write_recording, write_truth

        assert recording.data_sha256 is not None
        data = recording_from_arrays(services.store.get_arrays(recording.data_sha256))
        (write_truth if truth else write_recording)(data, path, form)

    what = "truth" if truth else "recording"
    version = (program_version(), what, recording.data_sha256 or "")
    return sent(services, request, write, media_type, f"{what}-{recording_id}.{form}", version)
