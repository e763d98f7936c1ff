"""Long recordings are cut into passes; sites with two transmitters; channels that miss."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import legs_of, simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.sensors.doppler import doppler_hz

LINES, ML = "forward_scatter_lines", "forward_scatter_ml"


def made(**scenario: Any) -> DopplerPairs:
    return simulate(PassParameters(**scenario), (0,), 9)


def run(name: str, recording: DopplerPairs, **parameters: Any) -> Result:
    algorithm = algorithms_by_name()[name]
    return algorithm.run(recording, algorithm.parameters(**parameters), LocalContext())


@pytest.mark.parametrize("scenario", [{}, {"missing_share": 0.3}, {"blind_zone_hz": 10.0}, {"false_share": 0.1}])
@pytest.mark.parametrize("interval", [31.0, 75.0])
def test_targets_one_after_another_are_passes_of_their_own(scenario: dict[str, Any], interval: float) -> None:
    """Without a silence between them (31 s) the jump of the Dopplers tells."""
    recording = made(
        targets=4, target_interval_s=interval, distance_step_m=5_000.0, crossing_distance_m=12_000.0, **scenario
    )
    found = run(ML, recording, robust="consensus")
    track = found.arrays["track"][:, 0]
    # A first Doppler that is missing or false belongs to nobody's jump.
    assert track[[3, 34, 65, 96]].tolist() == [1, 2, 3, 4]
    assert track[[30, 61, 92, 123]].tolist() == [1, 2, 3, 4]
    ends = found.arrays["theta"][[30, 61, 92, 123], 1, 0]
    assert ends == pytest.approx([12_000, 17_000, 22_000, 27_000], abs=2500)
    assert found.arrays["theta"][[30, 61, 92, 123], 0, 0] == pytest.approx(15 + interval * np.arange(4), abs=0.2)


@pytest.mark.parametrize("period", [0.02, 0.005])
def test_a_pass_ends_with_its_last_row_however_many_there_are(period: float) -> None:
    """Medians across a cut differ most by chance a row beside it; the signs say where it is."""
    rows = round(30 / period) + 1
    for interval in (30 + period, 100.0):
        recording = made(targets=5, target_interval_s=interval, period_s=period)
        track = run(LINES, recording).arrays["track"][:, 0]
        assert track.tolist() == np.repeat(np.arange(1, 6), rows).tolist()


@pytest.mark.parametrize("scenario", [{}, {"missing_share": 0.1}, {"course_deg": 60.0}, {"course_deg": -110.0}])
def test_magnitudes_are_cut_where_they_stop_rising(scenario: dict[str, Any]) -> None:
    """Within a pass they fall to zero and rise; their jump up across zero cannot be seen."""
    recording = made(targets=4, target_interval_s=40.0, distance_step_m=5_000.0, unsigned=True, **scenario)
    found = run(ML, recording, unsigned=True, robust="consensus")
    count = len(recording) // 4
    track = found.arrays["track"][:, 0]
    assert [np.bincount(part).argmax() for part in track.reshape(4, count)] == [1, 2, 3, 4]
    assert track.max() == 4
    ends = found.arrays["theta"][count - 1 :: count, 1, 0]
    assert ends == pytest.approx(15_000 + 5_000 * np.arange(4), abs=2000)


def table(name: str, recording: DopplerPairs, **parameters: Any) -> dict[str, Any]:
    return dict(algorithms_by_name()[name].tabulate(recording, run(name, recording, **parameters))["tracks"].columns)


@pytest.mark.parametrize("name", [LINES, ML, "forward_scatter_angle", "forward_scatter_kalman"])
def test_a_pass_is_a_row_with_its_errors_and_without_doubts(name: str) -> None:
    recording = made(targets=3, target_interval_s=60.0, distance_step_m=7_000.0)
    found = table(name, recording)
    last = run(name, recording).arrays
    ends = [30, 61, 92]
    assert found["distance_m"] == pytest.approx(last["theta"][ends, 1, 0])
    assert found["sigma_distance_m"] == pytest.approx(np.sqrt(last["theta_covariance"][ends, 1, 1, 0]))
    assert found["sigma_crossing_s"] == pytest.approx(np.sqrt(last["theta_covariance"][ends, 0, 0, 0]))
    assert found["course_deg"] == pytest.approx(90, abs=20)
    assert found["used_share"].tolist() == [1.0] * 3
    assert found["doubts"] == [None] * 3


def test_what_is_doubtful_stands_beside_the_pass_that_it_is_about() -> None:
    """The second of three passes is nothing but false Dopplers: robust methods agree with few of them."""
    recording = made(targets=3, target_interval_s=100.0, distance_step_m=7_000.0)
    f = recording.doppler_hz.copy()
    f[31:62, :, 0] = np.random.default_rng(3).uniform(-100, 100, (31, 2))
    noisy = replace(recording, doppler_hz=f)
    found = table(ML, noisy, robust="consensus", gap_s=50.0)
    begin, doubts = found["start_s"], found["doubts"]
    good = (begin == 0) | (begin == 200)
    assert good.sum() == 2
    assert [word for word, ok in zip(doubts, good, strict=True) if ok] == [None, None]
    assert all("few_agree" in (word or "") for word, ok in zip(doubts, good, strict=True) if not ok)
    assert (found["used_share"][good] > 0.95).all()
    assert (found["used_share"][~good] < 0.5).all()
    # The same, plainly: residuals are too large there.
    plain = table(ML, noisy, gap_s=50.0)
    between = [word for word, t in zip(plain["doubts"], plain["start_s"], strict=True) if 100 <= t < 200]
    assert between
    assert all("chi2_large" in (word or "") for word in between)
    one = made()
    upwards = replace(one, doppler_hz=-one.doppler_hz)
    assert list(table(ML, upwards, passes="one")["doubts"]) == ["sign_reversed"]


def test_magnitudes_are_doubted_like_their_signed_values() -> None:
    recording = made(crossing_distance_m=5_000.0)
    unsigned = replace(recording, doppler_hz=np.abs(recording.doppler_hz))
    assert table(ML, unsigned, unsigned=True)["doubts"] == table(ML, recording)["doubts"] == ["far_from_base_line"]


def test_targets_with_names_are_cut_each_by_itself() -> None:
    """Two targets whose rows alternate."""
    one = made(targets=2, target_interval_s=60.0)
    order = np.argsort(np.r_[one.time_s, one.time_s + 0.5], kind="stable")
    both = replace(
        one.take(np.r_[np.arange(len(one)), np.arange(len(one))][order]),
        time_s=np.r_[one.time_s, one.time_s + 0.5][order],
        row=np.arange(1, 2 * len(one) + 1),
        target=np.repeat([0, 1], len(one))[order],
        targets=("A", "B"),
    )
    found = run(ML, both).arrays
    alone = run(ML, one).arrays
    assert found["track"][both.target == 0, 0].tolist() == alone["track"][:, 0].tolist()
    assert found["track"][both.target == 1, 0].tolist() == (2 + alone["track"][:, 0]).tolist()
    assert found["theta"][both.target == 0].tobytes() == alone["theta"].tobytes()


def test_a_pass_alone_and_among_others_is_the_same() -> None:
    together = run(LINES, made(targets=2, target_interval_s=60.0))
    alone = run(LINES, made(targets=2, target_interval_s=60.0).take(np.arange(31)))
    assert together.arrays["theta"][:31].tobytes() == alone.arrays["theta"].tobytes()


def test_false_values_do_not_cut_a_pass() -> None:
    tracks = [
        run(LINES, simulate(PassParameters(false_share=0.2), (i,), 2)).arrays["track"][:, 0].max() for i in range(60)
    ]
    assert np.mean(np.array(tracks) == 1) > 0.95


def test_a_long_pass_is_fitted_at_a_thousand_rows() -> None:
    found = run(ML, made(period_s=0.015))
    assert len(found.arrays["row"]) == 2001
    assert {n.code for n in found.notes} >= {"fits_thinned"}
    status = found.arrays["status"][:, 0]
    assert (status[1000:] >= 10).all()
    assert found.arrays["theta"][-1, 1, 0] == pytest.approx(15_000, abs=150)


def test_two_transmitters_and_one_receiver_are_the_mirror_image() -> None:
    mirrored = run(LINES, made(one_receiver=True, transmitter_spacing_m=300.0, crossing_distance_m=25_000.0))
    assert mirrored.arrays["theta"][16, 1, 0] == pytest.approx(25_000, abs=2500)
    assert mirrored.arrays["theta"][16, 2, 0] == pytest.approx(200, abs=30)
    found = run(ML, made(one_receiver=True, transmitter_spacing_m=300.0, crossing_distance_m=25_000.0))
    assert found.arrays["theta"][-1, 1, 0] == pytest.approx(25_000, abs=1000)


def test_four_dopplers() -> None:
    recording = made(transmitter_spacing_m=300.0)
    assert recording.channels == ("11", "12", "21", "22")
    for name, near in ((LINES, 1500), (ML, 600)):
        found = run(name, recording)
        assert found.arrays["theta"][-1, 1, 0] == pytest.approx(15_000, abs=near), name
    assert found.arrays["dof"][-1, 0] == 4 * 31 - 4


def test_measured_rates_take_the_place_of_slopes() -> None:
    """Or are weighted with them, where their error is told."""
    recording = made(sigma_doppler_rate_hz_s=0.01)
    found = run(LINES, recording, formula=19)
    gamma = recording.doppler_rate_hz_s[6:16, :, 0].mean()
    omega = found.arrays["omega_rad_s"][15, 0]
    assert found.arrays["theta"][15, 1, 0] == pytest.approx(4e4 * gamma / (gamma - 4e4 * omega**2), rel=1e-9)
    fitted = found.arrays["line"][15, :, 2, 0].mean()
    one, other = (
        run(LINES, recording, formula=19, sigma_doppler_rate_hz_s=sigma).arrays["theta"][15, 1, 0]
        for sigma in (1e-6, 1e5)
    )
    assert one == pytest.approx(4e4 * gamma / (gamma - 4e4 * omega**2), rel=1e-6)
    assert other == pytest.approx(4e4 * fitted / (fitted - 4e4 * omega**2), rel=1e-6)


def test_legs_are_the_instants_of_the_tables() -> None:
    names = {leg.name for leg in legs_of(PassParameters())}
    assert names == {"t=9", "t=12", "t=16", "t=20", "t=30", "crossing", "end"}
    slanted = legs_of(PassParameters(course_deg=60.0))
    (crossing,) = (leg for leg in slanted if leg.name == "crossing")
    assert crossing.start_s < 19 < crossing.stop_s, "tau = 17.3 s, the first whole second 0.75 s later is 19"


def test_doppler_of_the_simulation_is_that_of_the_specification() -> None:
    recording = simulate(PassParameters(sigma_doppler_hz=1e-9), (0,), 0)
    f = recording.doppler_hz[:, :, 0]
    assert f[0] == pytest.approx([61.1612, 64.9325], abs=1e-4)
    assert f[30] == pytest.approx([-64.9325, -61.1612], abs=1e-4)


def test_irregular_instants_are_irregular_and_the_same_in_all_trials() -> None:
    regular, moved, again, other = (
        simulate(PassParameters(jitter_share=j, timing_seed=t, targets=2), trials, 9)
        for j, t, trials in ((0.0, 0, (0,)), (0.25, 0, (0,)), (0.25, 0, (7, 8)), (0.25, 1, (0,)))
    )
    assert np.diff(regular.time_s[:31]).tolist() == [1.0] * 30
    steps = np.diff(moved.time_s[:31])
    assert (steps > 0.49).all()
    assert steps.std() > 0.1
    assert moved.time_s.tolist() == again.time_s.tolist() != other.time_s.tolist()
    # What is measured then is what the target does then.
    exact = doppler_hz(
        np.stack([np.full(31, 15_000.0), 200 * (moved.time_s[:31] - 15), np.zeros(31)], axis=1),
        np.array([0.0, 200.0, 0.0]),
        np.array([40_000.0, 0.0, 0.0]),
        np.array([0.0, -150.0, 0.0]),
        1.0,
    )
    assert moved.doppler_hz[:31, 0, 0] == pytest.approx(exact, abs=1.2)
    legs = {leg.name: leg for leg in legs_of(PassParameters(jitter_share=0.25))}
    assert {"t=16", "crossing", "end"} <= set(legs)
    for leg in legs.values():
        assert ((moved.time_s[:31] >= leg.start_s) & (moved.time_s[:31] <= leg.stop_s)).sum() == 1, leg


@pytest.mark.parametrize("name", [LINES, ML, "forward_scatter_angle", "forward_scatter_kalman"])
def test_irregular_instants_gaps_and_missing_receivers_cost_little(name: str) -> None:
    recording = simulate(PassParameters(jitter_share=0.25, missing_share=0.2), tuple(range(64)), 9)
    keep = np.r_[0:10, 13:31]
    algorithm = algorithms_by_name()[name]
    found = algorithm.run(recording.take(keep), algorithm.parameters(), LocalContext()).arrays
    assert found["track"].max() == 1
    # Twice what regular and complete Dopplers give at most.
    assert np.sqrt(np.nanmean((found["theta"][-1, 1] - 15_000) ** 2)) < 1100
    # One receiver alone sees its own line of sight crossed: 150 m earlier here.
    crossed = 14.53 if name == "forward_scatter_angle" else 15.0
    assert np.abs(found["theta"][-1, 0] - crossed).max() < 0.15
