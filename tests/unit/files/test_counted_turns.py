"""Azimuths as radars count them: in parts of a turn; altitudes in feet and flight levels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from algorithms.recording import PolarPlots
from backend.files.reading import NamedFile, ReadOptions, read_recording

TIMES = np.arange(12.0)
AZIMUTH_DEG = np.mod(350.0 + 2.5 * TIMES, 360.0)


def read(folder: Path, azimuths: np.ndarray, unit: str, altitude: float = 0.0, altitude_unit: str = "m") -> PolarPlots:
    rows = "".join(f"{t},50000,{a:.10g},{altitude}\n" for t, a in zip(TIMES, azimuths, strict=True))
    path = folder / "plots.csv"
    path.write_text(f"time_s,range_m,az,h\n{rows}")
    file = NamedFile("plots.csv", path)
    mapping = {"azimuth_deg": {"column": "az", "unit": unit}, "altitude_m": {"column": "h", "unit": altitude_unit}}
    recording, _ = read_recording([file], options=ReadOptions(mapping=mapping))
    assert isinstance(recording, PolarPlots)
    return recording


@pytest.mark.parametrize(("unit", "of_degrees"), [("deg", 1.0), ("turn", 1 / 360), ("turn/65536", 65536 / 360)])
def test_azimuths_of_every_count_are_the_same(tmp_path: Path, unit: str, of_degrees: float) -> None:
    found = read(tmp_path, AZIMUTH_DEG * of_degrees, unit)
    np.testing.assert_allclose(np.mod(found.azimuth_rad[:, 0], 2 * np.pi), np.radians(AZIMUTH_DEG), rtol=1e-9)


@pytest.mark.parametrize(("unit", "value"), [("ft", 33_000.0), ("FL", 330.0)])
def test_altitudes_in_feet_and_flight_levels(tmp_path: Path, unit: str, value: float) -> None:
    found = read(tmp_path, AZIMUTH_DEG, "deg", value, unit)
    np.testing.assert_allclose(found.altitude_m, 33_000 * 0.3048)
