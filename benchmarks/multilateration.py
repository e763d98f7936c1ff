"""Microseconds per mark of the range-difference filter with altitude, against plain NumPy and Stone Soup.

One run, one core, one process: ratios are the result, times depend on the machine.
Run: uv run --group oracles python benchmarks/multilateration.py
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"  # one core for everybody

import numpy as np

from algorithms.multilateration import lanes, rdfv, single_mark
from algorithms.multilateration.conditions import conditions_of
from algorithms.multilateration.filter_kernel import filter_marks
from algorithms.multilateration.parameters import FilterWithAltitudeParameters, Start
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.multilateration.tracker import setup_of, started
from algorithms.recording import ToaMarks
from algorithms.spec import LocalContext
from algorithms.toolbox.kernels import LANES
from tests.oracles.dense_filter import DenseFilter, sphere_altitude

C = 299_792_458.0
SD = (500.0, 50.0, 1.0)


def best(call: Callable[[], object], repeats: int) -> float:
    """Shortest time of several calls, s: the one that other programs disturbed least."""
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


def kernel_run(recording: ToaMarks, profile: str) -> Callable[[], lanes.Report]:
    """Prepare a call of the kernel alone: the filter over all marks of a block of trials, states and NIS kept."""
    start = Start(mode="truth", sd=SD)
    parameters = FilterWithAltitudeParameters(profile=profile, start=start)
    conditions = conditions_of(recording, parameters, profile=profile, with_altitude=True)
    form = "paper" if profile == "article" else "white"
    setup = setup_of(conditions, sigma_jerk_mps3=0.1, process_noise=form, altitude=True, robust=profile == "robust")
    trials = recording.toa_s.shape[2]
    blocks = [slice(i, min(i + LANES, trials)) for i in range(0, trials, LANES)]
    marks = [
        lanes.decoded_marks(
            np.repeat(recording.time_s[:, None], b.stop - b.start, axis=1),
            np.ascontiguousarray(recording.toa_s[:, :, b]),
            np.ascontiguousarray(recording.altitude_m[:, b]),
        )
        for b in blocks
    ]
    reports = [
        lanes.new_report(len(recording), 4, b.stop - b.start, covariance="position", receptions=False) for b in blocks
    ]

    now, work = lanes.new_now(4), lanes.new_rows(4)

    def call() -> lanes.Report:
        for b, m, report in zip(blocks, marks, reports, strict=True):
            track = started(
                start, recording, np.zeros(b.stop - b.start, int), np.arange(b.start, b.stop), LocalContext()
            )
            filter_marks(m, setup, track, now, work, report, 0, len(recording))
        return reports[0]

    return call


def plain_numpy(recording: ToaMarks, marks: int) -> Callable[[], np.ndarray]:
    """Prepare the dense filter of the tests: matrix products, solve, Joseph form."""
    assert recording.site is not None
    stations = recording.site.station_positions()
    start = started(Start(mode="truth", sd=SD), recording, np.arange(1), np.arange(1), LocalContext())

    def call() -> np.ndarray:
        prior = np.kron(np.eye(3), np.diag(np.square(SD)))
        f = DenseFilter(stations, 10e-9, 100.0, 0.1, "white", start.x[0, :, 0].copy(), prior)
        for k in range(marks):
            if k:
                f.predict(recording.time_s[k] - recording.time_s[k - 1])
            f.update(recording.toa_s[k, :, 0], recording.altitude_m[k, 0])
        return f.x

    return call


def stone_soup(recording: ToaMarks, marks: int, *, analytic: bool) -> Callable[[], np.ndarray]:
    """Prepare Stone Soup's extended Kalman filter on the same marks; its own numerical Jacobian, or an analytic one."""
    from stonesoup.base import Property
    from stonesoup.models.measurement.nonlinear import NonLinearGaussianMeasurement
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantAcceleration
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.types.array import CovarianceMatrix, StateVector
    from stonesoup.types.detection import Detection
    from stonesoup.types.hypothesis import SingleHypothesis
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import ExtendedKalmanUpdater

    assert recording.site is not None
    stations = recording.site.station_positions()

    class RangeDifferences(NonLinearGaussianMeasurement):
        stations = Property(np.ndarray, doc="(S, 3) m")

        @property
        def ndim_meas(self) -> int:
            return len(self.stations)

        def function(self, state, noise=False, **kwargs):
            p = np.asarray(state.state_vector, float)[[0, 3, 6], 0]
            r = np.linalg.norm(p - self.stations, axis=1)
            return StateVector([*(r[-1] - r[:-1]), sphere_altitude(p)[0]])

        def exact_jacobian(self, state, **kwargs):
            p = np.asarray(state.state_vector, float)[[0, 3, 6], 0]
            d = p - self.stations
            u = d / np.linalg.norm(d, axis=1)[:, None]
            h = np.zeros((len(self.stations), 9))
            h[:-1, [0, 3, 6]] = u[-1] - u[:-1]
            h[-1, [0, 3, 6]] = sphere_altitude(p)[1]
            return h

    if analytic:
        RangeDifferences.jacobian = RangeDifferences.exact_jacobian
    n = len(stations) - 1
    noise = np.zeros((n + 1, n + 1))
    noise[:n, :n] = (C * 10e-9) ** 2 * (np.eye(n) + np.ones((n, n)))
    noise[n, n] = 100.0**2
    measurement = RangeDifferences(
        ndim_state=9, mapping=(0, 3, 6), noise_covar=CovarianceMatrix(noise), stations=stations
    )
    transition = CombinedLinearGaussianTransitionModel([ConstantAcceleration(0.01)] * 3)
    predictor, updater = KalmanPredictor(transition), ExtendedKalmanUpdater(measurement)
    zero = datetime(2026, 1, 1, tzinfo=UTC)
    detections = []
    for k in range(marks):
        toa = C * recording.toa_s[k, :, 0]
        z = StateVector([*(toa[-1] - toa[:-1]), recording.altitude_m[k, 0]])
        when = zero + timedelta(seconds=float(recording.time_s[k]))
        detections.append(Detection(z, timestamp=when, measurement_model=measurement))
    start = started(Start(mode="truth", sd=SD), recording, np.arange(1), np.arange(1), LocalContext())
    prior = np.kron(np.eye(3), np.diag(np.square(SD)))

    def call() -> np.ndarray:
        state = GaussianState(StateVector(start.x[0, :, 0]), CovarianceMatrix(prior), timestamp=zero)
        for detection in detections:
            prediction = predictor.predict(state, timestamp=detection.timestamp)
            state = updater.update(SingleHypothesis(prediction, detection))
        return np.asarray(state.state_vector, float)[:, 0]

    return call


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    trials = options.trials
    recording = simulate(CircuitParameters(), tuple(range(trials)), 1)
    one = simulate(CircuitParameters(), (0,), 1)
    marks = len(one)
    few = 150
    rows: list[tuple[str, float]] = []

    soup = best(stone_soup(one, few, analytic=False), 3) / few
    rows.append(("Stone Soup extended Kalman filter as it comes", soup))
    rows.append(("the same with an analytic Jacobian", best(stone_soup(one, few, analytic=True), 3) / few))
    rows.append(("plain NumPy, Joseph form", best(plain_numpy(one, few), options.repeats) / few))
    # Agreement first: a fast filter that answers something else is no filter.
    reference = plain_numpy(one, few)()
    ours = rdfv.run(
        one.take(np.arange(few)),
        rdfv.RdfvParameters(profile="article", process_noise="white", start=Start(mode="truth", sd=SD)),
        LocalContext(),
    ).arrays["state"][-1, :, 0]
    soup_state = stone_soup(one, few, analytic=True)()
    print(
        f"largest difference of the positions after {few} marks: to plain NumPy "
        f"{np.abs(ours - reference)[::3].max():.1e} m, to Stone Soup {np.abs(ours - soup_state)[::3].max():.1e} m"
    )

    for profile in ("article", "robust"):
        call = kernel_run(one, profile)
        call()
        rows.append((f"rdfv kernel, one recording, {profile}", best(call, options.repeats) / marks))
    for profile in ("article", "robust"):
        call = kernel_run(recording, profile)
        call()
        rows.append(
            (f"rdfv kernel, blocks of {LANES}, per trial, {profile}", best(call, options.repeats) / marks / trials)
        )
    whole = lambda: rdfv.run(one, rdfv.RdfvParameters(), LocalContext())  # noqa: E731
    rows.append(("rdfv, one recording, all outputs", best(whole, options.repeats) / marks))
    fixes = lambda: single_mark.run(one, single_mark.SingleMarkParameters(), LocalContext())  # noqa: E731
    fixes()
    rows.append(("single_mark, one recording, all outputs", best(fixes, options.repeats) / marks))

    print(f"{'':52s} {'us per mark':>12s} {'Stone Soup /':>13s}")
    for name, seconds in rows:
        print(f"{name:52s} {seconds * 1e6:12.2f} {soup / seconds:13.0f}")


if __name__ == "__main__":
    main()
