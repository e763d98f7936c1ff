"""A file of CAT 048 with a hundred aircraft, written with libasterix: tracked without their addresses and with them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from algorithms.plot_tracking.imm_tracker import run
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.spec import LocalContext
from algorithms.toolbox.frames.earth import sphere
from algorithms.toolbox.scenario.targets import Target, path_of
from algorithms.toolbox.scenario.trajectory import Segment
from backend.files.reading import NamedFile, read_recording
from tests.asterix_files import NM, cat048, north, plot

AIRCRAFT, SCANS, PERIOD_S = 100, 16, 5.0
SIGMA_RANGE_M, SIGMA_AZIMUTH_DEG = 60.0, 0.07
START_S = 36_000.0


def aircraft(rng: np.random.Generator) -> list[Target]:
    """Straight, turning and climbing; every tenth pair of them crosses in the midst."""
    out = []
    for i in range(AIRCRAFT):
        rate = float(rng.choice([-3.0, -1.5, 1.5, 3.0])) if i % 4 == 1 else 0.0
        climb = float(rng.uniform(5, 15)) if i % 4 == 2 else 0.0
        course, speed = float(rng.uniform(0, 360)), float(rng.uniform(120, 250))
        radius, angle = rng.uniform(25e3, 140e3), rng.uniform(0, 2 * np.pi)
        east, up_north = radius * np.sin(angle), radius * np.cos(angle)
        if i % 10 == 9:
            # It meets the one before after half the time: the same place in the plane, 300 m lower.
            other = out[-1]
            half = SCANS * PERIOD_S / 2
            meet = path_of(other).at(np.array([half]), sphere()).position_m[0]
            course = other.heading_deg + 60.0
            way = speed * half
            east, up_north = meet[0] - way * np.sin(np.radians(course)), meet[1] - way * np.cos(np.radians(course))
            rate, climb = 0.0, 0.0
        altitude = out[-1].altitude_m - 300.0 if i % 10 == 9 else float(rng.uniform(4_000, 11_000))
        turn = Segment(duration_s=40, turn_rate_deg_s=rate, climb_rate_mps=climb)
        straight = Segment(duration_s=60, climb_rate_mps=climb)
        segments = (straight.model_copy(update={"duration_s": 20.0}), turn, straight) if i % 10 != 8 else (
            straight.model_copy(update={"duration_s": 120.0}),)  # fmt: skip
        out.append(Target(east_m=east, north_m=up_north, altitude_m=altitude, heading_deg=course % 360,
                          speed_mps=speed, segments=segments))  # fmt: skip
    return out


@cache
def written() -> bytes:
    rng = np.random.default_rng(48)
    records: list[tuple[float, bytes]] = [
        (START_S + k * PERIOD_S, north(START_S + k * PERIOD_S)) for k in range(SCANS + 1)
    ]
    for i, target in enumerate(aircraft(rng)):
        path = path_of(target)
        for scan in range(SCANS):
            time = scan * PERIOD_S
            # The antenna comes by a little later than the turn begins; three steps find when.
            for _ in range(3):
                here = path.at(np.array([time]), sphere())
                east, up_north, up = here.position_m[0]
                azimuth = np.mod(np.arctan2(east, up_north), 2 * np.pi)
                time = (scan + azimuth / (2 * np.pi)) * PERIOD_S
            slant = float(np.sqrt(east**2 + up_north**2 + up**2)) + SIGMA_RANGE_M * rng.standard_normal()
            seen = np.degrees(azimuth) + SIGMA_AZIMUTH_DEG * rng.standard_normal()
            level = float(here.altitude_m[0]) / 0.3048 / 100
            record = plot(START_S + time, slant / NM, seen % 360, address=0x400000 + i, level=round(level * 4) / 4)
            records.append((START_S + time, cat048(record)))
    return b"".join(data for _, data in sorted(records, key=lambda r: r[0]))


@pytest.mark.parametrize("addresses", [False, True])
@pytest.mark.parametrize("association", ["joint", "nearest"])
def test_a_hundred_aircraft_are_a_hundred_tracks(tmp_path: Path, association: str, addresses: bool) -> None:
    file = tmp_path / "traffic.ast"
    file.write_bytes(written())
    recording, _ = read_recording([NamedFile(file.name, file)])
    assert len(recording) == AIRCRAFT * SCANS
    told = recording if addresses else replace(recording, address=np.full(len(recording), -1))
    parameters = ImmParameters(
        sigma_range_m=SIGMA_RANGE_M, sigma_azimuth_deg=SIGMA_AZIMUTH_DEG, association=association
    )
    arrays = run(told, parameters, LocalContext()).arrays
    confirmed = np.unique(arrays["estimate_track"])
    assert abs(confirmed.size - AIRCRAFT) <= 2
    address = recording.address
    track = arrays["track"][:, 0]
    pure = total = switches = 0
    for number in confirmed:
        mine = address[track == number]
        pure += int(np.bincount(mine).max())
        total += mine.size
    assert total >= 0.99 * AIRCRAFT * SCANS
    assert pure / total >= 0.999
    for i in range(AIRCRAFT):
        numbers = track[(address == i) & (track > 0)]
        switches += int((np.diff(numbers) != 0).sum())
    assert switches <= 5
