"""Recursive filters on the Dopplers, for comparison with the fit at every instant.

A pass is a batch of a few dozen numbers, so the fit costs little; the filters show what they lose to it.

Differences from the paper: it has no filter. The start is a likelihood fit of the first pairs.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from algorithms.forward_scatter import fit, outputs
from algorithms.forward_scatter.bound import position_bound
from algorithms.forward_scatter.conditions import conditions_of, pairs_of
from algorithms.forward_scatter.estimate import estimate, without_one_receiver
from algorithms.forward_scatter.likelihood import Problem
from algorithms.forward_scatter.lines import PLAIN
from algorithms.forward_scatter.measures import measure
from algorithms.forward_scatter.outputs import OUTPUTS
from algorithms.forward_scatter.parameters import ScatterParameters
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.forward_scatter.recursive import FORMS, filter_pass
from algorithms.forward_scatter.scoring import score_with
from algorithms.forward_scatter.sensitivity import calibration_tables
from algorithms.forward_scatter.tables import tabulate
from algorithms.recording import DopplerPairs
from algorithms.result import Result, Table
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter


class KalmanParameters(ScatterParameters):
    """Parameters of the recursive filters."""

    filter: Literal["ekf", "ukf", "static"] = parameter(
        "ekf",
        title="Filter",
        group="motion",
        choices={
            "ekf": "extended, of place and velocity",
            "ukf": "unscented, of place and velocity",
            "static": "iterated extended, of the crossing's parameters",
        },
    )
    """What is estimated, and how it is linearised."""
    start_pairs: int = parameter(13, title="Pairs for the start", unit="1", group="start", ge=3, le=500)
    """So many instants with Dopplers are fitted together first."""
    sigma_velocity_along_mps: float | None = parameter(
        150.0, title="Expected velocity along", unit="m/s", symbol="σ_vx", group="start", advanced=True, gt=0, le=1e5
    )
    """Weak prior of the velocity along the base line, for the start; null in the JSON form = none."""
    acceleration_density_m2ps3: float = parameter(
        0.0, title="Density of the acceleration", unit="m²/s³", symbol="q", group="motion", advanced=True, ge=0, le=1e6
    )
    """Of the white acceleration that disturbs place and velocity."""


def run(recording: DopplerPairs, parameters: KalmanParameters, context: RunContext) -> Result:
    """Filter every pass of a recording.

    Raises
    ------
    RecordingError
        No site, one that does not fit, or one Doppler only.
    """
    conditions = conditions_of(recording, parameters)
    if len(conditions.feet) < 2:
        pairs_of(conditions)
    along = parameters.sigma_velocity_along_mps

    def method(piece: Piece, arrays: Arrays) -> None:
        f = np.ascontiguousarray(piece.doppler.transpose(1, 0, 2))
        channels, epochs, lanes = f.shape
        problem = Problem(
            time=piece.time,
            feet=conditions.feet,
            wavelength=conditions.wavelength,
            sigma=conditions.sigma,
            altitude=conditions.altitude,
            a=conditions.a,
            prior_x=0.0 if along is None else 1.0 / along**2,
            prior_a=0.0,
        )
        there = np.cumsum(np.isfinite(f).any(axis=0), axis=0)
        begin = np.where(there[-1] >= parameters.start_pairs, np.argmax(there >= parameters.start_pairs, axis=0), -1)
        out = fit.fits(epochs, channels, lanes)
        for k in np.unique(begin[begin >= 0]).tolist():
            own = np.flatnonzero(begin == k)
            context.check_cancelled()
            part = fit.fits(epochs, channels, own.size)
            fit.fit_pass(np.ascontiguousarray(f[:, :, own]), problem, k, k + 1, 4, PLAIN, np.zeros((own.size, 6)), part)
            out.theta[k][:, own] = part.theta[k]
            out.covariance[k][:, :, own] = part.covariance[k]
            out.status[k, own] = part.status[k]
        lanes_of = np.arange(lanes)
        ready = (begin >= 0) & (out.status[begin, lanes_of] == fit.FITTED)
        start = np.ascontiguousarray(np.where(ready, out.theta[begin, :, lanes_of].T, np.nan))
        spread = np.ascontiguousarray(np.moveaxis(out.covariance[begin, :, :, lanes_of], 0, -1))
        begin = np.where(ready, begin, -1)
        filter_pass(
            problem, f, begin, start, spread, FORMS.index(parameters.filter),
            float(parameters.acceleration_density_m2ps3), out.theta, out.covariance, out.chi2, out.dof,
        )  # fmt: skip
        after = np.arange(epochs)[:, None] >= np.where(begin >= 0, begin, epochs)
        inside = (out.theta[:, 1] > 0) & (out.theta[:, 1] < conditions.a)
        status = np.where(after & inside, outputs.FITTED, np.where(after, outputs.INVALID, outputs.INSUFFICIENT))
        piece.put(arrays, "status", status)
        piece.put(arrays, "theta", np.where(after[:, None], out.theta, np.nan))
        piece.put(arrays, "theta_covariance", np.where(after[:, None, None], out.covariance, np.nan))
        piece.put(arrays, "chi2", out.chi2)
        piece.put(arrays, "dof", out.dof)
        piece.put(arrays, "used", np.isfinite(piece.doppler) & ready)
        without_one_receiver(piece, arrays)

    arrays, notes = estimate(recording, conditions, parameters, context, method)
    return Result(arrays, notes, conditions.settings)


def score(recording: DopplerPairs, parameters: KalmanParameters, context: RunContext) -> Scores:
    """Filter simulated passes and score them against the truth."""
    return score_with(run, recording, parameters, context)


def bound(recording: DopplerPairs, parameters: KalmanParameters) -> Floats | None:
    """Cramer-Rao bound of the rms horizontal error at each row, course unknown."""
    return position_bound(recording, conditions_of(recording, parameters), 4)


def _tables(recording: DopplerPairs, result: Result) -> dict[str, Table]:
    return tabulate(recording, result) | calibration_tables(run, KalmanParameters, recording, result)


ALGORITHM = Algorithm(
    name="forward_scatter_kalman",
    title="Recursive filters of the crossing",
    summary="Extended, unscented or iterated static Kalman filter, started from a fit of the first pairs; for "
    "comparison with the likelihood.",
    family="forward_scatter",
    takes=("doppler_pairs",),
    parameters=KalmanParameters,
    outputs=OUTPUTS,
    charts=(
        "base_plan",
        "crossing",
        "doppler_residuals",
        "sensitivity",
        "base_bound",
        "plan",
        "trials_crossing",
        "trials_range",
        "trials_crossing_sweep",
        "trials_paths",
    ),
    references=(Reference("barshalom2001", "sec. 10.3"),),
    run=run,
    tabulate=_tables,
    measure=measure,
    score=score,
    bound=bound,
)
