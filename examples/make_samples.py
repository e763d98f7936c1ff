"""Make the bundled sample: two simulated aircraft heard by four stations. Run: uv run python examples/make_samples.py

Irregular marks, many of them incomplete, one reception in two hundred late by microseconds, altitude in 25 ft steps
with a bias of 40 m, true positions beside them. The same seed gives the same bytes.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from algorithms.multilateration.scenario import four_stations
from algorithms.recording import ToaMarks
from algorithms.site import Origin
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.scenario.marks import MarkNoise, simulate_marks
from algorithms.toolbox.scenario.trajectory import Segment, fly
from backend.files.native_csv_writer import write_native_csv

FOLDER = Path(__file__).parent / "recordings"
ORIGIN = Origin(latitude_deg=55.75, longitude_deg=37.62, height_m=150.0)
SEED = 2023

ARRIVAL = (
    Segment(duration_s=240),
    Segment(duration_s=60, turn_rate_deg_s=1.5, climb_rate_mps=-6),
    Segment(duration_s=140, climb_rate_mps=-6),
    Segment(duration_s=60, turn_rate_deg_s=-1.0),
    Segment(duration_s=200),
)
OVERFLIGHT = (
    Segment(duration_s=300),
    Segment(duration_s=80, turn_rate_deg_s=-1.0, climb_rate_mps=5),
    Segment(duration_s=320),
)


def emitter(name: str, segments: tuple[Segment, ...], trial: int, **start: float) -> ToaMarks:
    """Simulate the marks of one aircraft."""
    site = four_stations(origin=ORIGIN.model_dump(), sigma_toa_ns=10.0, sigma_altitude_m=100.0, gate_length_s=0.012)
    earth = earths.wgs84(ORIGIN)
    rng = np.random.default_rng((SEED, trial))
    time = np.cumsum(0.5 + rng.exponential(0.7, 1200))
    time = np.round(time[time < 699], 6)
    path = fly(time, segments, earth=earth, **start)
    fading = 0.5 + 0.5 * np.cos(2 * np.pi * (time[:, None] / 700 + np.array([0.0, 0.25, 0.5, 0.75])))
    noise = MarkNoise(
        sigma_toa_s=10e-9,
        reception_probability=0.55 + 0.43 * fading,
        altitude_bias_sd_m=40.0,
        altitude_step_m=7.62,
        decoding_probability=0.92,
        gate_length_s=0.012,
        outlier_share=0.005,
    )
    toa, altitude, emission = simulate_marks(path, site.station_positions(), noise, (trial,), SEED)
    return ToaMarks(
        time_s=time,
        row=np.arange(1, time.size + 1),
        target=np.zeros(time.size, np.int64),
        targets=(name,),
        truth_m=path.position_m + emission * path.velocity_mps,
        truth_velocity_mps=path.velocity_mps,
        site=site,
        toa_s=np.round(toa, 12),
        altitude_m=np.round(altitude, 2),
        stations=tuple(s.name for s in site.stations),
    )


def together(parts: list[ToaMarks]) -> ToaMarks:
    """Merge the aircraft by time, as a receiver system would deliver them."""
    time = np.concatenate([p.time_s for p in parts])
    order = np.argsort(time, kind="stable")
    return ToaMarks(
        time_s=time[order],
        row=np.arange(1, time.size + 1),
        target=np.concatenate([np.full(len(p), i) for i, p in enumerate(parts)])[order],
        targets=tuple(p.targets[0] for p in parts),
        truth_m=np.round(np.concatenate([p.truth_m for p in parts])[order], 3),
        site=parts[0].site,
        toa_s=np.concatenate([p.toa_s for p in parts])[order],
        altitude_m=np.concatenate([p.altitude_m for p in parts])[order],
        stations=parts[0].stations,
    )


def main() -> None:
    """Write the sample recording and its site."""
    recording = together(
        [
            emitter("ARR101", ARRIVAL, 0, east_m=70_000.0, north_m=18_000.0, altitude_m=6_000.0, heading_deg=255.0,
                    speed_mps=170.0),
            emitter("OVR202", OVERFLIGHT, 1, east_m=-45_000.0, north_m=-20_000.0, altitude_m=9_000.0,
                    heading_deg=62.0, speed_mps=220.0),
        ]
    )  # fmt: skip
    FOLDER.mkdir(exist_ok=True)
    assert recording.site is not None
    with (FOLDER / "sample_marks.csv").open("w", encoding="utf-8", newline="") as stream:
        write_native_csv(recording, stream)
    (FOLDER / "sample_site.json").write_text(json.dumps(recording.site.to_json(), indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
