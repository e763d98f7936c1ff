"""A million steps of fuzzed noise, gaps and wild plots: no NaN, no negative variance, no probability stuck."""

from __future__ import annotations

import numpy as np
import pytest

from algorithms.multiple_model import states
from algorithms.multiple_model.parameters import MotionParameters
from algorithms.multiple_model.scenario import AeroballisticParameters, simulate
from algorithms.multiple_model.tracker import ModelSet, run_bank
from algorithms.spec import LocalContext
from algorithms.toolbox.filters.merging import RULES

KINDS = ("cv", "ca", "ct", "gv", "gd")
WAYS = ("converted", "converted_at_prediction", "ekf", "ukf")
FORMS = ("step", "rate", "substeps")
LANES, STEPS = 16, 1_000_000


def random_case(rng: np.random.Generator) -> tuple[AeroballisticParameters, ModelSet, MotionParameters]:
    n = int(rng.integers(2, 6))
    # Of this form every power is a chain.
    rows = 0.4 * rng.dirichlet(np.ones(n))[None] + 0.6 * np.eye(n)
    structure = str(rng.choice(["gpb1", "imm", "gpb2"]))
    rule = str(rng.choice(RULES[:2] if structure == "gpb1" else RULES))
    start = float(rng.uniform(20, 100))
    scenario = AeroballisticParameters(
        timing="irregular", rate_hz=float(10 ** rng.uniform(-0.3, 1.2)), timing_seed=int(rng.integers(1 << 30)),
        detection_probability=float(rng.uniform(0.5, 1)), outlier_share=float(rng.choice([0, 0.01, 0.2])),
        gaps=({"start_s": start, "stop_s": start + float(rng.uniform(1, 70))},),
        sigma_range_m=float(10 ** rng.uniform(-2, 4)), sigma_bicone_elevation_deg=float(10 ** rng.uniform(-4, 0.6)),
        sigma_bicone_azimuth_deg=float(10 ** rng.uniform(-4, 0.6)),
    )  # fmt: skip
    models = tuple((str(rng.choice(KINDS)), float(10 ** rng.uniform(-3, 2.5))) for _ in range(n))
    chosen = ModelSet(models, tuple(map(tuple, rows)), float(rng.choice([0.05, 1.0])), structure, rule, "moment")
    told = {
        "sigma_range_m": float(10 ** rng.uniform(-2, 4)),
        "measurement": str(rng.choice(WAYS)),
        "noise_form": str(rng.choice(FORMS)),
    }
    return scenario, chosen, MotionParameters.model_validate(told)


@pytest.mark.slow
def test_a_million_steps() -> None:
    rng = np.random.default_rng(2023)
    done = restarts = judged = 0
    diagonal = [i * (i + 1) // 2 + i for i in range(9)]
    while done < STEPS:
        scenario, chosen, parameters = random_case(rng)
        recording = simulate(scenario, tuple(range(LANES)), int(rng.integers(1 << 30)))
        report = run_bank(recording, parameters, chosen, LocalContext(), lean=False).report
        live = report.track > 0
        what = (scenario, chosen, parameters)
        assert np.isfinite(np.moveaxis(report.state, 1, 2)[live]).all(), what
        covariance = np.moveaxis(report.covariance, 1, 2)[live]
        assert np.isfinite(covariance).all(), what
        assert (covariance[:, diagonal] >= 0).all(), what
        p = np.moveaxis(report.probability, 1, 2)[live]
        np.testing.assert_allclose(p.sum(axis=1), 1, atol=1e-9)
        # Every model can be reached from every other one, so where errors are told about right none stays at 0 or 1.
        if parameters.sigma_range_m >= 0.3 * scenario.sigma_range_m and scenario.outlier_share < 0.1:
            late = report.probability[-len(report.probability) // 4 :]
            assert ((late > 0) & (late < 1)).any(axis=0).all(), what
            judged += 1
        restarts += int((report.status == states.RESTARTED).sum())
        done += live.size
    assert restarts < 0.02 * done
    assert judged > 10
