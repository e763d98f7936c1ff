"""How fast plots become tracks: our trackers over numbers of aircraft, and Stone Soup's associations on the same plots.

Run: uv run --group oracles python benchmarks/plot_tracking.py [--scans 20]

As many false plots as aircraft, in a disc of 400 km, detection probability 0.95, largest speed 350 m/s. Times are those
of the process (CPU), so that other work on the machine does not count; what the association takes (assignment and joint
hypotheses, whose number is a matter of how dense the aircraft are) stands apart from the rest. Stone Soup's trackers
are given their tracks (its initiators are another matter) and a Kalman filter of constant velocity; ours find theirs
and run two models.
"""

from __future__ import annotations

import argparse
import datetime
import itertools
import time
from typing import Any

import numpy as np

from algorithms.plot_tracking import curvature_scan, curvature_tracker, imm_scan, imm_tracker
from algorithms.plot_tracking.imm_filter import Motion
from algorithms.plot_tracking.imm_rules import Clutter, Identity, Rules, gate_radius
from algorithms.plot_tracking.imm_scan import advance
from algorithms.plot_tracking.imm_tracks import ImmTracks
from algorithms.plot_tracking.parameters import CurvatureParameters, ImmParameters
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.scenario import simulate_aircraft
from algorithms.plot_tracking.scenario_parameters import AircraftScans
from algorithms.spec import LocalContext
from algorithms.toolbox.scenario.targets import Target
from algorithms.toolbox.scenario.trajectory import Segment

RADIUS_M, PERIOD_S = 400e3, 10.0
AIRCRAFT = (125, 250, 500, 1000)
"""Each twice the one before."""
START = datetime.datetime(2026, 1, 1)


def traffic(aircraft: int, scans: int, seed: int = 1) -> Any:
    """A recording of aircraft on straight lines and in turns, uniform over the disc."""
    rng = np.random.default_rng(seed)
    targets = []
    for _ in range(aircraft):
        radius, angle = RADIUS_M * np.sqrt(rng.random()), 2 * np.pi * rng.random()
        rate = float(rng.uniform(-2, 2)) if rng.random() < 0.2 else 0.0
        segment = Segment(duration_s=(scans + 1) * PERIOD_S, turn_rate_deg_s=rate)
        targets.append(
            Target(
                east_m=radius * np.sin(angle), north_m=radius * np.cos(angle), altitude_m=9_000,
                heading_deg=float(rng.uniform(0, 360)), speed_mps=float(rng.uniform(120, 280)), segments=(segment,),
            )
        )  # fmt: skip
    scenario = AircraftScans(
        targets=tuple(targets), period_s=PERIOD_S, duration_s=(scans - 1) * PERIOD_S, false_plots=float(aircraft),
        clutter_radius_m=RADIUS_M, detection_probability=0.95,
    )  # fmt: skip
    made = simulate_aircraft(scenario, (0,), seed)
    return made.take(np.flatnonzero(np.isfinite(made.range_m[:, 0])))


ASSOCIATION = ("most_pairs_at_least_cost", "joint_probabilities")
"""What is timed apart: who has which plot, and the sum over all ways to say so. Everything else is to grow evenly."""


class Apart:
    """Processor time of the association inside the trackers, s."""

    def __init__(self) -> None:
        self.taken = 0.0
        for module, name in itertools.product((imm_scan, curvature_scan), ASSOCIATION):
            if hasattr(module, name):
                setattr(module, name, self._timed(getattr(module, name)))

    def _timed(self, function: Any) -> Any:
        def timed(*arguments: Any) -> Any:
            begin = time.process_time()
            out = function(*arguments)
            self.taken += time.process_time() - begin
            return out

        return timed


def ours(recording: Any, scans: int, apart: Apart) -> list[tuple[float, float]]:
    """Milliseconds a scan, association and the rest: nearest, joint, the paper's."""
    out = []
    for tracker, parameters in (
        (imm_tracker, ImmParameters(association="nearest")),
        (imm_tracker, ImmParameters(association="joint")),
        (curvature_tracker, CurvatureParameters(performance="airliner")),
    ):
        best = (np.inf, np.inf)
        for _ in range(3):
            apart.taken = 0.0
            begin = time.process_time()
            tracker.run(recording, parameters, LocalContext())  # type: ignore[arg-type]
            whole = time.process_time() - begin
            best = min(best, (apart.taken, whole - apart.taken), key=sum)
        out.append((1000 * best[0] / scans, 1000 * best[1] / scans))
    return out


def stone_soup(truth: np.ndarray, plots: np.ndarray, clutter_density: float, joint: bool) -> float:
    """Milliseconds for one scan: associate plots (P, 2) with tracks at truth (T, 4: x vx y vy), and update."""
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.dataassociator.probability import JPDA
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.measurement.linear import LinearGaussian
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.detection import Detection
    from stonesoup.types.state import GaussianState
    from stonesoup.types.track import Track
    from stonesoup.updater.kalman import KalmanUpdater

    transition = CombinedLinearGaussianTransitionModel([ConstantVelocity(10.0), ConstantVelocity(10.0)])
    measurement = LinearGaussian(4, [0, 2], np.diag([200.0**2, 200.0**2]))
    predictor, updater = KalmanPredictor(transition), KalmanUpdater(measurement)
    covariance = np.diag([150.0, 15.0, 150.0, 15.0]) ** 2
    tracks = {Track([GaussianState(state, covariance, START)]) for state in truth}
    later = START + datetime.timedelta(seconds=PERIOD_S)
    detections = {Detection(z, timestamp=later, measurement_model=measurement) for z in plots}
    if joint:
        associator: Any = JPDA(PDAHypothesiser(predictor, updater, clutter_density, 0.95, 0.998))
    else:
        associator = GNNWith2DAssignment(DistanceHypothesiser(predictor, updater, Mahalanobis(), missed_distance=3.5))
    begin = time.process_time()
    associator.associate(tracks, detections, later)
    return 1000 * (time.process_time() - begin)


