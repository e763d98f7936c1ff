"""From what the filter reports to a Result, and to scores over trials."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model.bound import jump_bound
from algorithms.multiple_model.measurements import Plots
from algorithms.multiple_model.merging_cost import merging_operations
from algorithms.multiple_model.parameters import MotionParameters
from algorithms.multiple_model.states import UNUSUAL
from algorithms.multiple_model.tracker import Detector, Filtered, ModelSet, run_bank
from algorithms.result import Result
from algorithms.scores import Scores, Tally
from algorithms.spec import RunContext
from algorithms.toolbox.kernels.symmetric import unpack
from algorithms.toolbox.metrics.position_scores import score_positions
from algorithms.toolbox.motion.models import KINDS

Floats = NDArray[np.float64]

_AXES = (("east", 0), ("north", 1), ("up", 2))


def run_models(
    recording: Plots,
    parameters: MotionParameters,
    chosen: ModelSet,
    context: RunContext,
    detector: Detector | None = None,
) -> Result:
    """Filter a recording and return everything that the family's outputs declare."""
    found = run_bank(recording, parameters, chosen, context, lean=False, detector=detector)
    return result_of(recording, chosen, found)


def result_of(recording: Plots, chosen: ModelSet, found: Filtered) -> Result:
    """Gather the arrays of a full report."""
    report = found.report
    arrays: dict[str, NDArray[np.generic]] = {
        "row": recording.row,
        "target": recording.target,
        "time_s": recording.time_s,
        "state": report.state,
        "covariance": unpack(report.covariance, axis=1),
        "track": report.track,
        "status": report.status,
        "reason": report.reason,
        "nis": report.nis,
        "dof": found.prepared.dof,
        "mode_probability": report.probability,
        "model_state": report.model_state,
        "log_likelihood": report.likelihood,
        "distance": np.where(np.isfinite(report.distance), report.distance, np.nan),
        "gate": report.limit,
        "sigma_model": np.array([sigma for _, sigma in chosen.models]),
        "kind_model": np.array([KINDS.index(kind) for kind, _ in chosen.models]),
    }
    return Result(arrays, tuple(found.notes), found.settings)


def score_models(
    recording: Plots,
    parameters: MotionParameters,
    chosen: ModelSet,
    context: RunContext,
    detector: Detector | None = None,
) -> Scores:
    """Filter a block of simulated trials and score it against the truth."""
    found = run_bank(recording, parameters, chosen, context, lean=True, detector=detector)
    return scores_of(recording, parameters, chosen, found)


def scores_of(recording: Plots, parameters: MotionParameters, chosen: ModelSet, found: Filtered) -> Scores:
    """Score a lean report against the truth."""
    report = found.report
    scores = score_positions(
        time_s=recording.time_s,
        target=recording.target,
        targets=recording.targets,
        truth_m=recording.truth_m,
        truth_velocity_mps=recording.truth_velocity_mps,
        state=report.state,
        covariance=report.covariance,
        nis=report.nis,
        dof=np.broadcast_to(found.prepared.dof[:, None], report.nis.shape),
    )
    curves = {"rms_east_m", "rms_north_m", "rms_position_m"}
    tallies = [replace(t, curve=True) if t.metric in curves else t for t in scores.tallies]
    tallies += _velocity_tallies(recording, report.state)
    tallies += [
        Tally(
            f"mode_probability_{name}",
            "1",
            np.nan_to_num(report.probability[:, m]),
            np.isfinite(report.probability[:, m]).astype(float),
            curve=True,
            share=True,
        )
        for m, name in enumerate(chosen.names)
        if len(chosen.models) > 1
    ]
    merging = merging_operations(recording, chosen, report.probability)
    if merging is not None:
        known = np.isfinite(merging)
        tallies.append(Tally("merging_operations", "1", np.where(known, merging, 0.0), known.astype(float)))
    unusual = (report.status == UNUSUAL).astype(float)
    tallies.append(Tally("unusual_share", "1", unusual, np.ones(unusual.shape), share=True))
    tallies += _bound_tallies(recording, parameters, report.nis.shape)
    return replace(scores, tallies=tuple(tallies))


def _velocity_tallies(recording: Plots, state: Floats) -> list[Tally]:
    out = []
    for axis, a in _AXES:
        error = state[:, 3 * a + 1] - recording.truth_velocity_mps[:, a : a + 1]
        known = np.isfinite(error)
        out.append(
            Tally(
                f"rms_velocity_{axis}_mps",
                "m/s",
                np.where(known, error * error, 0.0),
                known.astype(float),
                root=True,
                curve=True,
                compared=axis == "up",
            )
        )
    return out


def _bound_tallies(recording: Plots, parameters: MotionParameters, shape: tuple[int, ...]) -> list[Tally]:
    """The bound of each axis as curves and metrics beside what it bounds; the same in every trial."""
    bound = jump_bound(recording, parameters)
    if bound is None:
        return []
    ones = np.ones(shape)
    out = []
    for axis, a in _AXES:
        for name, unit, variance in (
            (f"bound_{axis}_m", "m", bound[:, 3 * a]),
            (f"bound_velocity_{axis}_mps", "m/s", bound[:, 3 * a + 1]),
        ):
            known = np.isfinite(variance)
            numerator = np.where(known, variance, 0.0)[:, None] * ones
            out.append(Tally(name, unit, numerator, known[:, None] * ones, root=True, curve=True))
    return out
