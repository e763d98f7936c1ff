"""Names of legs over a chart of trials do not lie over each other, and lines do not cross silences."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from algorithms.result import Table
from backend.charts.trial_curves import LETTER_PX, USUAL_PX, leg_shapes, line, series_of
from backend.charts.view import ChartOptions, Entry
from tests import chart_views


def test_names_that_are_wider_than_their_legs_stand_in_rows() -> None:
    legs = [(f"crossing {i}", 1000.0 * i, 1000.0 * i + 10) for i in range(30)] + [("whole", 0.0, 29_010.0)]
    names = leg_shapes(legs)["annotations"]
    per_px = 29_010.0 / USUAL_PX
    rows: dict[int, list[tuple[float, float]]] = {}
    for name in names:
        half = 0.5 * LETTER_PX * len(name["text"]) * per_px
        rows.setdefault(name["yshift"], []).append((name["x"] - half, name["x"] + half))
    assert 10 < len(names) < 31, "as many as three rows hold"
    for spans in rows.values():
        spans.sort()
        assert all(after[0] > before[1] for before, after in pairwise(spans))


def test_names_with_room_stand_in_one_row() -> None:
    names = leg_shapes([("inbound", 0.0, 100.0), ("weave", 100.0, 200.0), ("outbound", 200.0, 300.0)])["annotations"]
    assert [(one["text"], one["yshift"]) for one in names] == [("inbound", 0), ("weave", 0), ("outbound", 0)]
    assert leg_shapes([]) == {"shapes": [], "annotations": []}


def test_a_line_ends_at_a_silence() -> None:
    time = np.append(np.arange(30.0), 500.0 + np.arange(30.0))
    table = Table({"time_s": time, "trials": np.full(60, 5.0), "rms_m": np.ones(60), "target": [None] * 60})
    view = chart_views.run(chart_views.marks())
    entry = Entry("a", 0, "rdf", lambda _: table, dict)
    (series,) = series_of(type(view)(view.recording, (entry,)))
    drawn = line(series, "a", series.numbers("rms_m"), ChartOptions(), [], "%{y}")
    assert np.isnan(drawn["x"]).tolist() == [False] * 30 + [True] + [False] * 30
