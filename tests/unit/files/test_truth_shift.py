from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration.scenario import CircuitParameters, IncompleteParameters, simulate
from algorithms.recording import PolarPlots
from algorithms.site import Site
from backend.files.truth_shift import Paths, estimate_time_shift
from backend.files.truth_tracks import TruthTrack


def paths(recording, late_s=0.0, *, track_of=True):
    """The recording's own truth with a clock that is slow by `late_s`."""
    unknown = np.full((len(recording), 3), np.nan)
    track = TruthTrack.of(recording.time_s - late_s, recording.truth_m, unknown, np.arange(len(recording)))
    return Paths([track], np.zeros(len(recording), np.int64) if track_of else None)


@pytest.fixture(scope="module")
def circuit():
    return simulate(CircuitParameters(), (0,), 1)


@pytest.mark.parametrize("late_s", [0.05, -0.4, 3.0, -18.0, 25.3])
def test_a_known_shift_of_marks_is_found(circuit, late_s):
    found = estimate_time_shift(circuit, paths(circuit, late_s))
    assert found.is_significant
    assert found.standard_error_s < 0.005
    assert abs(found.shift_s - late_s) < 4 * found.standard_error_s


@pytest.mark.parametrize("parameters", [CircuitParameters, IncompleteParameters])
def test_no_shift_is_found_where_there_is_none_and_the_error_is_honest(parameters):
    found = []
    for seed in range(12):
        recording = simulate(parameters(), (0,), seed)
        found.append(estimate_time_shift(recording, paths(recording)))
    assert not any(f.is_significant for f in found)
    scaled = np.array([f.shift_s / f.standard_error_s for f in found])
    assert 0.4 < np.sqrt(np.mean(scaled**2)) < 1.8


def test_misplaced_stations_and_wrong_receptions_are_not_taken_for_a_shift(circuit):
    rng = np.random.default_rng(5)
    toa = circuit.toa_s.copy()
    toa[:, 1] += 300e-9
    late = rng.random(toa.shape) < 0.03
    toa[late] += rng.uniform(1e-6, 20e-6, int(late.sum()))
    spoilt = replace(circuit, toa_s=toa)
    assert not estimate_time_shift(spoilt, paths(spoilt)).is_significant
    found = estimate_time_shift(spoilt, paths(spoilt, 0.5))
    assert found.shift_s == pytest.approx(0.5, abs=4 * found.standard_error_s)


def test_nothing_is_estimated_without_a_site_or_with_few_marks(circuit):
    bare = replace(circuit, site=None)
    assert estimate_time_shift(bare, paths(bare)) is None
    few = circuit.take(np.arange(15))
    assert estimate_time_shift(few, paths(few)) is None


def plots(seed, *, turns=True, kind="slant", clutter=0):
    """A ship that weaves 5 to 15 km away, seen every two seconds with 20 m and 0.2 degrees."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, 600, 2.0)
    north = 8000 + (2000 * np.sin(time / 40) if turns else 0 * time)
    truth = np.stack([10 * time - 3000, north, np.full(len(time), 300.0)], axis=1)
    seen = truth
    if clutter:
        wild = rng.uniform(-15_000, 15_000, (clutter, 3)) * [1, 1, 0] + [0, 0, 300]
        time = np.concatenate([time, rng.choice(time, clutter)])
        seen = np.concatenate([truth, wild])
        order = np.argsort(time, kind="stable")
        time, seen = time[order], seen[order]
    m = len(time)
    flat = np.hypot(seen[:, 0], seen[:, 1])
    distance = np.hypot(flat, seen[:, 2]) if kind == "slant" else flat
    absent = np.full((m, 1), np.nan)
    recording = PolarPlots(
        time_s=time, row=np.arange(1, m + 1), target=np.zeros(m, np.int64),
        site=Site.model_validate({"radars": [{"name": "R", "east_m": 0, "north_m": 0, "range_kind": kind}]}),
        range_m=(distance + 20 * rng.standard_normal(m))[:, None],
        azimuth_rad=(np.arctan2(seen[:, 0], seen[:, 1]) + np.radians(0.2) * rng.standard_normal(m))[:, None],
        elevation_rad=absent, altitude_m=absent, east_m=absent, north_m=absent,
        radar=np.zeros(m, np.int64), radar_east_m=absent[:, 0], radar_north_m=absent[:, 0],
        scan=np.full(m, -1), address=np.full(m, -1), callsign=np.full(m, -1), radars=("R",),
    )  # fmt: skip
    return recording, truth


@pytest.mark.parametrize("kind", ["slant", "ground"])
@pytest.mark.parametrize("late_s", [0.0, 0.5, -7.0])
def test_a_known_shift_of_plots_is_found(kind, late_s):
    recording, truth = plots(1, kind=kind)
    track = TruthTrack.of(recording.time_s - late_s, truth, np.full(truth.shape, np.nan), recording.row)
    found = estimate_time_shift(recording, Paths([track], np.zeros(len(recording), np.int64)))
    assert found.is_significant == bool(late_s)
    assert abs(found.shift_s - late_s) < 4 * found.standard_error_s


def test_plots_among_clutter_are_compared_with_the_nearest_truth():
    recording, truth = plots(2, clutter=900)
    time = np.arange(0, 600, 2.0)
    track = TruthTrack.of(time - 1.5, truth, np.full(truth.shape, np.nan), np.arange(len(time)))
    other = TruthTrack.of(
        time - 1.5, truth[::-1] + np.array([9e3, 9e3, 0]), np.full(truth.shape, np.nan), np.arange(len(time))
    )
    found = estimate_time_shift(recording, Paths([track, other], None))
    assert found.shift_s == pytest.approx(1.5, abs=4 * found.standard_error_s)
    assert found.is_significant


def test_a_straight_path_cannot_tell_a_shift_from_an_offset():
    recording, truth = plots(3, turns=False)
    track = TruthTrack.of(recording.time_s - 2, truth, np.full(truth.shape, np.nan), recording.row)
    assert estimate_time_shift(recording, Paths([track], np.zeros(len(recording), np.int64))) is None


def test_the_reader_reports_the_shift_and_applies_it_only_by_option(read, warning):
    time = np.arange(0, 300, 1.0)
    east, north = 5000 * np.sin(time / 60), 9000 + 3000 * np.cos(time / 35)
    rows = "".join(
        f"{t},{float(np.hypot(e, n))},{float(np.degrees(np.arctan2(e, n))) % 360}\n"
        for t, e, n in zip(time, east, north, strict=True)
    )
    radars = '{"radars": [{"name": "R", "east_m": 0, "north_m": 0, "range_kind": "ground"}]}'
    truth = "time_s,true_east_m,true_north_m\n" + "".join(
        f"{t - 0.7},{e},{n}\n" for t, e, n in zip(time, east, north, strict=True)
    )
    text = "time_s,range_m,azimuth_deg\n" + rows
    late, report = read(text, site=radars, truth=truth)
    assert "truth_shift_s = 0.700" in warning(report, "truth_time_shift").detail
    assert abs(late.truth_m[50, 0] - east[50]) > 30
    right, report = read(text, site=radars, truth=truth, truth_shift_s=0.7)
    assert "truth_time_shift" not in [w.code for w in report.warnings]
    np.testing.assert_allclose(right.truth_m[:, 0], east, atol=1e-6)
