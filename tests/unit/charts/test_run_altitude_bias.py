"""Altimeter bias: the estimate, its band, and what it truly is."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm

from backend.charts.catalogue import charts
from backend.charts.view import ChartOptions
from tests.chart_views import complete_run, marks

DRAW = charts("run")["altitude_bias"].draw


def test_the_estimate_its_band_and_the_truth(traces_of) -> None:
    recording = marks(6)
    drawn = DRAW(complete_run(recording), ChartOptions(full=True))
    (line,) = traces_of(drawn, "series")
    np.testing.assert_allclose(line["y"], 25.0)
    (band,) = traces_of(drawn, "interval")
    reach = norm.ppf(0.975) * 10
    np.testing.assert_allclose(band["y"][:6], 25 - reach, atol=1e-4)
    (true,) = traces_of(drawn, "measurement")
    # 3000 m in the local frame are more above the sphere, 20 km away by 31 m.
    height = np.hypot(6_371_000 + 3000.0, np.hypot(*recording.truth_m[:, :2].T)) - 6_371_000
    np.testing.assert_allclose(true["y"], 3030 - height, atol=1e-3)


def test_without_any_estimate_it_says_so() -> None:
    nothing = np.full(6, np.nan)
    drawn = DRAW(complete_run(marks(6), altitude_bias_m=nothing), ChartOptions())
    assert drawn["layout"]["meta"]["not_applicable"] == "no_bias"
