"""Make the sample of an object before a flat antenna. Run: uv run python examples/make_antenna_sample.py

Ballistic arc, a manoeuvre of 15 g, free flight again; four plots a second, of which some are missing,
and five seconds have none at all; the true path beside them. The same seed gives the same bytes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from algorithms.multiple_model.scenario import AeroballisticParameters, simulate
from algorithms.recording import AntennaPlots
from algorithms.toolbox.scenario.timing import Gap
from backend.files.native_csv_writer import write_native_csv

FOLDER = Path(__file__).parent / "recordings"
SEED = 2023


def before_the_antenna() -> AntennaPlots:
    """Simulate the plots; figures are rounded as a radar would give them."""
    parameters = AeroballisticParameters(rate_hz=4.0, detection_probability=0.97, gaps=(Gap(start_s=60, stop_s=65),))
    all_ = simulate(parameters, (0,), SEED)
    seen = np.flatnonzero(np.isfinite(all_.range_m[:, 0]))
    return replace(
        all_,
        time_s=all_.time_s[seen],
        row=np.arange(1, seen.size + 1),
        target=np.zeros(seen.size, np.int64),
        targets=("OBJECT",),
        range_m=np.round(all_.range_m[seen], 2),
        bicone_elevation_rad=np.radians(np.round(np.degrees(all_.bicone_elevation_rad[seen]), 5)),
        bicone_azimuth_rad=np.radians(np.round(np.degrees(all_.bicone_azimuth_rad[seen]), 5)),
        truth_m=np.round(all_.truth_m[seen], 2),
        truth_velocity_mps=np.round(all_.truth_velocity_mps[seen], 3),
    )


def main() -> None:
    """Write the recording and its site."""
    recording = before_the_antenna()
    assert recording.site is not None
    with (FOLDER / "sample_antenna.csv").open("w", encoding="utf-8", newline="") as stream:
        write_native_csv(recording, stream)
    site = json.dumps(recording.site.to_json(), indent=2)
    (FOLDER / "sample_antenna_site.json").write_text(site + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
