"""What is sent of a million marks, of many entries, and of hundreds of targets."""

from __future__ import annotations

import gzip
from typing import Any

import numpy as np
import pytest

from algorithms.recording import ToaMarks
from algorithms.result import Table
from backend.charts.catalogue import charts
from backend.charts.figure import figure_json
from backend.charts.view import ChartOptions, Figure, RecordingView, RunView
from tests import chart_views

# As the page asks, and as the server compresses.
PAGE_POINTS = 1500
GZIP_LEVEL = 5
MOST_BYTES = 400_000
NAMES = ("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receptions")


def recording_of(count: int, targets: int) -> ToaMarks:
    """Targets that circle at their own distances; one reception in five is missing."""
    k = np.arange(count)
    time_s, target = k * (21_600 / count), k % targets
    angle, distance = 2 * np.pi * target / targets + time_s / 3000, 20e3 + 60e3 * (target % 37) / 37
    place = [distance * np.cos(angle), distance * np.sin(angle), 6000 + 500 * np.sin(time_s / 400 + target)]
    heard = np.random.default_rng(1).random((count, 4, 1)) < 0.8
    return chart_views.marks(
        count,
        targets=targets,
        truth_m=np.stack(place, axis=1),
        time_s=time_s,
        toa_s=np.where(heard, 1e-4, np.nan),
    )


def run_of(recording: ToaMarks, entries: int) -> RunView:
    """Estimates with errors of 80 m; every tenth mark was not used."""
    rng = np.random.default_rng(2)
    count = len(recording)
    used = rng.random(count) > 0.1
    rejected = np.flatnonzero(~used)
    tables = []
    for _ in range(entries):
        position = recording.truth_m + rng.normal(0, 80, (count, 3))
        states: dict[str, Any] = {f"{axis}_m": position[:, i] for i, axis in enumerate(("east", "north", "up"))}
        states |= {
            "drms_m": 100 + 20 * rng.random(count),
            "nis": rng.chisquare(3, count),
            "used": np.where(used, "west east middle", None).tolist(),
            "status": np.where(used, "updated", "residual_gate").tolist(),
        }
        error = np.hypot(*(position - recording.truth_m)[:, :2].T)
        tables.append(
            {
                "states": chart_views.states(recording, **states),
                "errors": Table({**chart_views.errors(recording).columns, "error_horizontal_m": error}),
                "receivers": chart_views.receivers(),
                "decisions": Table(
                    {"row": recording.row[rejected], "reason": ["its residual is too large"] * rejected.size}
                ),
            }
        )
    return chart_views.run(recording, *tables)


def drawn_points(figure: Figure) -> int:
    return sum(len(trace["x"]) for trace in figure["data"])


@pytest.mark.slow
@pytest.mark.parametrize(("targets", "entries"), [(1, 1), (500, 3)])
def test_a_chart_of_a_million_marks_is_small(targets: int, entries: int) -> None:
    recording = recording_of(1_000_000, targets)
    view = run_of(recording, entries)
    options = ChartOptions(points=PAGE_POINTS, entries=entries)
    figures = {name: charts("run")[name].draw(view, options) for name in NAMES}
    own = RecordingView(recording)
    figures |= {
        f"{name} of the recording": charts("recording")[name].draw(own, ChartOptions(points=PAGE_POINTS))
        for name in ("plan", "measurements", "receptions")
    }
    sent = {name: len(gzip.compress(figure_json(figure), GZIP_LEVEL)) for name, figure in figures.items()}
    assert {name: size for name, size in sent.items() if size >= MOST_BYTES} == {}
    # The figure says itself how much of it is missing.
    for name in ("plan", "nis", "altitude"):
        decimated = figures[name]["layout"]["meta"]["decimated"]
        assert decimated["shown"] < 20_000 < 1_000_000 <= decimated["of"]


def test_marks_are_shared_among_the_entries() -> None:
    recording = recording_of(6_000, 1)
    one = charts("run")["nis"].draw(run_of(recording, 1), ChartOptions(points=200, entries=1))
    three = charts("run")["nis"].draw(run_of(recording, 3), ChartOptions(points=200, entries=3))
    marks = [sum(len(t["x"]) for t in f["data"] if "customdata" in t) for f in (one, three)]
    assert marks[1] <= 1.2 * marks[0] < 1_800


def test_marks_not_used_are_thinned_too_and_counted() -> None:
    figure = charts("run")["plan"].draw(run_of(recording_of(20_000, 1), 1), ChartOptions(points=100))
    (rejected,) = [t for t in figure["data"] if t["meta"]["role"] == "rejected"]
    assert len(rejected["x"]) <= 125
    assert figure["layout"]["meta"]["decimated"]["of"] > 21_000


@pytest.mark.parametrize("name", NAMES)
def test_five_hundred_targets_stay_few_points(name: str) -> None:
    recording = recording_of(5_000, 500)
    figure = charts("run")[name].draw(run_of(recording, 2), ChartOptions(points=PAGE_POINTS, entries=2))
    assert figure["data"]
    # Each target keeps at least three points of its path, its track and each of its bands.
    assert drawn_points(figure) < 30_000
    assert len(figure["data"]) < 20
