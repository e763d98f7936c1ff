"""What holds of the multiple-model filters for every input: specification 6.6, and the textbook's IMM by FilterPy."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from algorithms.errors import ParameterError
from algorithms.multiple_model import mma2_11, mma2_122
from algorithms.multiple_model.parameters import PaperParameters
from algorithms.multiple_model.scenario import AeroballisticParameters, AntennaScenario, simulate
from algorithms.multiple_model.states import COASTING, REJECTED, UNUSUAL
from algorithms.multiple_model.tracker import ModelSet, model_names, run_bank
from algorithms.recording import AntennaPlots
from algorithms.spec import LocalContext
from algorithms.toolbox.filters.merging import RULES
from algorithms.toolbox.kernels import generate_hypothesis
from algorithms.toolbox.kernels.angle import arctangent2
from algorithms.toolbox.kernels.exponential import exp_row, log_row

PAPER = PaperParameters()
THREE = mma2_122.models_of(mma2_122.Mma2Parameters())
TWO = mma2_11.models_of(mma2_11.Mma211Parameters())


@pytest.fixture(scope="module")
def arc() -> AntennaPlots:
    """Three trials of A at 1 Hz."""
    return simulate(AeroballisticParameters(rate_hz=1.0), (0, 1, 2), 5)


def filtered(recording: AntennaPlots, chosen: ModelSet, parameters: Any = PAPER) -> Any:
    return run_bank(recording, parameters, chosen, LocalContext(), lean=False).report


def test_hypotheses_stand_as_generated() -> None:
    written = Path(generate_hypothesis.__file__).with_name("hypothesis.py").read_text("utf-8")
    assert written == generate_hypothesis.source()


def test_the_angle_of_a_point_is_that_of_the_library() -> None:
    rng = np.random.default_rng(4)
    points = rng.normal(size=(2000, 2)) * 10 ** rng.uniform(-6, 6, (2000, 2))
    points = [*points, (0.66, 1.0), (1.0, 1.0), (0.0, 1.0), (0.0, -1.0), (-1.0, 0.0), (0.0, 0.0)]
    got = [arctangent2(y, x) for y, x in points]
    np.testing.assert_allclose(got, [np.arctan2(y, x) for y, x in points], rtol=0, atol=1e-15)


def test_exponential_and_logarithm_are_those_of_the_library() -> None:
    rng = np.random.default_rng(1)
    for _ in range(200):
        x = -(rng.uniform(0, 10, 16) ** 3)
        out = np.empty(16)
        exp_row(x, out)
        np.testing.assert_allclose(out, np.where(x < -700, 0, np.exp(x)), rtol=1e-15)
        y = np.exp(rng.uniform(-600, 600, 16))
        log_row(y, out)
        np.testing.assert_allclose(out, np.log(y), rtol=5e-16, atol=2e-16)
    zero = np.zeros(16)
    exp_row(zero, zero)
    assert (zero == 1).all()
    log_row(zero, zero)
    assert (zero == 0).all()


def test_a_moment_merged_imm_is_filterpys(arc: AntennaPlots) -> None:
    """Specification 6.6 (a): the same filters, marks and matrices."""
    kalman = pytest.importorskip("filterpy.kalman")
    chosen = replace(THREE, merging="moment", output="moment")
    report = filtered(arc, chosen)
    prepared = run_bank(arc, PAPER, chosen, LocalContext(), lean=True).prepared
    from algorithms.toolbox.filters.transition import transition_over
    from algorithms.toolbox.frames.bicone import antenna_axes, covariance_from_bicone

    axes = antenna_axes(0.0, np.radians(30))
    sd = (2.5, np.radians(0.1), np.radians(0.1))
    matrix = transition_over(np.array(chosen.transition).T, 20)[0].T
    h = np.zeros((3, 9))
    h[[0, 1, 2], [0, 3, 6]] = 1
    filters = []
    for kind, sigma in chosen.models:
        f = kalman.KalmanFilter(9, 3)
        ca = kind == "ca"
        f1 = np.array([[1, 1, 0.5 * ca], [0, 1, 1.0 * ca], [0, 0, 1.0 * ca]])
        g = np.array([0.5, 1, 1.0 * ca])
        f.F, f.Q, f.H = np.kron(np.eye(3), f1), np.kron(np.eye(3), sigma**2 * np.outer(g, g)), h
        f.x = np.zeros((9, 1))
        f.x[::3, 0] = prepared.y[0, :, 0]
        f.P = np.kron(np.eye(3), np.diag([0, 1000.0**2, 30.0**2 * ca]))
        f.P[::3, ::3] = covariance_from_bicone(*prepared.z[0, :, 0], sd, axes)
        filters.append(f)
    imm = kalman.IMMEstimator(filters, np.full(3, 1 / 3), matrix)
    for k in range(1, 60):
        imm.predict()
        r = covariance_from_bicone(*prepared.z[k, :, 0], sd, axes)
        for f in filters:
            f.R = r
        imm.update(prepared.y[k, :, 0][:, None])
        np.testing.assert_allclose(report.state[k, :, 0], imm.x[:, 0], rtol=0, atol=2e-6)
        np.testing.assert_allclose(report.probability[k, :, 0], imm.mu, atol=1e-8)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("structure", ["imm", "gpb2"])
def test_equal_models_are_one_kalman_filter(arc: AntennaPlots, structure: str, rule: str) -> None:
    one = filtered(arc, ModelSet((("ca", 1.0),)))
    matrix = ((0.9, 0.1, 0.0), (0.2, 0.5, 0.3), (0.05, 0.05, 0.9))
    three = filtered(arc, ModelSet((("ca", 1.0),) * 3, matrix, 1.0, structure, rule, "moment"))
    np.testing.assert_allclose(three.state, one.state, rtol=0, atol=1e-6)
    if rule != "modified_pair":
        predicted = np.full(3, 1 / 3) @ np.linalg.matrix_power(np.array(matrix), 5)
        np.testing.assert_allclose(three.probability[5, :, 0], predicted, atol=1e-9)


@pytest.mark.parametrize("structure", ["gpb1", "imm", "gpb2"])
def test_a_permutation_of_models_permutes_the_answer(arc: AntennaPlots, structure: str) -> None:
    order = [2, 0, 1]
    base = replace(THREE, structure=structure, merging="moment", output="moment")
    turned = replace(
        base,
        models=tuple(base.models[i] for i in order),
        transition=tuple(tuple(base.transition[i][j] for j in order) for i in order),
    )
    a, b = filtered(arc, base), filtered(arc, turned)
    np.testing.assert_allclose(a.state, b.state, rtol=0, atol=1e-5)
    np.testing.assert_allclose(a.probability[:, order], b.probability, atol=1e-8)


def test_one_model_is_the_kalman_filter_to_the_bit(arc: AntennaPlots) -> None:
    one = filtered(arc, ModelSet((("ca", 1.0),)))
    static = filtered(
        arc, ModelSet((("ca", 1.0), ("ca", 30.0)), ((1.0, 0.0), (0.0, 1.0)), 0.05, "imm", "moment", "max")
    )
    assert (one.probability == 1).all()
    first = static.model_state[:, 0]
    np.testing.assert_allclose(first, one.state, rtol=0, atol=1e-6)


def test_a_rotation_about_the_vertical_rotates_the_answer(arc: AntennaPlots) -> None:
    """The antenna turned by 50 degrees sees the same; only the frame has turned."""
    chosen = replace(THREE, merging="moment", output="moment")
    site = arc.site.model_dump(exclude_none=True)
    site["radars"][0]["azimuth_deg"] = 50.0
    from algorithms.site import Site

    turned = filtered(replace(arc, site=Site.model_validate(site)), chosen).state
    c, s = np.cos(np.radians(50)), np.sin(np.radians(50))
    plain = filtered(arc, chosen).state
    for i in range(3):
        np.testing.assert_allclose(turned[:, i], c * plain[:, i] + s * plain[:, 3 + i], rtol=0, atol=1e-5)
        np.testing.assert_allclose(turned[:, 3 + i], c * plain[:, 3 + i] - s * plain[:, i], rtol=0, atol=1e-5)


def test_ways_to_filter_agree_where_angles_are_fine(arc: AntennaPlots) -> None:
    """With angles a hundred times finer nothing is nonlinear."""
    fine = simulate(AeroballisticParameters(rate_hz=1.0, sigma_bicone_elevation_deg=0.001,
                                            sigma_bicone_azimuth_deg=0.001), (0,), 5)  # fmt: skip
    ways = ("converted", "converted_at_prediction", "ekf", "ukf")
    found = [filtered(fine, THREE, PaperParameters(measurement=way)).state[20:, [0, 3, 6]] for way in ways]
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], rtol=0, atol=3.0)


def test_an_unreachable_model_keeps_probability_zero(arc: AntennaPlots) -> None:
    matrix = ((0.9, 0.1, 0.0), (0.1, 0.9, 0.0), (0.5, 0.5, 0.0))
    report = filtered(arc, ModelSet((("cv", 5.0), ("ca", 1.0), ("ca", 30.0)), matrix, 1.0, "imm", "combined", "max"))
    assert (report.probability[1:, 2] == 0).all()
    assert np.isfinite(report.state).all()


def test_missed_wild_and_repeated_measurements(arc: AntennaPlots) -> None:
    z = arc.range_m.copy()
    z[40] = np.nan
    z[60] += 3000.0
    time = arc.time_s.copy()
    time[80] = time[79]
    report = filtered(replace(arc, range_m=z, time_s=time), THREE)
    assert (report.status[40] == COASTING).all()
    assert np.isfinite(report.state[40]).all(), "the prediction is shown"
    assert (report.status[60] == UNUSUAL).all()
    assert (report.status[80] == REJECTED).all()
    assert np.isfinite(report.state[60:80]).all()
    np.testing.assert_allclose(report.probability[~np.isnan(report.probability[:, 0, 0])].sum(axis=1), 1, atol=1e-12)


def test_a_matrix_that_is_transposed_is_said_so() -> None:
    p = tuple(zip(*mma2_122.TRANSITION, strict=True))
    recording = simulate(AntennaScenario(duration_s=1.0), (0,), 1)
    with pytest.raises(ParameterError, match="Row 1") as caught:
        run_bank(recording, PAPER, replace(THREE, transition=p), LocalContext(), lean=True)
    assert caught.value.code == "transition_transposed"


def test_a_matrix_without_a_root_is_refused_with_irregular_times() -> None:
    flip = ModelSet((("cv", 1.0), ("ca", 1.0)), ((0.1, 0.9), (0.9, 0.1)), 0.05)
    regular = simulate(AntennaScenario(duration_s=1.0), (0,), 1)
    assert np.isfinite(filtered(regular, flip).state).all()
    irregular = simulate(AntennaScenario(duration_s=1.0, timing="irregular"), (0,), 1)
    with pytest.raises(ParameterError) as caught:
        run_bank(irregular, PAPER, flip, LocalContext(), lean=True)
    assert caught.value.code == "transition_root"


@pytest.mark.parametrize("seed", range(3))
def test_noise_gaps_and_outliers_leave_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scenario = AeroballisticParameters(
        timing="irregular", rate_hz=4.0, outlier_share=0.05, detection_probability=0.7,
        sigma_range_m=float(10 ** rng.uniform(-1, 3)), gaps=({"start_s": 50.0, "stop_s": 50.0 + 40 * rng.random()},),
    )  # fmt: skip
    sigma = 10 ** rng.uniform(-3, 2.5, 3)
    chosen = ModelSet((("cv", sigma[0]), ("ct", sigma[1]), ("gd", sigma[2])), THREE.transition, 0.05, "imm", "moment")
    report = filtered(simulate(scenario, (0, 1), seed), chosen)
    live = report.track > 0
    assert np.isfinite(report.state[np.broadcast_to(live[:, None], report.state.shape)]).all()
    diagonal = [i * (i + 1) // 2 + i for i in range(9)]
    assert (report.covariance[:, diagonal][np.broadcast_to(live[:, None], (len(live), 9, 2))] >= 0).all()
    p = np.moveaxis(report.probability, 1, 2)[live]
    np.testing.assert_allclose(p.sum(axis=1), 1, atol=1e-12)


def test_models_are_named_by_kind_and_noise() -> None:
    assert model_names([("cv", 0.05), ("ca", 30.0), ("ca", 30.0)]) == ("cv_0.05", "ca_30", "ca_30_2")
