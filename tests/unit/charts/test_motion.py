"""Speed and acceleration: lengths of vectors, the truth as a derivative, the first view."""

from __future__ import annotations

import numpy as np

from algorithms.result import Table
from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions
from tests.chart_views import marks, run, states

SPEED, ACCELERATION = (charts("run")[name].draw for name in ("speed", "acceleration"))
VELOCITY = np.stack([3.0 * np.arange(6), 4.0 * np.arange(6), np.zeros(6)], axis=1)


def with_motion(**more: np.ndarray) -> Table:
    columns = {f"velocity_{a}_mps": VELOCITY[:, i] + 0.0 for i, a in enumerate(("east", "north", "up"))}
    columns |= {f"acceleration_{a}_mps2": np.full(6, v) for a, v in (("east", 2.0), ("north", 3.0), ("up", 6.0))}
    return states(marks(), **(columns | more))


def test_lengths_of_vectors_and_the_slope_of_the_true_velocity(traces_of) -> None:
    recording = marks(truth_velocity_mps=VELOCITY)
    view = run(recording, {"states": with_motion()})
    speed, acceleration = SPEED(view, ChartOptions()), ACCELERATION(view, ChartOptions())
    np.testing.assert_allclose(traces_of(speed, "series")[0]["y"], 5.0 * np.arange(6))
    np.testing.assert_allclose(traces_of(speed, "truth")[0]["y"], 5.0 * np.arange(6))
    np.testing.assert_allclose(traces_of(acceleration, "series")[0]["y"], 7.0)
    np.testing.assert_allclose(traces_of(acceleration, "truth")[0]["y"], 5.0)
    assert acceleration["layout"]["yaxis"]["title"]["text"] == "Acceleration, m/s²"


def test_the_first_view_follows_the_truth(note_of) -> None:
    wild = np.full(6, 2.0)
    wild[0] = 900.0
    view = run(marks(truth_velocity_mps=VELOCITY), {"states": with_motion(acceleration_east_mps2=wild)})
    drawn = ACCELERATION(view, ChartOptions())
    assert drawn["layout"]["yaxis"]["range"][1] < 20
    assert note_of(drawn, "above_view")


def test_without_accelerations_it_says_so() -> None:
    nothing = {f"acceleration_{a}_mps2": np.full(6, np.nan) for a in ("east", "north", "up")}
    drawn = ACCELERATION(run(marks(), {"states": with_motion(**nothing)}), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_acceleration"
