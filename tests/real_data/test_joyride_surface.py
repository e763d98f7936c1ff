"""A hard-manoeuvring boat among other vessels: the model set for surface craft holds it up to 558 s."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from algorithms.multiple_model import multiple_model
from algorithms.multiple_model.multiple_model import MultipleModelParameters
from algorithms.spec import LocalContext
from backend.files.reading import NamedFile, ReadOptions, read_recording

HELD_S = 558.0


def test_the_boat_is_held(shared_data: Path) -> None:
    folder = shared_data / "radar_joyride"
    if not folder.is_dir():
        pytest.skip("the recordings do not lie beside the checkout")
    plots = NamedFile("joyride_plots.csv", folder / "joyride_plots.csv")
    recording, _ = read_recording([plots], options=ReadOptions(mapping={"time_s": "t_s"}))
    truth = np.genfromtxt(folder / "joyride_truth.csv", delimiter=",", names=True)
    # Accuracies of the data's note: 12 m east, 14 m north.
    parameters = MultipleModelParameters(model_set="surface", sigma_east_m=12.0, sigma_north_m=14.0)
    result = multiple_model.run(recording, parameters, LocalContext())
    state, track = result.arrays["state"][:, :, 0], result.arrays["track"][:, 0]
    east, north = (np.interp(recording.time_s, truth["t_s"], truth[f"tgt_{a}_m"]) for a in ("east", "north"))
    error = np.hypot(state[:, 0] - east, state[:, 3] - north)
    off = np.hypot(recording.east_m[:, 0] - east, recording.north_m[:, 0] - north)
    seen: list[bool] = []
    errors = []
    for time in np.unique(recording.time_s):
        rows = np.flatnonzero(recording.time_s == time)
        seen.append(bool((off[rows] < 50).any()))
        here = error[rows][np.isfinite(error[rows])]
        if time > HELD_S or not here.size:
            continue
        errors.append(here[0])
        if len(seen) >= 4 and all(seen[-4:]):
            assert here[0] < 100, time
    assert max(errors) < 200
    assert np.sqrt(np.mean(np.square(errors))) < 40
    early = (recording.time_s <= HELD_S) & (track > 0)
    assert len(np.unique(track[early])) == 1
    codes = {result.notes[i].code for i in range(len(result.notes))}
    assert "object_doubtful" in codes
