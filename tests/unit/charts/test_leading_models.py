"""The plan in the colours of the leading models."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.result import Table
from backend.charts import theme
from backend.charts.multiple_model import leading_models
from backend.charts.view import ChartOptions
from tests import chart_views

NAMES = ("cv_0.05", "ca_30")


def drawn(shares: list[tuple[float, float]]) -> dict[str, Any]:
    recording = chart_views.marks(len(shares))
    probabilities = Table(
        {
            "time_s": np.repeat(recording.time_s, 2), "model": list(NAMES) * len(shares),
            "probability": np.array(shares).ravel(), "row": np.repeat(recording.row, 2),
        }
    )  # fmt: skip
    tables = {"states": chart_views.states(recording), "mode_probabilities": probabilities}
    return leading_models.draw(chart_views.run(recording, tables), ChartOptions())


def test_each_estimate_has_the_colour_of_its_leading_model() -> None:
    data = [t for t in drawn([(0.9, 0.1), (0.2, 0.8), (0.5, 0.5), (0.1, 0.9)])["data"] if t["meta"]["role"] == "series"]
    assert [t["name"] for t in data] == ["cv_0.05", "ca_30"]
    assert [t["customdata"].tolist() for t in data] == [[1, 3], [2, 4]], "of equal ones the first leads"
    assert [t["marker"]["color"] for t in data] == [theme.series_color(0), theme.series_color(1)]


def test_a_model_that_never_leads_is_not_drawn() -> None:
    data = [t for t in drawn([(0.9, 0.1)] * 3)["data"] if t["meta"]["role"] == "series"]
    assert [t["name"] for t in data] == ["cv_0.05"]
