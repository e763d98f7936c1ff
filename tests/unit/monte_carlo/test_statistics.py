"""Statistics over trials against other routes: the bootstrap, Student's formula, brute force over all trials."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy import stats

from algorithms.scores import Sample, Scores, Tally
from algorithms.spec import Leg
from algorithms.toolbox.monte_carlo.batches import BATCH, batches, batches_per_task, tasks
from algorithms.toolbox.monte_carlo.intervals import Moments, interval_of_ratio, quantiles_with_intervals
from algorithms.toolbox.monte_carlo.running import Running
from algorithms.toolbox.monte_carlo.sums import Node, Sums, fold, joined, sums_of

INSTANTS, TRIALS = 50, 300
LEGS = (Leg("early", 0, 20), Leg("late", 20, 50))


def errors(seed: int, bias: float = 0.0, common: float = 0.0) -> np.ndarray:
    """(T, N) squared errors, correlated within a trial, with a share of the draws in common between two seeds."""
    shared = np.random.default_rng(1).standard_normal((INSTANTS, TRIALS))
    own = np.random.default_rng(seed)
    level = own.standard_normal(TRIALS)
    return (bias + level + common * shared + own.standard_normal((INSTANTS, TRIALS))) ** 2


def scores_of(squares: np.ndarray, first: int, stop: int) -> Scores:
    part = squares[:, first:stop]
    known = np.isfinite(part).astype(float)
    return Scores(
        (
            Tally("rms_m", "m", np.nan_to_num(part), known, root=True, curve=True, compared=True),
            Tally("over_share", "1", (np.nan_to_num(part) > 9).astype(float), known, share=True),
            Tally("chi", "1", np.nan_to_num(part), known, curve=True, chi_square=True),
            Tally("wild", "1", (np.nan_to_num(part) > 25).any(axis=0) * 1.0, np.ones(stop - first), share=True),
        ),
        (Sample("error_m", "m", np.sqrt(part).astype(np.float32), curve=True),),
        np.arange(INSTANTS, dtype=float),
        np.arange(INSTANTS) % 2,
        ("a", "b"),
    )


def run_of(*fields: np.ndarray, per_task: int = 1) -> Running:
    running = Running(len(fields))
    for first, stop in tasks(TRIALS, per_task):
        parts = [[sums_of(scores_of(f, a, b), LEGS, batch=a // BATCH) for a, b in batches(first, stop)] for f in fields]
        running.add([joined(part) for part in parts])
    return running


@pytest.fixture(scope="module")
def field() -> np.ndarray:
    squares = errors(2)
    squares[:5, :30] = np.nan
    return squares


def test_metrics_are_those_of_all_trials_at_once(field: np.ndarray) -> None:
    metrics = {(m.metric, m.segment, m.target): m for m in run_of(field).metrics(0)}
    for segment, target, rows in (
        ("", "", slice(None)),
        ("early", "", slice(0, 20)),
        ("late", "", slice(20, 50)),
        ("", "a", slice(0, None, 2)),
    ):
        part = field[rows]
        got = metrics["rms_m", segment, target]
        assert got.value == pytest.approx(np.sqrt(np.nanmean(part)), rel=1e-12)
        assert got.n == np.isfinite(part).sum()
        assert metrics["over_share", segment, target].value == pytest.approx((part > 9).sum() / got.n, rel=1e-12)
        median = metrics["median_error_m", segment, target].value
        assert median == pytest.approx(np.nanmedian(np.sqrt(part).astype(np.float32)), rel=1e-6)
        assert metrics["max_error_m", segment, target].value == pytest.approx(np.sqrt(np.nanmax(part)), rel=1e-6)
    assert metrics["wild", "", ""].value == pytest.approx((np.nan_to_num(field) > 25).any(axis=0).mean())
    assert ("wild", "early", "") not in metrics


def test_intervals_agree_with_the_bootstrap_over_trials(field: np.ndarray) -> None:
    metrics = {m.metric: m for m in run_of(field).metrics(0) if not m.segment and not m.target}
    rng = np.random.default_rng(3)
    drawn = {"rms_m": [], "over_share": [], "median_error_m": []}
    for _ in range(2_000):
        again = field[:, rng.integers(0, TRIALS, TRIALS)]
        drawn["rms_m"].append(np.sqrt(np.nanmean(again)))
        drawn["over_share"].append((again > 9).sum() / np.isfinite(again).sum())
        drawn["median_error_m"].append(np.nanmedian(np.sqrt(again)))
    for name, values in drawn.items():
        low, high = np.percentile(values, [2.5, 97.5])
        got = metrics[name]
        assert got.ci95_high - got.ci95_low == pytest.approx(high - low, rel=0.15), name
        assert got.ci95_low == pytest.approx(low, abs=0.2 * (high - low)), name
    naive = 2 * 1.96 * np.nanstd(field) / np.sqrt(np.isfinite(field).sum()) / (2 * metrics["rms_m"].value)
    wide = metrics["rms_m"].ci95_high - metrics["rms_m"].ci95_low
    assert wide > 2 * naive, "instants of one trial are correlated: counting them as independent claims too much"


def test_the_interval_of_a_mean_is_students() -> None:
    x = np.random.default_rng(4).standard_normal(12) + 3
    m = Moments(12, x.sum(), 12.0, x @ x, x.sum(), 12.0)
    low, high = stats.t.interval(0.95, 11, loc=x.mean(), scale=stats.sem(x))
    assert interval_of_ratio(m) == pytest.approx((x.mean(), low, high), rel=1e-12)


@pytest.mark.parametrize("hits", [0, 3, 40])
def test_a_share_has_wilsons_interval(hits: int) -> None:
    m = Moments(40, hits, 40.0, hits, hits, 40.0)
    value, low, high = interval_of_ratio(m, share=True)
    assert value == hits / 40
    assert 0 <= low <= value <= high <= 1
    assert high - low > 0.05, "never an interval of no width"
    if 0 < hits < 40:
        exact = stats.binomtest(hits, 40).proportion_ci(0.95, method="wilson")
        assert (low, high) == pytest.approx((exact.low, exact.high), abs=0.02)


def test_paired_differences_use_the_common_draws() -> None:
    first, second = errors(5, bias=0.6, common=3.0), errors(6, common=3.0)
    found = next(c for c in run_of(first, second).comparisons() if c.metric == "rms_m" and not c.segment)
    a, b = np.sqrt(first.mean()), np.sqrt(second.mean())
    assert (found.difference, found.ratio) == pytest.approx((a - b, a / b), rel=1e-12)
    rng = np.random.default_rng(7)
    paired = [
        np.sqrt(first[:, i].mean()) - np.sqrt(second[:, i].mean())
        for i in (rng.integers(0, TRIALS, TRIALS) for _ in range(2_000))
    ]
    low, high = np.percentile(paired, [2.5, 97.5])
    assert found.high - found.low == pytest.approx(high - low, rel=0.15)
    same = next(c for c in run_of(first, first).comparisons() if not c.segment)
    assert (same.difference, same.verdict) == (0.0, "no_difference")
    assert (same.low, same.high) == pytest.approx((0.0, 0.0), abs=1e-6), "the same errors differ by nothing, surely"


def test_the_same_bytes_however_the_trials_are_cut(field: np.ndarray) -> None:
    one, five = run_of(field, errors(8), per_task=1), run_of(field, errors(8), per_task=5)
    assert one.metrics(0) == five.metrics(0)
    assert one.comparisons() == five.comparisons()
    for name, column in one.curves(1).items():
        assert column.tobytes() == five.curves(1)[name].tobytes(), name


def test_curves_hold_values_bounds_and_quantiles(field: np.ndarray) -> None:
    curves = run_of(field).curves(0)
    assert curves["rms_m"] == pytest.approx(np.sqrt(np.nanmean(field, axis=1)))
    n = np.isfinite(field).sum(axis=1)
    half = stats.t.ppf(0.975, TRIALS - 1) * np.nanstd(field, axis=1, ddof=1) / np.sqrt(n)
    assert curves["rms_m_high"] == pytest.approx(np.sqrt(np.nanmean(field, axis=1) + half), rel=1e-9)
    assert curves["chi_low"] == pytest.approx(stats.chi2.ppf(0.025, n) / n)
    assert curves["median_error_m"] == pytest.approx(np.nanmedian(np.sqrt(field), axis=1), rel=1e-5)


@pytest.mark.parametrize(("scale", "verdict"), [(1.0, "honest"), (1.5, "optimistic"), (0.6, "pessimistic")])
def test_consistency_in_words(scale: float, verdict: str) -> None:
    squares = scale * np.random.default_rng(9).standard_normal((INSTANTS, TRIALS)) ** 2
    (overall,) = (c for c in run_of(squares).consistency(0) if not c["segment"] and not c["target"])
    assert overall["verdict"] == verdict


@pytest.mark.parametrize("count", [1, 2, 5, 8, 11, 32])
def test_curves_have_the_same_bits_wherever_the_batches_are_cut(count: int) -> None:
    draw = np.random.default_rng(count)
    leaves = [Node(k, 1, draw.standard_normal((3, 2, 7)) * 10.0 ** draw.integers(-9, 9)) for k in range(count)]
    one_by_one: list[Node] = []
    for leaf in leaves:
        fold(one_by_one, leaf)
    # As many sums as the number of batches has binary digits that are one.
    assert len(one_by_one) == count.bit_count()
    for _ in range(20):
        cuts = sorted({0, count, *draw.integers(0, count + 1, 3).tolist()})
        whole: list[Node] = []
        for first, stop in pairwise(cuts):
            part: list[Node] = []
            for leaf in leaves[first:stop]:
                fold(part, leaf)
            for node in part:
                fold(whole, node)
        assert [(n.first, n.count) for n in whole] == [(n.first, n.count) for n in one_by_one]
        for got, expected in zip(whole, one_by_one, strict=True):
            assert got.curve.tobytes() == expected.curve.tobytes()
    total = sum(n.curve for n in one_by_one)
    np.testing.assert_allclose(total, sum(n.curve for n in leaves), rtol=1e-9)


def test_what_is_settled_early_is_what_is_computed_late(field: np.ndarray) -> None:
    early, late = run_of(field), run_of(field)
    early.settle()
    assert early.metrics(0) == late.metrics(0)
    for name, column in late.curves(0).items():
        np.testing.assert_array_equal(early.curves(0)[name], column)
    early.add([sums_of(scores_of(field, 0, 10), LEGS, batch=9)])
    assert early.metrics(0) != late.metrics(0), "what was settled is forgotten when trials are added"


def test_sums_survive_the_way_through_a_file(field: np.ndarray) -> None:
    sums = sums_of(scores_of(field, 0, BATCH), LEGS, keep_every=3)
    back = Sums.from_arrays(sums.to_arrays())
    assert back.layout == sums.layout
    assert back.samples[0].shape == (17, BATCH)
    assert np.array_equal(back.numerator, sums.numerator)


def test_quantiles_of_nothing() -> None:
    (found,) = quantiles_with_intervals(np.full((3, 4), np.nan, np.float32), [0.5])
    assert np.isnan(found[:3]).all()
    assert found[3] == 0


def test_tasks_are_whole_batches_of_half_a_second_or_an_eighth_of_a_short_run() -> None:
    assert tasks(300, 4) == [(0, 96), (96, 192), (192, 300)]
    assert {math.ceil((stop - first) / BATCH) for first, stop in tasks(10_000, 16)} == {15, 16}
    assert batches_per_task(100_000, 1_900, 2) == 8
    assert batches_per_task(1_000, 1_900, 1) == 4
    assert batches_per_task(1_000, 1_900, 1, cells=4) == 16
    assert batches_per_task(200, 1_000, 2) == 1
    assert batches_per_task(10, 10, 1) == 1
    assert [t for pair in tasks(1_000, 4) for t in batches(*pair)][-1] == (992, 1_000)
