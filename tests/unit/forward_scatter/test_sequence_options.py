"""Every option of the paper's algorithm against a slow statement of the specification (section 4)."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.recording import DopplerPairs
from algorithms.registry import algorithms_by_name
from algorithms.spec import LocalContext
from tests.oracles import scatter_lines

LINES = algorithms_by_name()["forward_scatter_lines"]
# One trial in four has no missing values.
CONDITIONS: tuple[dict[str, Any], ...] = (
    {},
    {"missing_share": 0.2},
    {"missing_share": 0.3, "crossing_distance_m": 30_000.0, "course_deg": -70.0},
    {"missing_share": 0.1, "period_s": 0.5, "sigma_doppler_hz": 1.0},
)


@cache
def made(i: int) -> DopplerPairs:
    return simulate(PassParameters(**CONDITIONS[i]), tuple(range(6)), 40 + i)


@pytest.mark.parametrize("conditions", range(len(CONDITIONS)))
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"window": 4},
        {"window": 31},
        {"freeze_rule": "b"},
        {"freeze_rule": "c"},
        {"freeze_rule": "none"},
        {"freeze_delay": 4},
        {"freeze_delay": 4, "freeze_rule": "c"},
        {"confirm": 3},
        {"confirm": 3, "freeze_delay": 2},
        {"confirm": 3, "freeze_rule": "b"},
        {"formula": 17},
        {"formula": 17, "formula_17_origin": "start"},
        {"formula": 18},
        {"formula": 19},
        {"omega": "mean_difference"},
        {"omega": "mean_of_all"},
        {"omega": "mean_of_all", "curvature_correction": True},
        {"freeze_delay": 4, "curvature_correction": True},
        {"formula": 19, "omega": "mean_difference", "curvature_correction": True},
    ],
    ids=lambda o: ", ".join(f"{k}={v}" for k, v in o.items()) or "defaults",
)
def test_options_do_what_the_specification_says(options: dict[str, Any], conditions: int) -> None:
    recording = made(conditions)
    found = LINES.run(recording, LINES.parameters(passes="one", **options), LocalContext()).arrays
    for trial in range(recording.doppler_hz.shape[2]):
        f = recording.doppler_hz[:, :, trial]
        expected = scatter_lines.lines(recording.time_s, f, a=40_000.0, b=300.0, wavelength=1.0, **options)
        answered = np.isin(found["status"][:, trial], outputs.ANSWERED)
        assert answered.tolist() == np.isfinite(expected[:, 1]).tolist()
        # A denominator near zero makes rounding errors large: v_y grows with s.
        assert found["theta"][answered, :3, trial] == pytest.approx(expected[answered], rel=1e-6)


def test_the_two_angular_velocities_are_one_where_nothing_is_missing() -> None:
    recording = made(0)
    one, other = (
        LINES.run(recording, LINES.parameters(omega=omega), LocalContext()).arrays["omega_rad_s"]
        for omega in ("lines", "mean_difference")
    )
    assert other == pytest.approx(one, rel=1e-9, nan_ok=True)
    missing = made(1)
    one, other = (
        LINES.run(missing, LINES.parameters(omega=omega), LocalContext()).arrays["omega_rad_s"]
        for omega in ("lines", "mean_difference")
    )
    assert np.nanmax(np.abs(other / one - 1)) > 0.05


def test_predicted_errors_are_what_the_estimates_scatter_by() -> None:
    """For all formulas and angular velocities, in the middle of their distribution (its tails have no moments)."""
    recording = simulate(PassParameters(crossing_distance_m=20_000.0), tuple(range(512)), 8)
    for options in (
        {},
        {"formula": 17},
        {"formula": 18},
        {"formula": 19},
        {"window": 31},
        {"omega": "mean_of_all"},
        {"freeze_rule": "c"},
        {"freeze_delay": 4},
        {"confirm": 3, "robust": "huber"},
    ):
        a = LINES.run(recording, LINES.parameters(**options), LocalContext()).arrays
        for k in (9, 16, 20, 30):
            low, high = np.nanpercentile(a["theta"][k, 1], [15.87, 84.13])
            claimed = np.sqrt(np.nanmedian(a["theta_covariance"][k, 1, 1]))
            assert (high - low) / 2 / claimed == pytest.approx(1, abs=0.17), (options, k)
