"""Time a thousand trials of a pass of 31 epochs. Run: uv run python benchmarks/forward_scatter.py

Prints processor time of one core, the best of some rounds: the closed form at every epoch, maximum likelihood at every
epoch, and both beside peers of one trial, as a ratio within the same process: NumPy's polyfit for the lines, SciPy's
least_squares (MINPACK, on the same model and derivatives, started at the answer before) for the likelihood.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares

from algorithms.forward_scatter import fit, freeze, sequence
from algorithms.forward_scatter.conditions import conditions_of, dopplers_of, pairs_of
from algorithms.forward_scatter.forward_scatter_ml import LikelihoodParameters
from algorithms.forward_scatter.likelihood import SCALE, Problem
from algorithms.forward_scatter.motion import doppler_rows
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.forward_scatter.simulation import simulate
from algorithms.warm_up import have_compiled

ROUNDS = 5


def seconds(work: Callable[[], object], rounds: int = ROUNDS) -> float:
    """Least processor time of some rounds; the first one, which loads the kernels, does not count."""
    work()
    found = []
    for _ in range(rounds):
        began = time.process_time()
        work()
        found.append(time.process_time() - began)
    return min(found)


def plain_lines(time_s: np.ndarray, f: np.ndarray, a: float, b: float, wavelength: float, window: int) -> float:
    """Distance by (14) at the end of one trial, f (31, 2), with NumPy's polyfit at every epoch."""
    kept = [np.nan, np.nan]
    s = np.nan
    for k in range(1, len(time_s)):
        t = time_s[max(0, k - window + 1) : k + 1]
        lines = [np.polyfit(t - t.mean(), f[max(0, k - window + 1) : k + 1, j], 1) for j in range(2)]
        tau = [t.mean() - line[1] / line[0] for line in lines]
        for j in range(2):
            if np.isfinite(kept[j]):
                tau[j] = kept[j]
            elif tau[j] <= time_s[k]:
                kept[j] = tau[j]
        omega = -(wavelength / b) * (lines[0][1] - lines[1][1])
        s = b / (omega * (tau[1] - tau[0]) + b / a)
    return float(s)


def peer_likelihood(f: np.ndarray, p: Problem, start: np.ndarray) -> np.ndarray:
    """theta of four unknowns at the last epoch, f (C, 31), fitted at every epoch from the fourth on by SciPy.

    Without the scan over starts: the first fit begins at `start`, each other at the answer before it.
    """
    theta = start.copy()
    for k in range(4, len(p.time)):
        time, measured = np.ascontiguousarray(p.time[: k + 1]), f[:, : k + 1]

        def residuals(x: np.ndarray, time: np.ndarray = time, measured: np.ndarray = measured) -> np.ndarray:
            value, _ = doppler_rows(time, np.append(x, 0.0), p.feet, p.wavelength, p.altitude)
            return np.append((value - measured).ravel() / p.sigma, np.sqrt(p.prior_x) * x[3])

        def derivatives(x: np.ndarray, time: np.ndarray = time) -> np.ndarray:
            _, rows = doppler_rows(time, np.append(x, 0.0), p.feet, p.wavelength, p.altitude)
            prior = np.array([[0.0, 0.0, 0.0, np.sqrt(p.prior_x)]])
            return np.concatenate([rows[:, :, :4].reshape(-1, 4) / p.sigma, prior])

        theta = least_squares(residuals, theta, derivatives, method="lm", x_scale=SCALE[:4], xtol=1e-10).x
    return theta


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=1000)
    trials = parser.parse_args().trials
    have_compiled()
    recording = simulate(PassParameters(), tuple(range(trials)), 1)
    conditions = conditions_of(recording, LikelihoodParameters())
    (pair,), _ = pairs_of(conditions)
    f = dopplers_of(pair, recording.doppler_hz)
    none = np.full_like(f, np.nan)
    options = sequence.Options(
        window=10, rule=freeze.RULE_A, delay=0, confirm=1, formula=14, omega=sequence.LINES, robust=0, curvature=False,
        from_start=False, sigma=conditions.sigma, sigma_rate=0.0, a=conditions.a, b=pair.b,
        wavelength=conditions.wavelength,
    )  # fmt: skip
    epochs = len(recording)

    def closed_form() -> sequence.Answers:
        out = sequence.answers(epochs, trials)
        sequence.follow(recording.time_s, f, none, options, out)
        return out

    channels_first = np.ascontiguousarray(recording.doppler_hz.transpose(1, 0, 2))
    problem = Problem(
        time=recording.time_s, feet=conditions.feet, wavelength=conditions.wavelength, sigma=conditions.sigma,
        altitude=0.0, a=conditions.a, prior_x=1 / 150**2, prior_a=1 / 1.5**2,
    )  # fmt: skip

    def likelihood(unknowns: int = fit.SWITCH) -> fit.Fits:
        out = fit.fits(epochs, 2, trials)
        fit.fit_pass(channels_first, problem, 0, epochs, unknowns, 0, np.zeros((trials, 6)), out)
        return out

    first = np.ascontiguousarray(channels_first[:, :, 0])
    four = likelihood(4).theta[:, :4, 0]

    def peer() -> np.ndarray:
        return peer_likelihood(first, problem, four[4])

    lines_s, ml_s = seconds(closed_form), seconds(likelihood, 3)
    plain_s = seconds(lambda: plain_lines(recording.time_s, f[:, :, 0], conditions.a, pair.b, 1.0, 10), 3)
    peer_s = seconds(peer, 3)
    own = closed_form().theta[-1, 1, 0]
    other = plain_lines(recording.time_s, f[:, :, 0], conditions.a, pair.b, 1.0, 10)
    print(f"{trials} trials of {epochs} epochs, processor time of one core")
    print(f"lines, every epoch               {1e3 * lines_s:8.1f} ms   (asked: 50 ms for 1000)")
    print(f"maximum likelihood, every epoch  {1e3 * ml_s:8.1f} ms   (asked: 5000 ms for 1000)")
    print(f"one trial of lines in NumPy      {1e3 * plain_s:8.1f} ms, {plain_s * trials / lines_s:.0f} times as long")
    print(f"both give the same distance      {own:.6f} and {other:.6f} m")
    print(f"one trial of fits by SciPy       {1e3 * peer_s:8.1f} ms, {peer_s * trials / ml_s:.0f} times as long")
    print(f"both give the same distance      {four[-1, 1]:.4f} and {peer()[1]:.4f} m, course unknown, no acceleration")


if __name__ == "__main__":
    main()
