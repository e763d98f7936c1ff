"""How fast plots are compared: our blocks, a plain NumPy loop and Stone Soup, in one process and one minute.

Run: uv run --group oracles python benchmarks/identification.py [--trials 1000000]

Times are those of the process (CPU), so that other work on the machine does not count; ratios matter.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import get_args

import numpy as np

from algorithms.identification.matching import matched, scores_of
from algorithms.identification.pairs import Side, pair_statistics
from algorithms.identification.parameters import DetectionParameters, PlotConversion
from algorithms.toolbox.association.assignment import most_likely_matching
from algorithms.toolbox.association.polar_fusion import fuse_polar
from algorithms.toolbox.frames.polar_conversion import cartesian_from_polar

SIGMA_R, SIGMA_B = 100.0, float(np.radians(1.0))
SITES = np.array([[0.0, 0.0], [30_000.0, 0.0]])
LOOPED = 2_000


def plots(targets: np.ndarray, trials: int, seed: int = 1) -> list[Side]:
    """Plots of all targets (n, 2) by both radars."""
    rng = np.random.default_rng(seed)
    out = []
    for site in SITES:
        offset = targets - site
        r = np.hypot(*offset.T)[:, None] + SIGMA_R * rng.standard_normal((len(targets), trials))
        b = np.arctan2(offset[:, 1], offset[:, 0])[:, None] + SIGMA_B * rng.standard_normal((len(targets), trials))
        out.append(Side(site, r, b, SIGMA_R, SIGMA_B))
    return out


def seconds(work: Callable[[], object]) -> float:
    """CPU time of one call."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def plain_loop(first: Side, second: Side, trials: int) -> None:
    """One pair after another, as one writes it down: matrices and a solve."""
    for k in range(trials):
        for i in range(2):
            for j in range(2):
                z, p = [], []
                for side, n in ((first, i), (second, j)):
                    r, b = side.range_m[n, k], side.angle_rad[n, k]
                    c, s = np.cos(b), np.sin(b)
                    turn = np.array([[c, -s], [s, c]])
                    z.append(side.site + r * np.array([c, s]))
                    p.append(turn @ np.diag([SIGMA_R**2, (r * SIGMA_B) ** 2]) @ turn.T)
                d = z[0] - z[1]
                float(d @ np.linalg.solve(p[0] + p[1], d))


def plain_minimum(range_m: np.ndarray, angle_rad: np.ndarray) -> None:
    """The same minimum pair by pair, as one writes it down; Stone Soup has no measure of this kind."""
    from scipy.optimize import least_squares

    for k in range(range_m.shape[1]):

        def residuals(place: np.ndarray, k: int = k) -> np.ndarray:
            offset = place - SITES
            turn = angle_rad[:, k] - np.arctan2(offset[:, 1], offset[:, 0])
            return np.concatenate(
                [
                    (range_m[:, k] - np.hypot(*offset.T)) / SIGMA_R,
                    (np.mod(turn + np.pi, 2 * np.pi) - np.pi) / SIGMA_B,
                ]
            )

        begin = range_m[0, k] * np.array([np.cos(angle_rad[0, k]), np.sin(angle_rad[0, k])])
        least_squares(residuals, begin, method="lm")


def many_radars() -> None:
    """Best sets of plots of three radars with the probabilities of all sets."""
    from algorithms.identification.pairs import points_of
    from algorithms.identification.tuples import Densities, Looked, pack
    from algorithms.toolbox.association.gate import gate_threshold

    for count, side in ((8, 20_000.0), (50, 100_000.0), (200, 1_500_000.0)):
        rng = np.random.default_rng(4)
        targets = 106_000 + side * (rng.random((count, 2)) - 0.5)
        sites = np.vstack([SITES, [15_000.0, 25_980.0]])
        points = []
        for site in sites:
            offset = targets - site
            r = np.hypot(*offset.T) + SIGMA_R * rng.standard_normal(count)
            b = np.arctan2(offset[:, 1], offset[:, 0]) + SIGMA_B * rng.standard_normal(count)
            found = points_of(Side(site, r[:, None], b[:, None], SIGMA_R, SIGMA_B), "mucm")
            points.append(type(found)(*(column[:, 0] for column in found)))
        looked = Looked(points, Densities(0.9, count / side**2, 2 / side**2, 3), gate_threshold(1e-4, 2))
        took = seconds(lambda looked=looked: pack(looked, probabilities=True))
        print(f"{count} plots of each of three radars in {side / 1000:.0f} km, sets with probabilities: {took:.3f} s")


