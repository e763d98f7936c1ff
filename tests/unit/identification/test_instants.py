"""Radars that turn by themselves see a target at different instants: plots are brought to one, then compared."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from algorithms.errors import AlgorithmError
from algorithms.identification.instants import truth_at
from algorithms.identification.velocities import lines
from algorithms.recording import PolarPlots
from algorithms.result import Result
from algorithms.toolbox.frames.polar_conversion import cartesian_from_polar
from tests.unit.identification.test_bad_input import notes, run, simulated

Floats = NDArray[np.float64]
PERIOD_S = 10.0
PHASE_S = (0.0, 3.7, 7.1)
SPEED_MPS = 250.0


def turning(*, looks: int = 20, radars: int = 2, late_s: float = 0.0, seed: int = 1) -> tuple[PolarPlots, Floats]:
    """Six straight flights seen by radars whose beams pass at times of their own, and the true target of each plot."""
    rng = np.random.default_rng(seed)
    plots = simulated(targets=6, looks=looks, radars=radars)
    assert plots.site is not None
    sites = np.asarray(plots.site.radar_positions())[:, :2]
    start = 106_000.0 + rng.uniform(-15_000, 15_000, (6, 2))
    course = rng.uniform(0, 2 * np.pi, 6)
    velocity = SPEED_MPS * np.stack([np.sin(course), np.cos(course)], axis=1)
    time = PERIOD_S * plots.scan.astype(float)
    for _ in range(4):
        place = start[plots.target] + velocity[plots.target] * time[:, None]
        offset = place - sites[plots.radar]
        azimuth = np.arctan2(*offset.T)
        beam = np.mod(azimuth / (2 * np.pi) * PERIOD_S + np.take(PHASE_S, plots.radar), PERIOD_S)
        time = PERIOD_S * plots.scan + beam
    noise = rng.standard_normal((2, len(plots)))
    told = time - np.where(plots.radar == 1, late_s, 0.0)
    order = np.argsort(told, kind="stable")
    truth = np.hstack([place, np.zeros((len(plots), 1))])
    target = plots.target[order]
    plots = replace(
        plots,
        time_s=told,
        range_m=(np.hypot(*offset.T) + 100 * noise[0])[:, None],
        azimuth_rad=np.mod(azimuth + np.radians(1.0) * noise[1], 2 * np.pi)[:, None],
        truth_m=truth,
        truth_velocity_mps=np.hstack([velocity[plots.target], np.zeros((len(plots), 1))]),
        target=np.zeros(len(plots), np.int64),
        targets=("",),
    ).take(order)
    return replace(plots, row=np.arange(1, 1 + len(plots))), target


@dataclass(frozen=True)
class Judged:
    """Sets of plots that are one target, others, and the mean NEES (dimension 2) of the places of the former."""

    right: int
    wrong: int
    nees: float


def judged(plots: PolarPlots, target: Floats, result: Result) -> Judged:
    group = result.arrays["group"][:, 0]
    first = np.flatnonzero(group == plots.row)
    one = np.array([np.unique(target[group == number]).size == 1 for number in group[first]])
    error = (result.arrays["fused_m"][first, :, 0] - truth_at(plots, result.arrays["instant_s"])[first])[one]
    xx, yy, xy = result.arrays["fused_covariance_m2"][first, :, 0][one].T
    nees = (yy * error[:, 0] ** 2 + xx * error[:, 1] ** 2 - 2 * xy * error[:, 0] * error[:, 1]) / (xx * yy - xy * xy)
    return Judged(int(one.sum()), int((~one).sum()), float(nees.mean()))


@pytest.mark.parametrize(("algorithm", "conversion"), [
    ("assignment", "mucm"), ("assignment", "polar"), ("pairwise_test", "lin"), ("multi_radar_assignment", "mucm"),
])  # fmt: skip
def test_plots_go_on_to_the_middle_of_their_look(algorithm: str, conversion: str) -> None:
    plots, target = turning()
    result = run(plots, algorithm, conversion=conversion)
    ours = judged(plots, target, result)
    still = judged(plots, target, run(plots, algorithm, conversion=conversion, extrapolate=False))
    assert ours.wrong == 0
    assert ours.right >= still.right
    # Two is the dimension; plots that stay where they are miss by half a kilometre.
    assert 1.2 < ours.nees < 3.2
    assert still.nees > 8
    (note,) = (n for n in result.notes if n.code == "moved_to_one_instant")
    assert note.count is not None
    assert 0.9 * len(plots) < note.count <= len(plots)
    assert "registration_alarm" not in notes(result)


def test_a_plot_by_itself_stays_where_it_was_measured() -> None:
    plots, _ = turning()
    moved, still = (run(plots, extrapolate=on).arrays["position_m"] for on in (True, False))
    assert moved == pytest.approx(still, abs=1e-6)


def test_three_radars_raise_no_alarm_of_clocks_that_are_right() -> None:
    plots, target = turning(radars=3)
    result = run(plots, "multi_radar_assignment")
    still = run(plots, "multi_radar_assignment", extrapolate=False)
    assert "registration_alarm" not in notes(result)
    ours, theirs = judged(plots, target, result), judged(plots, target, still)
    assert ours.right > theirs.right + 10
    assert ours.nees < theirs.nees / 4


def test_a_clock_that_is_wrong_besides_is_still_measured() -> None:
    plots, _ = turning(late_s=4.0)
    result = run(plots)
    (said,) = (n.detail for n in result.notes if n.code == "registration_alarm")
    assert said.startswith("The times of radar 2 are ")
    row = next(r for r in result.arrays["registration"] if r[0] == 3)
    assert row[3] == pytest.approx(4.0, abs=4 * row[5])


def test_who_has_no_track_stays_and_is_counted() -> None:
    plots, _ = turning(looks=3)
    found = {n.code: n for n in run(plots).notes}
    assert set(found) == {"not_simultaneous"}
    assert found["not_simultaneous"].count == len(plots)
    assert "track takes four looks" in found["not_simultaneous"].detail
    off = {n.code: n for n in run(plots, extrapolate=False).notes}
    assert "Nothing was moved" in off["not_simultaneous"].detail


def test_three_radars_name_what_they_cannot_use() -> None:
    plots, _ = turning(radars=3)
    values = plots.range_m.copy()
    values[4] = -1.0
    result = run(replace(plots, range_m=values), "multi_radar_assignment")
    (note,) = (n for n in result.notes if n.code == "unusable_plots")
    assert note.count == 1


def test_the_misprint_s_ellipse_is_moved_too() -> None:
    plots, _ = turning(looks=5)
    try:
        result = run(plots, conversion="paper_literal")
    except AlgorithmError as error:
        pytest.fail(f"the moved covariance is none: {error}")
    assert np.isfinite(result.arrays["pair_statistic"]).all()
    assert (result.arrays["pair_statistic"] >= 0).all()


def test_the_doubt_about_a_velocity_is_what_draws_say() -> None:
    """Covariances of the velocity, and of it with the plot itself, against four thousand draws of one track."""
    rng = np.random.default_rng(5)
    time = np.array([0.0, 9.0, 21.0, 30.0, 41.0, 50.0])
    true = np.array([90_000.0, 60_000.0]) + time[:, None] * [120.0, -200.0]
    spread = np.array([[9e4, -2e4], [-2e4, 3e4]])
    packed = np.tile([spread[0, 0], spread[1, 1], spread[0, 1]], (time.size, 1))
    noise = rng.multivariate_normal([0.0, 0.0], spread, (4000, time.size))
    rows = np.arange(time.size)
    found = [lines([rows], time, true + e, packed) for e in noise]
    velocity = np.array([f.velocity[0] for f in found]) - [120.0, -200.0]
    known = np.isfinite(velocity[:, 0])
    # The test of the line leaves out one in ten thousand.
    assert known.mean() > 0.99
    of = velocity[known]
    claimed = found[0]
    assert of.T @ of / len(of) == pytest.approx(claimed.covariance[0], rel=0.08, abs=0.03 * claimed.covariance[0, 0, 0])
    for k in (0, 3, 5):
        cross = noise[known, k].T @ of / len(of)
        assert cross == pytest.approx(claimed.with_place[k], abs=0.05 * spread[0, 0] / 20)


def test_conversions_are_not_touched_where_all_is_simultaneous() -> None:
    plots = simulated(targets=4, looks=5)
    on, off = (run(plots, extrapolate=e).arrays for e in (True, False))
    assert all(np.array_equal(on[name], off[name], equal_nan=True) for name in on)
    z, _ = cartesian_from_polar(
        plots.range_m[0, 0], np.pi / 2 - plots.azimuth_rad[0, 0], 100.0, np.radians(1.0), "mucm"
    )
    assert on["position_m"][0, :, 0] == pytest.approx(z, abs=1e-6)
