"""Real receptions: each receiver with enough receptions, displaced or late in a copy, is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.receivers import FEWEST_RECEPTIONS, TOO_FEW, assess_receivers
from algorithms.recording import ToaMarks
from algorithms.site import Site
from backend.files.reading import NamedFile, ReadOptions, read_recording


@pytest.fixture(scope="module")
def recording(shared_data: Path) -> ToaMarks:
    folder = shared_data / "multilateration_locards"
    read, _ = read_recording(
        [NamedFile(n, folder / n) for n in ("set_1.csv", "set_2.csv")],
        site=(folder / "sensors.csv").read_bytes(),
        truth=None,
        options=ReadOptions(),
    )
    assert isinstance(read, ToaMarks)
    return read


def often_heard(recording: ToaMarks) -> np.ndarray:
    return np.flatnonzero(np.isfinite(recording.toa_s[:, :, 0]).sum(axis=0) >= FEWEST_RECEPTIONS)


def displaced(recording: ToaMarks, j: int, east_m: float, north_m: float) -> ToaMarks:
    assert recording.site is not None
    origin = recording.site.frame_origin()
    assert origin is not None
    places = recording.site.station_positions()
    places[j, :2] += east_m, north_m
    stations = [
        {"name": s, "east_m": p[0], "north_m": p[1], "up_m": p[2]}
        for s, p in zip(recording.stations, places, strict=True)
    ]
    site = {**recording.site.to_json(), "origin": origin.model_dump(), "stations": stations}
    return replace(recording, site=Site.model_validate(site))


def test_as_recorded_nobody_is_accused(recording: ToaMarks) -> None:
    verdicts = assess_receivers(recording, AltitudeParameters())
    heard = often_heard(recording)
    assert len(heard) == 17
    assert [verdicts[j].suspect for j in heard] == [False] * 17
    few = [v for j, v in enumerate(verdicts) if j not in heard]
    assert len(few) == 10
    assert all(v.suspect is None and v.reason == TOO_FEW for v in few)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(17))
def test_a_late_or_displaced_receiver_is_named(recording: ToaMarks, number: int) -> None:
    j = int(often_heard(recording)[number])
    toa = recording.toa_s.copy()
    toa[:, j] += 1e-6
    for faulty in (
        replace(recording, toa_s=toa),
        displaced(recording, j, 1_000.0, 0.0),
        displaced(recording, j, 0.0, -1_000.0),
    ):
        verdicts = assess_receivers(faulty, AltitudeParameters())
        assert [k for k, v in enumerate(verdicts) if v.suspect] == [j]
        assert verdicts[j].reason
