"""Edge cases of the forward-scatter specification (section 10), row by row."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from algorithms.errors import FrameError, ParameterError, RecordingError
from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.result import Result
from algorithms.site import Site, Terminal
from algorithms.spec import LocalContext

LINES, ML, ANGLE, KALMAN = (f"forward_scatter_{n}" for n in ("lines", "ml", "angle", "kalman"))


def made(**scenario: Any) -> DopplerPairs:
    return simulate(PassParameters(**scenario), (0,), 5)


def run(name: str, recording: DopplerPairs, **parameters: Any) -> Result:
    algorithm = algorithms_by_name()[name]
    return algorithm.run(recording, algorithm.parameters(**parameters), LocalContext())


def notes(result: Result) -> set[str]:
    return {note.code for note in result.notes}


def states(result: Result) -> list[str]:
    return [outputs.STATUS[i] for i in result.arrays["status"][:, 0]]


def with_dopplers(recording: DopplerPairs, doppler: np.ndarray) -> DopplerPairs:
    return replace(recording, doppler_hz=np.ascontiguousarray(doppler))


def with_site(recording: DopplerPairs, **changed: Any) -> DopplerPairs:
    assert recording.site is not None
    return replace(recording, site=recording.site.model_copy(update=changed))


@pytest.mark.parametrize(
    ("name", "bad"),
    [
        (LINES, {"wavelength_m": 0}),
        (LINES, {"sigma_doppler_hz": 0}),
        (ML, {"sigma_doppler_hz": float("nan")}),
        (ML, {"wavelength_m": float("inf")}),
        (LINES, {"window": 1}),
        (ML, {"unknowns": 6}),
    ],
)
def test_numbers_that_cannot_be_name_their_field(name: str, bad: dict[str, Any]) -> None:
    with pytest.raises(ValidationError) as caught:
        algorithms_by_name()[name].parameters(**bad)
    assert caught.value.errors()[0]["loc"][0] == next(iter(bad))


@pytest.mark.parametrize(
    ("bad", "pointer"),
    [
        ({"base_m": 1000.0}, "/crossing_distance_m"),
        ({"course_deg": 0.5}, "/course_deg"),
        ({"acceleration_mps2": 100.0}, "/acceleration_mps2"),
        ({"targets": 3, "target_interval_s": 10.0}, "/target_interval_s"),
        ({"period_s": 0.001, "targets": 50, "observed_s": 1e4, "target_interval_s": 1e5}, "/period_s"),
    ],
)
def test_a_scenario_that_cannot_be_names_its_field(bad: dict[str, Any], pointer: str) -> None:
    with pytest.raises(ParameterError) as caught:
        made(**bad)
    assert caught.value.pointer == pointer
    assert caught.value.remedy


def test_sites_that_cannot_serve() -> None:
    recording = made()
    with pytest.raises(RecordingError) as none:
        run(LINES, replace(recording, site=None))
    assert none.value.code == "site_missing"
    with pytest.raises(RecordingError) as blind:
        run(LINES, with_site(recording, wavelength_m=None))
    assert (blind.value.code, blind.value.pointer) == ("wavelength_missing", "/site/wavelength_m")
    assert recording.site is not None
    with pytest.raises(RecordingError) as alone:
        run(LINES, with_site(recording, receivers=recording.site.receivers[:1]))
    assert alone.value.code == "site_mismatch"
    here = (Terminal(name="TX", east_m=0.0, north_m=0.0),)
    with pytest.raises(FrameError) as short:
        run(ML, with_site(recording, transmitters=here))
    assert short.value.code == "no_base_line"


def test_the_closed_form_refuses_a_site_askew_and_the_likelihood_takes_it() -> None:
    """The transmitter may stand one degree beside the bisector of the receivers."""

    def askew(degrees: float) -> DopplerPairs:
        turn = np.radians(degrees)
        places = [(-150 * np.sin(turn) * side, 150 * np.cos(turn) * side) for side in (-1, 1)]
        site = Site(
            transmitters=(Terminal(name="TX", east_m=40_000.0, north_m=0.0),),
            receivers=tuple(Terminal(name=f"RX{i}", east_m=x, north_m=y) for i, (x, y) in enumerate(places)),
            wavelength_m=1.0,
            sigma_doppler_hz=0.2,
        )
        return replace(made(), site=site)

    assert "site_not_symmetrical" in notes(run(LINES, askew(0.5)))
    with pytest.raises(RecordingError) as caught:
        run(LINES, askew(2.0))
    assert caught.value.code == "site_geometry"
    assert "forward_scatter_ml" in caught.value.remedy
    assert states(run(ML, askew(2.0)))[-1] == "fitted"


def test_a_missing_value_is_skipped_and_too_few_give_no_line() -> None:
    recording = made()
    f = recording.doppler_hz.copy()
    f[3:9, 0] = np.nan
    found = run(LINES, with_dopplers(recording, f), window=4)
    assert states(found)[8] == "no_line"
    assert np.isnan(found.arrays["state"][8]).all()
    assert found.arrays["crossing_s"][8, 0, 0] == found.arrays["crossing_s"][7, 0, 0], "the last one is kept"
    robust = run(LINES, recording, robust="consensus", confirm=3)
    assert states(robust)[:4] == ["insufficient_data", "no_line", "no_line", "no_line"]
    whole = run(ML, with_dopplers(recording, f))
    assert states(whole)[-1] == "fitted"
    assert whole.arrays["dof"][-1, 0] == 62 - 6 - 4


def test_one_pair_is_insufficient() -> None:
    for name in (LINES, ML, ANGLE, KALMAN):
        assert states(run(name, made().take(np.arange(1)))) == ["insufficient_data"], name


def test_irregular_times_and_gaps_are_taken_and_doubted() -> None:
    recording = made(period_s=0.25)
    keep = np.r_[0:20, 21:60:3, 90:121]
    found = run(LINES, recording.take(keep), window=10, passes="one")
    assert "window_long" in notes(found)
    assert states(found)[-1] == "crossed"
    assert abs(run(ML, recording.take(keep), passes="one").arrays["theta"][-1, 1, 0] - 15_000) < 1000


def test_contradicting_numbers_have_a_status_and_no_place_and_stay_in_the_diagnostics() -> None:
    """With a large error the first windows have omega D < 0."""
    recording = made(crossing_distance_m=30_000.0, sigma_doppler_hz=1.0)
    found = run(LINES, recording)
    bad = [i for i, s in enumerate(states(found)) if s == "invalid"]
    assert bad
    assert np.isnan(found.arrays["state"][bad]).all()
    assert np.isfinite(found.arrays["omega_rad_s"][bad]).all()
    assert "invalid" in algorithms_by_name()[LINES].tabulate(recording, found)["decisions"].columns["decision"]


def test_rising_dopplers_are_a_reversed_sign() -> None:
    recording = made()
    for name in (LINES, ML):
        found = run(name, with_dopplers(recording, -recording.doppler_hz))
        assert "sign_reversed" in notes(found), name
        assert not np.isin(found.arrays["status"], outputs.ANSWERED).any()


def test_a_track_that_ends_before_the_crossing_is_extrapolated() -> None:
    found = run(LINES, made().take(np.arange(12)))
    assert states(found)[-1] == "extrapolated"
    assert "crossed" not in states(found)
    assert "ends_before_crossing" in notes(found)
    for name in (LINES, ML, ANGLE):
        assert "ends_before_crossing" in notes(run(name, made().take(np.arange(12)))), name
        assert "ends_before_crossing" not in notes(run(name, made())), name
    assert states(run(LINES, made()))[-1] == "crossed"


def test_units_that_cannot_be() -> None:
    """kHz for Hz fits perfectly at half a metre a second."""
    recording = made()
    found = run(ML, with_dopplers(recording, recording.doppler_hz / 1000), sigma_doppler_hz=2e-4)
    assert "speed_unlikely" in notes(found)


def test_a_target_that_goes_far_beside_the_base_line_is_told() -> None:
    assert "far_from_base_line" in notes(run(ML, made(crossing_distance_m=5_000.0)))
    assert "far_from_base_line" not in notes(run(ML, made()))


def test_crossing_times_that_say_nothing_are_told() -> None:
    """Near the transmitter both lines of sight are crossed at once."""
    assert "geometry_weak" in notes(run(LINES, made(crossing_distance_m=39_500.0, sigma_doppler_hz=1.0)))
    assert "geometry_weak" not in notes(run(LINES, made()))


def test_exchanged_receivers_mirror_the_velocity_alone() -> None:
    recording = made()
    right = run(LINES, recording)
    wrong = run(LINES, with_dopplers(recording, recording.doppler_hz[:, ::-1]))
    k = -1
    assert wrong.arrays["theta"][k, 1, 0] == pytest.approx(right.arrays["theta"][k, 1, 0], rel=1e-9)
    assert wrong.arrays["theta"][k, 2, 0] == pytest.approx(-right.arrays["theta"][k, 2, 0], rel=1e-9)


def test_places_decide_which_receiver_is_which() -> None:
    """The same file with its columns and its receivers exchanged gives the same answer."""
    recording = made()
    assert recording.site is not None
    turned = with_site(recording, receivers=recording.site.receivers[::-1])
    turned = with_dopplers(turned, recording.doppler_hz[:, ::-1])
    for name in (LINES, ML):
        one, other = run(name, recording), run(name, turned)
        assert other.arrays["theta"][-1] == pytest.approx(one.arrays["theta"][-1], rel=1e-6), name


def test_a_fit_that_is_too_bad_says_so_and_stays() -> None:
    recording = made(acceleration_mps2=3.0)
    found = run(ML, recording, acceleration_switch=False)
    assert "chi2_large" in notes(found)
    assert states(found)[-1] in ("fitted", "fallback")
    assert "chi2_large" not in notes(run(ML, recording))


def test_one_doppler_alone_needs_an_azimuth() -> None:
    one = made(one_receiver=True)
    for name in (LINES, ML, KALMAN):
        with pytest.raises(RecordingError) as caught:
            run(name, one)
        assert caught.value.code == "one_doppler"
    with pytest.raises(RecordingError) as blind:
        run(ANGLE, made(sigma_azimuth_deg=None))
    assert blind.value.code == "azimuth_missing"


def test_a_receiver_that_never_heard_anything_leaves_no_answer() -> None:
    recording = made()
    f = recording.doppler_hz.copy()
    f[:, 1] = np.nan
    for name, status in ((LINES, "no_line"), (ML, "insufficient_data"), (KALMAN, "insufficient_data")):
        found = run(name, with_dopplers(recording, f))
        assert set(states(found)) <= {status, "insufficient_data"}, name
        assert np.isnan(found.arrays["state"]).all(), name


def test_one_early_false_line_does_not_keep_a_false_crossing() -> None:
    recording = made()
    f = recording.doppler_hz.copy()
    f[5, 0] = -90.0
    plain = run(LINES, with_dopplers(recording, f), window=6)
    assert plain.arrays["crossing_s"][-1, 0, 0] < 10
    robust = run(LINES, with_dopplers(recording, f), window=6, robust="consensus", confirm=3)
    assert robust.arrays["crossing_s"][-1, 0, 0] == pytest.approx(14.53, abs=0.2)
    assert not robust.arrays["used"][5, 0, 0]


def test_magnitudes_are_suspected_and_get_their_signs_back() -> None:
    signed = made()
    magnitudes = with_dopplers(signed, np.abs(signed.doppler_hz))
    assert "doppler_without_sign" in notes(run(ML, magnitudes))
    found = run(ML, magnitudes, unsigned=True)
    assert found.arrays["theta"][-1] == pytest.approx(run(ML, signed).arrays["theta"][-1], rel=1e-9)


def test_noise_about_a_pass_is_told_by_the_lines_too() -> None:
    """They have no chi2: their crossing is that of the noise, and the residuals show it."""
    clean = made()
    f = clean.doppler_hz.copy()
    f[:12] = np.random.default_rng(0).uniform(-100, 100, (12, 2, 1))
    assert "chi2_large" in notes(run(LINES, replace(clean, doppler_hz=f)))
    assert "chi2_large" not in notes(run(LINES, clean))
    assert "chi2_large" not in notes(run(LINES, made(course_deg=60.0)))


@pytest.mark.parametrize(
    ("scenario", "told"),
    [
        ({}, False),
        ({"crossing_distance_m": 8_000.0}, False),
        # The pass ends as it crosses: an acceleration would double the error.
        ({"observed_s": 16.0}, True),
        ({"crossing_distance_m": 30_000.0, "acceleration_mps2": 1.0, "sigma_doppler_hz": 1.0}, True),
    ],
)
def test_an_acceleration_that_cannot_be_seen_is_told(scenario: dict[str, Any], told: bool) -> None:
    algorithm = algorithms_by_name()["forward_scatter_ml"]
    recording = simulate(PassParameters(**scenario), (3,), 5)
    for parameters, expected in (({}, told), ({"unknowns": 5}, False)):
        found = algorithm.run(recording, algorithm.parameters(**parameters), LocalContext())
        assert ("acceleration_open" in {n.code for n in found.notes}) == expected


def test_receivers_at_one_place_are_refused_by_the_fit_too() -> None:
    """Else it fits the middle of the base line, whatever the Dopplers are."""
    algorithm = algorithms_by_name()["forward_scatter_ml"]
    recording = simulate(PassParameters(), (0,), 1)
    site = recording.site
    assert site is not None
    first, second = site.receivers
    both = site.model_copy(update={"receivers": (first, first.model_copy(update={"name": second.name}))})
    with pytest.raises(RecordingError, match="same place"):
        algorithm.run(replace(recording, site=both), algorithm.parameters(), LocalContext())
