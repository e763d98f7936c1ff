"""Time a thousand trials of a pass of 31 epochs. Run: uv run python benchmarks/forward_scatter.py

Prints processor time of one core, the best of some rounds: the closed form at every epoch, maximum likelihood at every
epoch, and both beside a plain NumPy statement of one trial, as a ratio within the same process.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from algorithms.forward_scatter import fit, freeze, sequence
from algorithms.forward_scatter.conditions import conditions_of, dopplers_of, pairs_of
from algorithms.forward_scatter.forward_scatter_ml import LikelihoodParameters
from algorithms.forward_scatter.likelihood import Problem
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

    def likelihood() -> fit.Fits:
        out = fit.fits(epochs, 2, trials)
        fit.fit_pass(channels_first, problem, 0, epochs, fit.SWITCH, 0, np.zeros((trials, 6)), out)
        return out

    lines_s, ml_s = seconds(closed_form), seconds(likelihood, 3)
    plain_s = seconds(lambda: plain_lines(recording.time_s, f[:, :, 0], conditions.a, pair.b, 1.0, 10), 3)
    own = closed_form().theta[-1, 1, 0]
    other = plain_lines(recording.time_s, f[:, :, 0], conditions.a, pair.b, 1.0, 10)
    print(f"{trials} trials of {epochs} epochs, processor time of one core")
    print(f"lines, every epoch               {1e3 * lines_s:8.1f} ms   (asked: 50 ms for 1000)")
    print(f"maximum likelihood, every epoch  {1e3 * ml_s:8.1f} ms   (asked: 5000 ms for 1000)")
    print(f"one trial of lines in NumPy      {1e3 * plain_s:8.1f} ms, {plain_s * trials / lines_s:.0f} times as long")
    print(f"both give the same distance      {own:.6f} and {other:.6f} m")


if __name__ == "__main__":
    main()
