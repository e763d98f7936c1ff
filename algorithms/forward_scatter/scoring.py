"""Score the crossings and places of a block of simulated passes.

An instant without an estimate (invalid, insufficient) counts in `answered_share` and, as an error beyond 5 km, in
`crossing_distance_over_5km_share`; it has no error of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter.bound import bounds_of_crossing
from algorithms.forward_scatter.conditions import conditions_of
from algorithms.forward_scatter.truth import true_crossings
from algorithms.recording import DopplerPairs
from algorithms.result import Result
from algorithms.scores import Sample, Scores, Tally
from algorithms.spec import RunContext
from algorithms.toolbox.frames.forward_scatter import ScatterFrame

Floats = NDArray[np.float64]

FAR_M = 5_000.0


BOUNDS = {3: "crossing_distance_bound_3_m", 4: "crossing_distance_bound_4_m"}
"""The Cramer-Rao bounds of s with the course known and unknown, of the flight that is simulated."""


def _paths(recording: DopplerPairs, frame: ScatterFrame, state: Floats) -> tuple[Sample, ...]:
    """Estimated and true places along and across the base line, to be drawn trial by trial."""
    estimated = frame.from_enu(np.moveaxis(state[:, ::3], 1, -1))
    true = np.broadcast_to(frame.from_enu(recording.truth_m)[:, None], estimated.shape)
    return tuple(
        Sample(f"{which}_{axis}_m", "m", places[:, :, i].astype(np.float32), kind="drawn")
        for which, places in (("place", estimated), ("true_place", true))
        for i, axis in enumerate(("along", "across"))
    )


def score_with(
    run: Callable[[DopplerPairs, Any, RunContext], Result],
    recording: DopplerPairs,
    parameters: Any,
    context: RunContext,
    sigma_azimuth_rad: float | None = None,
) -> Scores:
    """Run a method on simulated passes and score it; the bounds know azimuths where their error is given."""
    arrays = run(recording, parameters, context).arrays
    conditions = conditions_of(recording, parameters)
    frame = conditions.frame
    crossing = true_crossings(recording, frame)
    theta = np.asarray(arrays["theta"], float)
    state = np.asarray(arrays["state"], float)
    covariance = np.asarray(arrays["theta_covariance"], float)
    answered = np.isfinite(state[:, 0])
    truth = recording.truth_m
    east, north = state[:, 0] - truth[:, 0, None], state[:, 3] - truth[:, 1, None]
    horizontal = east * east + north * north
    east_rate = state[:, 1] - recording.truth_velocity_mps[:, 0, None]
    north_rate = state[:, 4] - recording.truth_velocity_mps[:, 1, None]
    speed = east_rate * east_rate + north_rate * north_rate
    # Across the base line: what the paper draws as the error of y.
    across = np.square(frame.cosine * north - frame.sine * east)
    plane = np.asarray(arrays["covariance"], float)
    claim = plane[:, 0, 0] + plane[:, 1, 1]
    s_error = np.where(answered, theta[:, 1] - crossing[:, 1, None], np.nan)
    tau_error = np.where(answered, theta[:, 0] - crossing[:, 0, None], np.nan)
    known = np.isfinite(s_error)
    far = ~known | (np.abs(s_error) > FAR_M)
    sd = np.sqrt(np.maximum(covariance[:, 1, 1], 0.0))
    told = known & (sd > 0)
    ends = np.asarray(arrays["distance_interval_m"], float)
    with np.errstate(invalid="ignore"):
        covered = told & (ends[:, 0] <= crossing[:, 1, None]) & (crossing[:, 1, None] <= ends[:, 1])
    dof = np.asarray(arrays["dof"], float)
    chi2 = np.asarray(arrays["chi2"], np.float64)
    tested = np.isfinite(chi2) & (dof > 0)

    def total(values: Floats, where: NDArray[np.bool_]) -> tuple[Floats, Floats]:
        there = where & np.isfinite(values)
        return np.where(there, values, 0.0), there.astype(float)

    one = np.ones(answered.shape)
    begun = np.logical_or.accumulate(answered, axis=0)
    squares = total(s_error * s_error, known)
    normalised = total(s_error * s_error / np.where(told, sd * sd, 1.0), told)
    tallies: tuple[Tally, ...] = (
        Tally("rms_horizontal_m", "m", *total(horizontal, answered), root=True, curve=True, compared=True),
        Tally("claimed_horizontal_m", "m", *total(claim, answered), root=True, curve=True),
        Tally("rms_velocity_mps", "m/s", *total(speed, answered), root=True, compared=True),
        Tally("rms_across_m", "m", *total(across, answered), root=True, curve=True),
        Tally("crossing_distance_mean_m", "m", *total(s_error, known), curve=True),
        Tally("crossing_distance_sd_m", "m", *squares, root=True, curve=True, spread=True),
        Tally("crossing_distance_rms_m", "m", *squares, root=True, curve=True, compared=True),
        Tally("crossing_distance_claimed_m", "m", *total(sd * sd, told), root=True, curve=True),
        Tally(
            "crossing_distance_coverage_share", "1", covered.astype(float), told.astype(float), curve=True, share=True
        ),
        Tally("crossing_distance_over_5km_share", "1", far.astype(float), one, curve=True, share=True),
        Tally("crossing_time_rms_s", "s", *total(tau_error * tau_error, known), root=True, curve=True),
        Tally("nees", "1", *normalised, curve=True, chi_square=True),
        Tally("chi2_per_dof", "1", np.where(tested, chi2, 0.0), np.where(tested, dof, 0.0), curve=True),
        Tally("answered_share", "1", answered.astype(float), one, curve=True, share=True),
        Tally("lost_share", "1", (begun & ~answered).astype(float), begun.astype(float), curve=True, share=True),
    )
    for unknowns, name in BOUNDS.items():
        limit = bounds_of_crossing(recording, conditions, unknowns, sigma_azimuth_rad)[:, 1, None] ** 2
        tallies += (Tally(name, "m", *total(limit * one, known), root=True, curve=True),)
    samples = (
        Sample("crossing_distance_m", "m", np.abs(s_error).astype(np.float32), curve=True),
        Sample("crossing_distance_error_m", "m", s_error.astype(np.float32), curve=True, kind="signed"),
        *_paths(recording, frame, state),
    )
    return Scores(tallies, samples, recording.time_s, recording.target, recording.targets)
