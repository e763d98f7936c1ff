"""Make the bundled sample of plot tracking. Run: uv run python examples/make_tracking_sample.py

Ten aircraft around one radar for five minutes: straight flights, turns, a weave, a change of speed; every tenth plot is
missing, and each scan has ten false ones on average. The same seed gives the same bytes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from algorithms.plot_tracking.presets import BASE_10
from algorithms.plot_tracking.scenario import simulate_aircraft
from algorithms.site import Origin
from backend.files.native_csv_writer import write_native_csv

FOLDER = Path(__file__).parent / "recordings"
ORIGIN = Origin(latitude_deg=55.75, longitude_deg=37.62, height_m=150.0)
SEED = 2006


def main() -> None:
    """Write the sample recording and its site."""
    made = simulate_aircraft(BASE_10(detection_probability=0.9, false_plots=10.0, clutter_radius_m=90e3), (0,), SEED)
    assert made.site is not None
    measured = made.take(np.flatnonzero(np.isfinite(made.range_m[:, 0])))
    recording = replace(
        measured,
        row=np.arange(1, len(measured) + 1),
        truth_m=np.round(measured.truth_m * np.array([1.0, 1.0, 0.0]), 1) + 0.0,
        truth_velocity_mps=np.full((len(measured), 3), np.nan),
        range_m=np.round(measured.range_m, 1),
        azimuth_rad=np.radians(np.round(np.degrees(measured.azimuth_rad), 4)),
        site=made.site.model_copy(update={"origin": ORIGIN}),
    )
    FOLDER.mkdir(exist_ok=True)
    assert recording.site is not None
    with (FOLDER / "sample_tracking.csv").open("w", encoding="utf-8", newline="") as stream:
        write_native_csv(recording, stream)
    site = json.dumps(recording.site.to_json(), indent=2) + "\n"
    (FOLDER / "sample_tracking_radar.json").write_text(site, encoding="utf-8")


if __name__ == "__main__":
    main()