def stone_soup(first: Side, second: Side, trials: int) -> float:
    """Seconds of Stone Soup's Mahalanobis measure on the same pairs, states made beforehand."""
    from stonesoup.measures import SquaredMahalanobis
    from stonesoup.types.state import GaussianState, State

    measure = SquaredMahalanobis()
    pairs = []
    for k in range(trials):
        for i in range(2):
            for j in range(2):
                (z1, p1), (z2, p2) = (_converted(s, n, k) for s, n in ((first, i), (second, j)))
                pairs.append((GaussianState(z1[:, None], p1 + p2), State(z2[:, None])))
    return seconds(lambda: [measure(a, b) for a, b in pairs])


def _converted(side: Side, n: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    z, p = cartesian_from_polar(side.range_m[n, k], side.angle_rad[n, k], SIGMA_R, SIGMA_B, "lin")
    return z + side.site, p


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=1_000_000)
    trials = parser.parse_args().trials
    sight = np.array([np.cos(np.pi / 4), np.sin(np.pi / 4)])
    two = 150_000 * sight + np.array([[0.0, 0.0], 1060 * sight])
    first, second = plots(two, trials)
    conversions = [c for c in get_args(PlotConversion) if c != "polar"]
    all_of_them = seconds(lambda: [pair_statistics(first, second, c) for c in conversions])
    one = seconds(lambda: pair_statistics(first, second, "lin"))
    loop = seconds(lambda: plain_loop(first, second, LOOPED)) / LOOPED * trials
    soup = stone_soup(first, second, LOOPED // 4) / (LOOPED // 4) * trials
    print(f"{trials:,} trials of two targets, four pairs each (CPU s)")
    print(f"  all {len(conversions)} conversions        {all_of_them:8.2f}")
    print(f"  lin alone                {one:8.2f}")
    print(f"  plain NumPy loop, lin    {loop:8.1f}   {loop / one:6.0f} times (from {LOOPED:,} trials)")
    print(f"  Stone Soup's measure     {soup:8.1f}   {soup / one:6.0f} times (conversion not counted)")
    count = 100_000
    a, b = plots(np.repeat(two[:1], 1, axis=0), count)
    r = np.stack([a.range_m[0], b.range_m[0]])
    angle = np.stack([a.angle_rad[0], b.angle_rad[0]])
    exact = seconds(lambda: fuse_polar(SITES, r, angle, np.full(2, SIGMA_R), np.full(2, SIGMA_B)))
    looped = 200
    one_by_one = seconds(lambda: plain_minimum(r[:, :looped], angle[:, :looped])) / looped * count
    print(f"exact polar likelihood of {count:,} pairs: {exact:.2f} s; SciPy's least squares pair by pair "
          f"{one_by_one:.0f} s, {one_by_one / exact:.0f} times (from {looped} pairs)")  # fmt: skip
    rng = np.random.default_rng(3)
    many = 106_000 + 1_500_000 * (rng.random((200, 2)) - 0.5)
    a, b = plots(many, 1)
    p = DetectionParameters(detection_probability=0.9, clutter_per_radar=5, region_area_m2=1.5e6**2)

    def posteriors() -> object:
        found = pair_statistics(a, b, "mucm")
        return matched(scores_of(found.cost, found.statistic, p), found.statistic, p)

    print(f"200 x 200 plots with probabilities: {seconds(posteriors):.2f} s")
    many_radars()
    found = pair_statistics(a, b, "mucm")
    score = scores_of(found.cost, found.statistic, p)[:, :, 0]
    ours = seconds(lambda: most_likely_matching(score))
    theirs = stone_soup_assignment(a, b)
    print(f"200 x 200 plots, assignment alone: {ours:.3f} s; Stone Soup {theirs:.2f} s, {theirs / ours:.0f} times")


def stone_soup_assignment(a: Side, b: Side) -> float:
    """Seconds of Stone Soup's global nearest neighbour on the same converted plots."""
    from datetime import datetime

    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, RandomWalk
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.detection import Detection
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track
    from stonesoup.updater.kalman import KalmanUpdater

    now = datetime(2026, 1, 1)
    tracks = set()
    detections = set()
    for n in range(a.range_m.shape[0]):
        z, p = _converted(a, n, 0)
        tracks.add(Track([GaussianState(z[:, None], p, timestamp=now)]))
        z, p = _converted(b, n, 0)
        model = LinearGaussian(2, (0, 1), p)
        detections.add(Detection(z[:, None], timestamp=now, measurement_model=model))
    still = CombinedLinearGaussianTransitionModel([RandomWalk(0.0), RandomWalk(0.0)])
    hypothesiser = DistanceHypothesiser(KalmanPredictor(still), KalmanUpdater(None), Mahalanobis(), 5)
    associator = GNNWith2DAssignment(hypothesiser)
    return seconds(lambda: associator.associate(tracks, detections, now))


if __name__ == "__main__":
    main()
