"""Regions with transition matrices of their own: where they hold the last estimate, their matrix counts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from algorithms.errors import ParameterError
from algorithms.multiple_model import multiple_model
from algorithms.multiple_model.multiple_model import MultipleModelParameters
from algorithms.multiple_model.scenario import StraightParameters, simulate
from algorithms.recording import AntennaPlots
from algorithms.spec import LocalContext

MODELS = ({"kind": "cv", "sigma_mps2": 1.0}, {"kind": "ca", "sigma_mps2": 10.0})
CALM = ((0.99, 0.01), (0.02, 0.98))
WILD = ((0.6, 0.4), (0.1, 0.9))
FAR = 1e6


@pytest.fixture(scope="module")
def straight() -> AntennaPlots:
    """From -15 km east and 80 km north at 10 km: 150 m/s to the east, 200 m/s to the south; one plot a second."""
    return simulate(StraightParameters(rate_hz=1.0, duration_s=60.0), (0,), 3)


def shares(recording: AntennaPlots, transition: Any = CALM, **region: Any) -> np.ndarray:
    regions = ({"transition": WILD, **region},) if region else ()
    told = {"models": MODELS, "transition": transition, "transition_step_s": 1.0, "regions": regions}
    result = multiple_model.run(recording, MultipleModelParameters.model_validate(told), LocalContext())
    return result.arrays["mode_probability"][:, 1, 0]


def test_a_region_that_is_everywhere_replaces_the_matrix(straight: AntennaPlots) -> None:
    assert shares(straight, name="all").tobytes() == shares(straight, WILD).tobytes()
    assert np.abs(shares(straight, WILD) - shares(straight)).max() > 0.05


def test_a_region_elsewhere_changes_nothing(straight: AntennaPlots) -> None:
    plain = shares(straight).tobytes()
    assert shares(straight, lowest_up_m=20_000.0).tobytes() == plain
    assert shares(straight, highest_up_m=5_000.0).tobytes() == plain
    away = [(20_000, 0), (30_000, 0), (30_000, FAR), (20_000, FAR)]
    assert shares(straight, corners=away).tobytes() == plain


def test_a_polygon_counts_from_the_estimate_inside_it(straight: AntennaPlots) -> None:
    """The object crosses -11 km east at 26.7 s; its estimate is within a few hundred metres."""
    east_of = [(-11_000, 0), (50_000, 0), (50_000, FAR), (-11_000, FAR)]
    changed, plain = shares(straight, corners=east_of), shares(straight)
    time = straight.time_s
    assert (changed[time <= 22] == plain[time <= 22]).all()
    assert (changed[time >= 32] != plain[time >= 32]).all()


def test_a_region_s_matrix_is_checked_before_a_run() -> None:
    with pytest.raises(ParameterError) as caught:
        MultipleModelParameters.model_validate(
            {"models": MODELS, "transition": CALM, "regions": ({"transition": ((0.5, 0.4), (0.1, 0.9))},)}
        )
    assert caught.value.pointer == "/regions/0/transition/0"
