"""What a user may get wrong (specification 10): refused with a remedy, or recognised and named."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from algorithms.errors import AlgorithmError, InputError
from algorithms.identification.outputs import DECISIONS, ONE_LINE, REASONS, SAME_TIME, SHORT_TRACK, TIED
from algorithms.recording import PolarPlots
from algorithms.registry import algorithms_by_name, scenarios_by_name
from algorithms.result import Result
from algorithms.site import Site
from algorithms.spec import LocalContext


def simulated(preset: str = "two_radars_cluster", **parameters: Any) -> PolarPlots:
    scenario = scenarios_by_name()[preset]
    recording = scenario.simulate(scenario.parameters(**parameters), (0,), 3)
    assert isinstance(recording, PolarPlots)
    return recording


def run(recording: PolarPlots, algorithm: str = "assignment", **parameters: Any) -> Result:
    found = algorithms_by_name()[algorithm]
    return found.run(recording, found.parameters(**parameters), LocalContext())


def notes(result: Result) -> set[str]:
    return {note.code for note in result.notes}


CLUSTER = {"targets": 6, "looks": 20}


def with_radar_2(recording: PolarPlots, **changes: Any) -> PolarPlots:
    assert recording.site is not None
    first, second = recording.site.radars
    return replace(recording, site=Site(radars=(first, second.model_copy(update=changes))))


def test_sound_plots_raise_no_suspicion() -> None:
    assert notes(run(simulated(**CLUSTER))) == set()


def test_azimuths_of_one_radar_counted_from_east() -> None:
    plots = simulated(**CLUSTER)
    second = (plots.radar == 1)[:, None]
    mixed = replace(plots, azimuth_rad=np.where(second, np.mod(np.pi / 2 - plots.azimuth_rad, 2 * np.pi),
                                                plots.azimuth_rad))  # fmt: skip
    assert "suspect_azimuth_convention" in notes(run(mixed))
    assert "registration_alarm" not in notes(run(mixed))


def test_radians_read_as_degrees() -> None:
    plots = simulated(**CLUSTER)
    second = (plots.radar == 1)[:, None]
    wrong = replace(plots, azimuth_rad=np.where(second, np.radians(plots.azimuth_rad), plots.azimuth_rad))
    assert "suspect_azimuth_unit" in notes(run(wrong))


def test_plots_of_both_counted_from_one_place() -> None:
    plots = simulated(**CLUSTER)
    second = plots.radar == 1
    east = plots.range_m * np.sin(plots.azimuth_rad) + np.where(second, 30_000.0, 0.0)[:, None]
    north = plots.range_m * np.cos(plots.azimuth_rad)
    common = replace(plots, range_m=np.hypot(east, north), azimuth_rad=np.mod(np.arctan2(east, north), 2 * np.pi))
    assert "suspect_translation" in notes(run(common))


def test_looks_of_one_radar_too_late() -> None:
    plots = simulated("two_radars_tracks", scans=30, speed_mps=2500, offset_along_m=20_000)
    second = plots.radar == 1
    late = replace(plots, scan=np.where(second, plots.scan + 1, plots.scan))
    assert "suspect_clock" in notes(run(late, extrapolate=False))
    # Where times are right only the numbers are wrong: plots go on to one instant, and pairs are found all the same.
    result = run(late)
    assert "suspect_clock" not in notes(result)
    assert (result.arrays["decision"] == DECISIONS.index("accepted")).mean() > 0.9
    # A clock that is wrong by a whole look cannot be mended so.
    wrong = replace(late, time_s=np.where(second, plots.time_s + 10.0, plots.time_s))
    assert "suspect_clock" in notes(run(wrong.take(np.argsort(wrong.time_s, kind="stable"))))


@pytest.mark.parametrize("algorithm", ["assignment", "multi_radar_assignment"])
def test_a_displaced_radar_is_an_alarm(algorithm: str) -> None:
    plots = simulated(**CLUSTER, site_error_east_m=600)
    result = run(plots, algorithm)
    (note,) = (n for n in result.notes if n.code == "registration_alarm")
    assert note.detail.startswith("Radar ")
    table = algorithms_by_name()[algorithm].tabulate(plots, result)["registration"]
    east = next(row for row in table.rows() if row[2] == "east")
    assert abs(east[3] - 600) < 4 * east[4]
    assert "registration_alarm" not in notes(run(simulated(**CLUSTER), algorithm))


def test_a_turned_radar_is_an_alarm_with_its_angle() -> None:
    plots = simulated(**CLUSTER | {"looks": 60, "region_side_m": 60_000}, azimuth_bias_deg=0.5)
    result = run(plots)
    assert "registration_alarm" in notes(result)
    rows = algorithms_by_name()["assignment"].tabulate(plots, result)["registration"].rows()
    turned = next(row for row in rows if row[2] == "azimuth" and row[0] == "2")
    assert turned[3] == pytest.approx(0.5, abs=4 * turned[4] + 0.05)


def test_a_wrong_clock_is_an_alarm_of_tracks() -> None:
    plots = simulated("two_radars_tracks", scans=40, speed_mps=300, offset_along_m=4000, time_offset_s=1.0)
    result = run(plots, "track_association", decision="most_likely")
    rows = list(algorithms_by_name()["track_association"].tabulate(plots, result)["registration"].rows())
    late = next(row for row in rows if row[2] == "time")
    assert late[3] == pytest.approx(1.0, abs=4 * late[4])
    assert "registration_alarm" in notes(result)


@pytest.mark.parametrize(
    ("range_m", "word"), [(-1.0, "unusable"), (0.0, "unusable"), (np.inf, "unusable"), (np.nan, "unusable")]
)
def test_a_plot_without_a_range_is_left_out_and_listed(range_m: float, word: str) -> None:
    plots = simulated(**CLUSTER)
    values = plots.range_m.copy()
    values[2] = range_m
    result = run(replace(plots, range_m=values))
    assert DECISIONS[result.arrays["decision"][2, 0]] == word
    assert "unusable_plots" in notes(result)
    table = algorithms_by_name()["assignment"].tabulate(plots, result)["decisions"]
    assert any(row[1] == 3 for row in table.rows())


def test_an_empty_side_leaves_all_alone() -> None:
    plots = simulated(targets=3, looks=2)
    one = plots.take(np.flatnonzero(plots.radar == 0))
    result = run(one)
    assert {DECISIONS[i] for i in np.unique(result.arrays["decision"])} == {"alone"}
    assert result.arrays["alone_probability"] == pytest.approx(1.0)


def test_unequal_counts_assign_the_shorter_side() -> None:
    plots = simulated(targets=5, looks=1)
    part = plots.take(np.flatnonzero((plots.radar == 0) | (plots.target < 3)))
    result = run(part, decision="most_likely")
    words = [DECISIONS[i] for i in result.arrays["decision"][:, 0]]
    assert words.count("accepted") == 6
    assert words.count("alone") == 2


def test_identical_plots_are_a_tie() -> None:
    plots = simulated("two_radars_two_targets")
    same = plots.take(np.array([0, 0, 2, 2]))
    result = run(replace(same, row=np.arange(1, 5)), p_min=0.5)
    assert result.arrays["pair_probability"] == pytest.approx(0.5, abs=1e-9)
    assert {DECISIONS[i] for i in result.arrays["decision"].ravel()} == {"undecided"}
    assert (result.arrays["reason"] == TIED).all()
    assert "exact_ties" in notes(result)


def test_what_is_outside_all_gates_is_no_tie() -> None:
    """Of a look that is split into groups, pairs no gate joins have probability 0, all of them exactly."""
    plots = simulated(targets=20, looks=1, region_side_m=200_000)
    far = plots.azimuth_rad.copy()
    far[plots.radar == 1] += np.radians(40.0)
    result = run(replace(plots, azimuth_rad=np.mod(far, 2 * np.pi)))
    assert "exact_ties" not in notes(result)
    assert not (result.arrays["reason"] == TIED).any()


def test_radars_at_one_place() -> None:
    assert notes(run(simulated(**CLUSTER, base_m=0.0))) <= {"geometry_cannot_separate"}


def test_targets_beside_each_other_on_the_prolonged_base_cannot_be_separated() -> None:
    """Both radars look along one line: the ranges say nothing, and the right pairing is hardly more likely."""
    scenario = {"target_azimuth_deg": 90.0, "offset_along_m": 0.0, "offset_across_m": 600.0}
    plots = simulated("two_radars_two_targets", **scenario)
    result = run(plots)
    assert "geometry_cannot_separate" in notes(result)
    table = algorithms_by_name()["assignment"].tabulate(plots, result)["decisions"]
    assert {row[table.names.index("reason")] for row in table.rows()} == {REASONS[ONE_LINE]}
    beside = run(simulated("two_radars_two_targets", **scenario | {"target_azimuth_deg": 0.0}))
    assert "geometry_cannot_separate" not in notes(beside)
    algorithm = algorithms_by_name()["assignment"]
    preset = scenarios_by_name()["two_radars_two_targets"]
    trials = preset.simulate(preset.parameters(**scenario | {"offset_across_m": 250.0}), tuple(range(2000)), 4)
    assert algorithm.score is not None
    (paired,) = (
        tally for tally in algorithm.score(trials, algorithm.parameters(), LocalContext()).tallies
        if tally.metric == "assignment_correct"
    )  # fmt: skip
    # Specification 10: about 0.53.
    assert paired.numerator.sum() / paired.denominator.sum() == pytest.approx(0.53, abs=0.035)


def test_turns_more_and_less_are_the_same_azimuth() -> None:
    plots = simulated(**CLUSTER)
    turns = np.random.default_rng(1).integers(-3, 4, plots.azimuth_rad.shape)
    for algorithm in ("assignment", "multi_radar_assignment", "track_association"):
        wound = run(replace(plots, azimuth_rad=plots.azimuth_rad + 2 * np.pi * turns), algorithm)
        plain = run(plots, algorithm)
        assert (wound.arrays["decision"] == plain.arrays["decision"]).all()
        assert wound.arrays["fused_m"] == pytest.approx(plain.arrays["fused_m"], abs=1e-5, nan_ok=True)


@pytest.mark.parametrize("algorithm", ["assignment", "pairwise_test", "multi_radar_assignment", "track_association"])
def test_a_recording_of_which_nothing_is_left_is_refused(algorithm: str) -> None:
    plots = simulated(targets=3, looks=2)
    with pytest.raises(InputError, match="No plot can be used: the range is not positive") as caught:
        run(replace(plots, range_m=np.full(plots.range_m.shape, -1.0)), algorithm)
    assert caught.value.code == "no_usable_plots"
    assert caught.value.remedy


def test_the_exact_limit_and_what_takes_its_place_are_told() -> None:
    plots = simulated(targets=20, looks=1, region_side_m=200_000)
    (note,) = run(plots).notes
    assert note.code == "groups_summed"
    assert "more than 14 plots" in note.detail
    assert "at most 18" in note.detail
    dense = simulated(targets=24, looks=1, region_side_m=8_000)
    codes = {n.code: n for n in run(dense).notes}
    assert {"groups_summed", "ranked_matchings"} <= set(codes)
    assert "no probability is wrong by more than" in codes["ranked_matchings"].detail
    with pytest.raises(ValueError, match="less than or equal to 18"):
        algorithms_by_name()["assignment"].parameters(exact_plots=19)
    # A lower limit gives the same probabilities, only otherwise summed.
    few = simulated(targets=6, looks=3)
    found = run(few, exact_plots=1)
    assert {n.code for n in found.notes} == {"groups_summed", "ranked_matchings"}
    assert found.arrays["pair_probability"] == pytest.approx(run(few).arrays["pair_probability"], abs=1e-5)


def test_degrees_taken_for_radians_are_refused() -> None:
    with pytest.raises(InputError, match="degrees was taken for radians") as caught:
        run(simulated(**CLUSTER), sigma_azimuth_deg=57.3)
    assert caught.value.pointer == "/sigma_azimuth_deg"
    assert caught.value.remedy


def test_unusual_accuracies_are_told() -> None:
    assert "wide_azimuth" in notes(run(simulated(**CLUSTER), sigma_azimuth_deg=20.0))
    assert "range_error_unit" in notes(run(simulated(**CLUSTER), sigma_range_m=0.5))


def test_a_covariance_without_inverse_is_refused() -> None:
    plots = simulated(**CLUSTER, base_m=0.0)
    one_line = replace(plots, azimuth_rad=np.ones(plots.azimuth_rad.shape))
    with pytest.raises(AlgorithmError, match="same line"):
        run(one_line, sigma_azimuth_deg=1e-12, sigma_range_m=100_000.0)


def test_one_radar_no_site_wrong_names_no_accuracy() -> None:
    plots = simulated(targets=3, looks=2)
    alone = replace(plots, radars=("1",), radar=np.zeros(len(plots), np.int64))
    for broken, code in (
        (alone, "one_radar"),
        (replace(plots, site=None), "site_missing"),
        (replace(plots, radars=("1", "x")), "site_mismatch"),
        (with_radar_2(plots, sigma_range_m=None), "accuracy_missing"),
        (replace(plots, radar_east_m=np.zeros(len(plots))), "moving_radar"),
    ):
        with pytest.raises(InputError) as caught:
            run(broken)
        assert caught.value.code == code
        assert caught.value.remedy


def test_looks_by_scan_by_pauses_by_length_or_not_at_all() -> None:
    plots = simulated(targets=3, looks=4)
    unnumbered = replace(plots, scan=np.full(len(plots), -1))
    assert set(run(unnumbered).arrays["frame"]) == {0, 1, 2, 3}
    turning = replace(unnumbered, time_s=np.linspace(0, 20, len(plots)))
    with pytest.raises(InputError) as caught:
        run(turning)
    assert caught.value.pointer == "/frame_s"
    assert set(run(turning, frame_s=10.0).arrays["frame"]) == {0, 1, 2}
    assert "not_simultaneous" in notes(run(turning, frame_s=10.0))


def test_a_target_at_a_radar() -> None:
    plots = simulated(targets=2, looks=3)
    near = plots.range_m.copy()
    near[0] = 100.0
    assert "target_at_radar" in notes(run(replace(plots, range_m=near)))


def test_slant_ranges_with_an_altitude_become_ground_ranges() -> None:
    plots = with_radar_2(simulated(targets=2, looks=1, height_m=10_000), range_kind="slant")
    assert "height_unknown" in notes(run(plots))
    known = replace(plots, altitude_m=np.full(plots.range_m.shape, 10_000.0))
    assert "height_unknown" not in notes(run(known))
    shorter = run(known).arrays["position_m"][2:] - run(plots).arrays["position_m"][2:]
    assert (np.hypot(shorter[:, 0], shorter[:, 1]) > 200).all()


def test_azimuths_across_the_seam_and_three_radars() -> None:
    west = simulated("two_radars_two_targets", target_azimuth_deg=270.0, offset_along_m=8000.0)
    assert {DECISIONS[i] for i in run(west, conversion="polar").arrays["decision"].ravel()} == {"accepted"}
    three = simulated(targets=2, looks=1, radars=3)
    result = run(three)
    assert "radars_left_out" in notes(result)
    assert "not_compared" in {DECISIONS[i] for i in result.arrays["decision"].ravel()}
    other = run(three, first_radar="3", second_radar="1")
    assert {int(r) for r in other.arrays["radar"][other.arrays["decision"][:, 0] != 6]} == {0, 2}


def test_plots_without_names_are_joined_to_tracks() -> None:
    plots = simulated("two_radars_tracks", scans=12, offset_along_m=8000.0)
    nameless = replace(plots, target=np.zeros(len(plots), np.int64), targets=("",))
    result = run(nameless, "track_association", decision="most_likely", max_speed_mps=300.0)
    assert len(set(result.arrays["track"])) == 4
    named = run(plots, "track_association", decision="most_likely")
    accepted = DECISIONS.index("accepted")
    assert (result.arrays["decision"] == accepted).mean() == (named.arrays["decision"] == accepted).mean() == 1.0


def test_a_track_with_one_plot_or_two_at_a_time_is_named_and_the_others_go_on() -> None:
    plots = simulated("two_radars_tracks", scans=12, offset_along_m=8000.0)
    first = (plots.radar == 0) & (plots.target == 0)
    single = plots.take(np.flatnonzero(~first | (plots.scan == 5)))
    result = run(single, "track_association")
    reason, decision = (result.arrays[name][:, 0] for name in ("reason", "decision"))
    assert (reason[(single.radar == 0) & (single.target == 0)] == SHORT_TRACK).all()
    assert "short_tracks" in notes(result)
    other = single.target == 1
    assert (decision[other] == DECISIONS.index("accepted")).all()
    twice = np.sort(np.append(np.arange(len(plots)), np.flatnonzero(first)[4]))
    doubled = plots.take(twice)
    doubled = replace(doubled, row=np.arange(1, 1 + len(doubled)))
    result = run(doubled, "track_association")
    extra = np.flatnonzero(np.diff(twice) == 0) + 1
    assert np.flatnonzero(result.arrays["reason"][:, 0] == SAME_TIME).tolist() == extra.tolist()
    assert "repeated_times" in notes(result)
    rest = np.delete(np.arange(len(doubled)), extra)
    sound = run(plots, "track_association")
    assert (result.arrays["statistic"][rest] == sound.arrays["statistic"]).sum() >= 2


def test_a_missing_scan_is_bridged() -> None:
    plots = simulated("two_radars_tracks", scans=12, offset_along_m=8000.0)
    gap = plots.take(np.flatnonzero((plots.scan != 6) | (plots.radar == 1)))
    result = run(gap, "track_association", decision="most_likely")
    assert (result.arrays["decision"] == DECISIONS.index("accepted")).all()
    last = gap.scan == 11
    whole = run(plots, "track_association", decision="most_likely").arrays["fused_covariance_m2"][
        plots.scan == 11, 0, 0
    ]
    # One plot fewer leaves a little more doubt.
    ours = result.arrays["fused_covariance_m2"][last, 0, 0]
    assert (ours[np.isfinite(ours)] > whole[np.isfinite(whole)]).all()


@pytest.mark.parametrize("algorithm", ["pairwise_test", "assignment", "multi_radar_assignment", "track_association"])
def test_every_algorithm_names_a_known_mistake(algorithm: str) -> None:
    if algorithm == "track_association":
        plots = simulated("two_radars_tracks", scans=20, offset_along_m=8000.0)
    else:
        plots = simulated(**CLUSTER)
    second = (plots.radar == 1)[:, None]
    mixed = replace(
        plots, azimuth_rad=np.where(second, np.mod(np.pi / 2 - plots.azimuth_rad, 2 * np.pi), plots.azimuth_rad)
    )
    found = run(mixed, algorithm)
    assert "suspect_azimuth_convention" in notes(found)
    (said,) = (n.detail for n in found.notes if n.code == "suspect_azimuth_convention")
    assert "radar 2" in said
