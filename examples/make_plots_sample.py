"""Make the sample of two radars: plots of six aircraft. Run: uv run python examples/make_plots_sample.py

Twenty looks, missed detections, false plots, true positions, and a second radar whose north is off by 0.3 degrees: the
registration alarm has something to find. The same seed gives the same bytes.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from algorithms.recording import PolarPlots
from algorithms.site import Site
from backend.files.native_csv_writer import write_native_csv

FOLDER = Path(__file__).parent / "recordings"
SEED = 2008
LOOKS, PERIOD_S = 20, 10.0
DETECTION, FALSE_PLOTS = 0.92, 2
MIDDLE_M, SIDE_M = np.array([20_000.0, 90_000.0]), 30_000.0
TURNED_RAD = np.radians(0.3)
SITE = Site.model_validate(
    {
        "origin": {"latitude_deg": 55.75, "longitude_deg": 37.62, "height_m": 150.0},
        "radars": [
            {"name": "west", "east_m": 0, "north_m": 0, "up_m": 0, "sigma_range_m": 80, "sigma_azimuth_deg": 0.25,
             "range_kind": "ground"},
            {"name": "east", "east_m": 40000, "north_m": 0, "up_m": 0, "sigma_range_m": 80, "sigma_azimuth_deg": 0.25,
             "range_kind": "ground"},
        ],
    }
)  # fmt: skip
# East and north from the middle (km), course (degrees), speed (m/s).
AIRCRAFT = (
    (-9.0, -6.0, 80.0, 180.0), (-9.0, -4.6, 80.0, 180.0), (6.0, 9.0, 200.0, 210.0), (-2.0, -9.0, 20.0, 160.0),
    (9.0, 2.0, 270.0, 230.0), (0.0, 10.0, 140.0, 150.0),
)  # fmt: skip


def main() -> None:
    """Write the recording and its site."""
    rng = np.random.default_rng(SEED)
    rows: list[tuple[float, int, int, float, float, float, float]] = []
    places = SITE.radar_positions()[:, :2]
    for look in range(LOOKS):
        time = PERIOD_S * look
        for radar in range(2):
            for target, (east, north, course, speed) in enumerate(AIRCRAFT):
                way = speed * time * np.array([np.sin(np.radians(course)), np.cos(np.radians(course))])
                truth = MIDDLE_M + 1000 * np.array([east, north]) + way
                offset = truth - places[radar]
                error = rng.standard_normal(2)
                seen = rng.random() < DETECTION
                if not seen:
                    continue
                range_m = float(np.hypot(*offset)) + 80 * error[0]
                turned = TURNED_RAD if radar == 1 else 0.0
                azimuth = float(np.arctan2(offset[0], offset[1])) + np.radians(0.25) * error[1] + turned
                rows.append((time, radar, target, range_m, azimuth, truth[0], truth[1]))
            for _ in range(FALSE_PLOTS):
                offset = MIDDLE_M + (rng.random(2) - 0.5) * SIDE_M - places[radar]
                azimuth = float(np.arctan2(offset[0], offset[1]))
                rows.append((time, radar, len(AIRCRAFT), float(np.hypot(*offset)), azimuth, np.nan, np.nan))
    table = np.array(rows)
    count = len(rows)
    none, unnamed = np.full((count, 1), np.nan), np.full(count, -1)
    truth_m = np.column_stack([table[:, 5], table[:, 6], np.where(np.isfinite(table[:, 5]), 0.0, np.nan)])
    recording = PolarPlots(
        time_s=table[:, 0],
        row=np.arange(1, count + 1),
        target=table[:, 2].astype(np.int64),
        targets=(*(f"AC{i + 1}" for i in range(len(AIRCRAFT))), "clutter"),
        truth_m=np.round(truth_m, 1),
        site=SITE,
        range_m=np.round(table[:, 3:4], 1),
        azimuth_rad=np.mod(table[:, 4:5], 2 * np.pi),
        elevation_rad=none,
        altitude_m=none,
        east_m=none,
        north_m=none,
        radar=table[:, 1].astype(np.int64),
        radars=tuple(r.name for r in SITE.radars),
        radar_east_m=np.full(count, np.nan),
        radar_north_m=np.full(count, np.nan),
        scan=np.round(table[:, 0] / PERIOD_S).astype(np.int64),
        address=unnamed,
        callsign=unnamed,
    )
    FOLDER.mkdir(exist_ok=True)
    with (FOLDER / "sample_plots.csv").open("w", encoding="utf-8", newline="") as stream:
        write_native_csv(recording, stream)
    (FOLDER / "sample_radars.json").write_text(json.dumps(SITE.to_json(), indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
