"""The trial-block kernels against an independent dense filter, a square-root filter, and what must not matter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from algorithms.multilateration import lanes
from algorithms.multilateration.parameters import FilterWithAltitudeParameters, Start
from algorithms.multilateration.scenario import IncompleteParameters, simulate
from algorithms.multilateration.tracker import run_filter
from algorithms.recording import ToaMarks
from algorithms.site import Site
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels import LANES, generate
from algorithms.toolbox.kernels.symmetric import invert3, pack, solve3, unpack
from algorithms.toolbox.kernels.unrolled import update_rows_9
from algorithms.toolbox.motion.jerk import PROCESS_NOISE, predict_jerk
from tests.oracles.dense_filter import DenseFilter, f_matrix, q_matrix

SD = (500.0, 50.0, 1.0)
PRIOR = np.kron(np.eye(3), np.diag(np.square(SD)))


@pytest.fixture(scope="module")
def marks() -> ToaMarks:
    return simulate(IncompleteParameters(), tuple(range(20)), 3)


def start_state(recording: ToaMarks) -> np.ndarray:
    state = np.zeros(9)
    state[[0, 3, 6]] = recording.truth_m[0] + [300.0, -200.0, 100.0]
    state[[1, 4, 7]] = recording.truth_velocity_mps[0]
    return state


def article(form: str, state: np.ndarray, **extra: object) -> FilterWithAltitudeParameters:
    start = Start(mode="given", state=tuple(state), sd=SD)
    return FilterWithAltitudeParameters(profile="article", process_noise=form, start=start, **extra)


@pytest.mark.parametrize("form", PROCESS_NOISE)
@pytest.mark.parametrize("altitude", [True, False])
@pytest.mark.parametrize("reference", [-1, 0])
def test_agrees_with_the_dense_joseph_filter(marks: ToaMarks, form: str, altitude: bool, reference: int) -> None:
    """Irregular and incomplete marks, altitude-only marks included: state, covariance and NIS agree."""
    assert marks.site is not None
    state = start_state(marks)
    trial = 17  # in the second, padded block
    result = run_filter(marks, article(form, state), LocalContext(), altitude=altitude)
    dense = DenseFilter(marks.site.station_positions(), 10e-9, 100.0, 0.1, form, state.copy(), PRIOR.copy(), reference)
    count = 400
    for k in range(count):
        if k:
            dense.predict(marks.time_s[k] - marks.time_s[k - 1])
        step = dense.update(marks.toa_s[k, :, trial], marks.altitude_m[k, trial] if altitude else np.nan)
        if step.dof:
            assert result.arrays["nis"][k, trial] == pytest.approx(step.nis, rel=1e-6, abs=1e-8)
        assert result.arrays["dof"][k, trial] == step.dof
    np.testing.assert_allclose(result.arrays["state"][count - 1, :, trial], dense.x, rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(unpack(result.arrays["covariance"][count - 1, :, trial]), dense.p, rtol=1e-6, atol=1e-7)


def run(recording: ToaMarks, altitude: bool = True, **extra: object) -> dict[str, np.ndarray]:
    return dict(run_filter(recording, FilterWithAltitudeParameters(**extra), LocalContext(), altitude=altitude).arrays)


def test_trials_do_not_depend_on_their_block(marks: ToaMarks) -> None:
    """Trial 17 alone gives the same bytes as trial 17 among twenty."""
    from dataclasses import replace

    alone = replace(marks, toa_s=marks.toa_s[:, :, 17:18], altitude_m=marks.altitude_m[:, 17:18])
    together, single = run(marks), run(alone)
    for name in ("state", "covariance", "nis", "status", "used"):
        assert together[name][..., 17:18].tobytes() == single[name].tobytes(), name


def test_slices_do_not_matter(marks: ToaMarks, monkeypatch: pytest.MonkeyPatch) -> None:
    from algorithms.multilateration import tracker

    whole = run(marks)
    monkeypatch.setattr(tracker, "SLICE_RECEPTIONS", 4 * 37)
    cut = run(marks)
    assert all(whole[name].tobytes() == cut[name].tobytes() for name in whole)


def test_order_of_stations_does_not_matter(marks: ToaMarks) -> None:
    from dataclasses import replace

    assert marks.site is not None
    order = [2, 0, 3, 1]
    site = marks.site.model_copy(update={"stations": tuple(marks.site.stations[i] for i in order)})
    shuffled = replace(marks, site=site, stations=tuple(marks.stations[i] for i in order), toa_s=marks.toa_s[:, order])
    a, b = run(marks), run(shuffled)
    np.testing.assert_allclose(b["state"][-1, ::3], a["state"][-1, ::3], atol=1e-4)


def test_a_shift_of_all_clocks_does_not_matter(marks: ToaMarks) -> None:
    """The emission time is unknown: adding the same delay to every time of arrival moves only the time tag."""
    from dataclasses import replace

    later = replace(marks, toa_s=marks.toa_s + 1e-3)
    start = {"start": Start(mode="given", state=tuple(start_state(marks)), sd=SD), "profile": "article"}
    a, b = run(marks, **start), run(later, **start)
    np.testing.assert_allclose(b["state"][:300, ::3], a["state"][:300, ::3], atol=1e-5)


def test_rotation_of_site_and_truth_rotates_the_track(marks: ToaMarks) -> None:
    from dataclasses import replace

    assert marks.site is not None
    turn = np.radians(73.0)
    m = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    stations = [
        {"name": s.name, "east_m": p[0], "north_m": p[1], "up_m": p[2]}
        for s, p in zip(marks.site.stations, marks.site.station_positions() @ m.T, strict=True)
    ]
    site = Site.model_validate({**marks.site.to_json(), "stations": stations})
    state = start_state(marks).reshape(3, 3)
    turned = replace(marks, site=site)
    a = run(marks, profile="article", start=Start(mode="given", state=tuple(state.ravel()), sd=SD))
    b = run(turned, profile="article", start=Start(mode="given", state=tuple((m @ state).ravel()), sd=SD))
    np.testing.assert_allclose(b["state"][400, ::3, :], m @ a["state"][400, ::3, :], atol=1e-3)


def test_translation_of_site_and_truth_moves_the_track(marks: ToaMarks) -> None:
    """Without the altitude, which knows where the Earth is, no place is better than another."""
    from dataclasses import replace

    assert marks.site is not None
    move = np.array([12_000.0, -7_000.0, 300.0])
    stations = [
        {"name": s.name, "east_m": p[0], "north_m": p[1], "up_m": p[2]}
        for s, p in zip(marks.site.stations, marks.site.station_positions() + move, strict=True)
    ]
    site = Site.model_validate({**marks.site.to_json(), "stations": stations})
    state = start_state(marks)
    moved = state.copy()
    moved[::3] += move
    a = run(marks, False, profile="article", start=Start(mode="given", state=tuple(state), sd=SD))
    b = run(replace(marks, site=site), False, profile="article", start=Start(mode="given", state=tuple(moved), sd=SD))
    np.testing.assert_allclose(b["state"][200, ::3] - move[:, None], a["state"][200, ::3], atol=1e-2)


def test_another_zero_of_time_does_not_matter(marks: ToaMarks) -> None:
    from dataclasses import replace

    start = {"start": Start(mode="given", state=tuple(start_state(marks)), sd=SD), "profile": "article"}
    a, b = run(marks, **start), run(replace(marks, time_s=marks.time_s + 4096.0), **start)
    np.testing.assert_allclose(b["time_s"][:300] - 4096.0, a["time_s"][:300], atol=1e-9)
    np.testing.assert_allclose(b["state"][:300], a["state"][:300], atol=1e-4)


@given(
    t=st.floats(0.0, 60.0),
    sigma=st.floats(1e-3, 10.0),
    form=st.sampled_from(PROCESS_NOISE),
    seed=st.integers(0, 2**32 - 1),
)
def test_prediction_is_f_p_f_plus_q(t: float, sigma: float, form: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((9, 9))
    p0 = root @ root.T
    x0 = rng.standard_normal(9)
    x, p = np.repeat(x0[:, None], LANES, axis=1), np.repeat(pack(p0)[:, None], LANES, axis=1)
    predict_jerk(x, p, np.full(LANES, t), sigma, PROCESS_NOISE.index(form))
    f = f_matrix(t)
    expected = f @ p0 @ f.T + q_matrix(t, sigma, form)
    np.testing.assert_allclose(x[:, 3], f @ x0, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(unpack(p[:, 5]), expected, rtol=1e-10, atol=1e-9 * np.abs(expected).max())


@given(seed=st.integers(0, 2**32 - 1), spread=st.floats(0.0, 6.0))
def test_rows_keep_an_ill_conditioned_covariance_sound(seed: int, spread: float) -> None:
    """From condition numbers up to 1e12 on, 200 rows agree with Potter's square-root update in long arithmetic.

    The square-root filter cannot lose positive definiteness, so it is the judge; it runs in extended precision.
    """
    rng = np.random.default_rng(seed)
    basis, _ = np.linalg.qr(rng.standard_normal((9, 9)))
    root = basis * 10.0 ** np.linspace(-spread, spread, 9)[None]
    p0 = root @ root.T
    x = np.zeros((9, LANES))
    p = np.repeat(pack((p0 + p0.T) / 2)[:, None], LANES, axis=1)
    square = root.astype(np.longdouble)
    state = np.zeros(9, np.longdouble)
    start, nis, determinant = np.zeros((3, LANES)), np.zeros(LANES), np.ones(LANES)
    scale = float(np.abs(p0).max())
    for _ in range(200):
        h3 = rng.standard_normal(3)
        variance, nu = float(10.0 ** rng.uniform(-1, 2)), float(rng.standard_normal())
        h9 = np.zeros(9, np.longdouble)
        h9[::3] = h3
        e = nu - h9 @ state
        f = square.T @ h9
        s = f @ f + variance
        gain = square @ f / s
        state = state + gain * e
        square = square - np.outer(gain, f) / (1 + np.sqrt(variance / s))
        lanes_of = lambda v: np.repeat(np.atleast_1d(v)[:, None], LANES, axis=1)  # noqa: E731
        update_rows_9(
            x, p, start, lanes_of(h3)[None], lanes_of(nu), lanes_of(variance), np.ones((1, LANES)), nis, determinant
        )
    expected = (square @ square.T).astype(float)
    full = unpack(p[:, 2])
    assert np.abs(full - expected).max() <= 1e-9 * scale
    assert np.linalg.eigvalsh(full)[0] >= -1e-9 * scale
    # A lane that has no rows stays as it was.
    before = p.copy()
    update_rows_9(
        x,
        p,
        start,
        np.ones((1, 3, LANES)),
        np.ones((1, LANES)),
        np.ones((1, LANES)),
        np.zeros((1, LANES)),
        nis,
        determinant,
    )
    assert (p == before).all()


@given(seed=st.integers(0, 2**32 - 1))
def test_small_solvers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((3, 3))
    s, b, out, inverse = root @ root.T + 0.1 * np.eye(3), rng.standard_normal(3), np.empty(3), np.empty(6)
    assert solve3(pack(s), b, out)
    np.testing.assert_allclose(s @ out, b, atol=1e-9)
    assert invert3(pack(s), inverse)
    np.testing.assert_allclose(unpack(inverse) @ s, np.eye(3), atol=1e-8)
    assert not solve3(pack(-s), b, out)
    assert not invert3(pack(np.outer(b, b)), inverse)


def test_status_of_out_of_order_marks(marks: ToaMarks) -> None:
    """A filter fed out of order says so and goes on; readers sort, so this can only come from a caller."""
    from dataclasses import replace

    time = marks.time_s.copy()
    time[50] = time[40]
    a = run(replace(marks, time_s=time))
    assert (a["status"][50] == lanes.REJECTED_TIME).all()
    assert np.isnan(a["state"][50]).all()
    assert np.isfinite(a["state"][51]).any()


def test_the_written_out_rows_are_what_the_generator_writes() -> None:
    assert Path(generate.__file__).with_name("unrolled.py").read_text(encoding="utf-8") == generate.source()
