"""Long recordings are cut into passes; sites with two transmitters; channels that miss."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import legs_of, simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.result import Result
from algorithms.spec import LocalContext

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
