"""Make the bundled sample of forward scatter. Run: uv run python examples/make_doppler_sample.py

Three targets cross a base line of 40 km after one another, at 12, 18 and 24 km from two receivers 300 m apart; one
Doppler in twelve is missing; an azimuth with an error of half a degree. The same seed gives the same bytes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.site import Origin
from backend.files.native_csv_writer import write_native_csv

FOLDER = Path(__file__).parent / "recordings"
ORIGIN = Origin(latitude_deg=55.75, longitude_deg=37.62, height_m=150.0)
SEED = 2014


def main() -> None:
    """Write the sample recording and its site."""
    passes = PassParameters(
        crossing_distance_m=12_000.0,
        distance_step_m=6_000.0,
        course_deg=80.0,
        bearing_deg=60.0,
        targets=3,
        target_interval_s=120.0,
        missing_share=1 / 12,
    )
    made = simulate(passes, (0,), SEED)
    assert made.site is not None
    recording = replace(
        made,
        truth_m=np.round(made.truth_m, 3),
        truth_velocity_mps=np.round(made.truth_velocity_mps, 4),
        doppler_hz=np.round(made.doppler_hz, 3),
        azimuth_rad=np.radians(np.round(np.degrees(made.azimuth_rad), 4)),
        site=made.site.model_copy(update={"origin": ORIGIN}),
    )
    FOLDER.mkdir(exist_ok=True)
    assert recording.site is not None
    with (FOLDER / "sample_dopplers.csv").open("w", encoding="utf-8", newline="") as stream:
        write_native_csv(recording, stream)
    site = json.dumps(recording.site.to_json(), indent=2) + "\n"
    (FOLDER / "sample_doppler_site.json").write_text(site, encoding="utf-8")


if __name__ == "__main__":
    main()