def cluster(aircraft: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Aircraft 400 m apart on one course: states now, and their plots a period later."""
    truth = np.zeros((aircraft, 4))
    truth[:, 0], truth[:, 1], truth[:, 2] = 60e3, 200.0, 400.0 * np.arange(aircraft)
    plots = truth[:, [0, 2]] + PERIOD_S * truth[:, [1, 3]] + 200.0 * rng.standard_normal((aircraft, 2))
    return truth, plots


def our_cluster(truth: np.ndarray, plots: np.ndarray) -> float:
    """Milliseconds of our joint association, prediction and update included."""
    count = len(truth)
    motion = Motion(PERIOD_S, 0.8, 3.0, 0.007, 0.05, (0.95, 0.9))
    rules = Rules(motion, 200.0, 0.0023, 50.0, 350.0, gate_radius(0.998), 2.0, True, 0.95, 10, 4, 8)

    def scan(z: np.ndarray, at: float) -> Scan:
        lanes = np.zeros(len(z), np.int64)
        rho, theta = np.hypot(*z.T), np.arctan2(z[:, 0], z[:, 1])
        order = np.argsort(rho)
        return Scan(at, lanes, order, np.full(len(z), at), rho[order], theta[order])

    first = scan(truth[:, [0, 2]], 0.0)
    order = first.position
    tracks = ImmTracks.starting_from(
        first, np.arange(count), truth[order][:, [0, 2]], np.tile(np.eye(2) * 4e4, (count, 1, 1)), motion
    )
    tracks.bank.x[:, :, :4] = truth[order][:, None]
    tracks.bank.p[:] = np.diag([150.0, 15.0, 150.0, 15.0, 0.05]) ** 2
    tracks.plots[:], tracks.confirmed[:], tracks.number[:] = 10, True, np.arange(1, count + 1)
    none = np.full(count, -1)
    clutter = Clutter(np.array([np.pi * RADIUS_M**2]), np.zeros(1))
    begin = time.process_time()
    advance(tracks, scan(plots, PERIOD_S), Identity(none, none, np.full(count, np.nan)), rules, clutter, np.array([99]))
    return 1000 * (time.process_time() - begin)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scans", type=int, default=20)
    parser.add_argument("--peer", type=int, default=50, help="aircraft of the comparison with Stone Soup")
    options = parser.parse_args()
    print("ms a scan: whole = association + rest")
    print(f"{'aircraft':>8}" + "".join(f"{name:>24}" for name in ("nearest", "joint", "paper")))
    apart, before = Apart(), []
    for aircraft in AIRCRAFT:
        times = ours(traffic(aircraft, options.scans), options.scans, apart)
        cells = "".join(f"{f'{sum(t):.1f} = {t[0]:.1f} + {t[1]:.1f}':>24}" for t in times)
        print(f"{aircraft:8d}{cells}", flush=True)
        if before:
            grown = "".join(
                f"{f'x {sum(t) / sum(b):.2f}, rest x {t[1] / b[1]:.2f}':>24}"
                for t, b in zip(times, before, strict=True)
            )
            even = 2 * np.log(aircraft) / np.log(aircraft / 2)
            print(f"{'':8}{grown}   (n log n: x {even:.2f})", flush=True)
        before = times
    rng = np.random.default_rng(3)
    states = np.zeros((options.peer, 4))
    states[:, [0, 2]] = rng.uniform(-RADIUS_M, RADIUS_M, (options.peer, 2))
    states[:, [1, 3]] = rng.uniform(-200, 200, (options.peer, 2))
    real = states[:, [0, 2]] + PERIOD_S * states[:, [1, 3]] + 200 * rng.standard_normal((options.peer, 2))
    plots = np.concatenate([real, rng.uniform(-RADIUS_M, RADIUS_M, (options.peer, 2))])
    density = options.peer / (4 * RADIUS_M**2)
    # Its joint association lists all joint hypotheses: with 50 aircraft it does not end within minutes.
    took = stone_soup(states, plots, density, False)
    print(f"Stone Soup nearest, {options.peer} aircraft, association alone: {took:.0f} ms a scan", flush=True)
    for aircraft in (3, 4, 5, 6):
        truth, measured = cluster(aircraft, rng)
        mine = min(our_cluster(truth, measured) for _ in range(3))
        theirs = stone_soup(truth, measured, 1e-12, True)
        print(
            f"{aircraft} aircraft in one cluster: {mine:.1f} ms, Stone Soup {theirs:.0f} ms, {theirs / mine:.0f} times"
        )


if __name__ == "__main__":
    main()
