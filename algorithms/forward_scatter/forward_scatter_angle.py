"""One receiver with Doppler and azimuth: where the target crosses, from the slope at the crossing and the angle's rate.

Doppler alone of one receiver cannot tell the distance from one end of the base line from that to the other; the
azimuth can. With elevations the height is estimated as well. With several Dopplers the first one is used.

Differences from the paper: a regression of tan(azimuth) through the crossing time in place of (20), which is singular
there; (20) by choice, outside that zone.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np

from algorithms.errors import RecordingError
from algorithms.forward_scatter import angle_sequence, outputs
from algorithms.forward_scatter.conditions import conditions_of, others_of
from algorithms.forward_scatter.estimate import estimate
from algorithms.forward_scatter.freeze import RULES
from algorithms.forward_scatter.lines import ROBUST
from algorithms.forward_scatter.measures import measure
from algorithms.forward_scatter.motion import UNKNOWNS
from algorithms.forward_scatter.outputs import OUTPUTS
from algorithms.forward_scatter.parameters import FreezeParameters, ScatterParameters
from algorithms.forward_scatter.piece import Arrays, Piece
from algorithms.forward_scatter.scoring import score_with
from algorithms.forward_scatter.sensitivity import calibration_tables
from algorithms.forward_scatter.tables import tabulate
from algorithms.recording import DopplerPairs
from algorithms.result import Note, Output, Result, Table
from algorithms.scores import Scores
from algorithms.site import Site
from algorithms.spec import Algorithm, Reference, RunContext, parameter

SIGMA_AZIMUTH_DEG = 0.5

_STATUS = np.array(
    [
        outputs.INSUFFICIENT,
        outputs.NO_LINE,
        outputs.NO_CROSSING,
        outputs.INVALID,
        outputs.EXTRAPOLATED,
        outputs.CROSSED,
    ]
)


class AngleParameters(ScatterParameters, FreezeParameters):
    """Parameters of the method with one receiver and an angle."""

    sigma_azimuth_deg: float = parameter(SIGMA_AZIMUTH_DEG, title="Azimuth error", unit="°", symbol="σ_φ", gt=0, le=45)
    """Standard deviation of one azimuth; only the predicted errors depend on it."""
    omega: Literal["slope", "ends", "regression"] = parameter(
        "regression",
        title="Angular velocity from",
        group="motion",
        choices={
            "slope": "the slope of the window's azimuths",
            "ends": "the window's azimuth over the time since the crossing (20)",
            "regression": "all azimuths, through the crossing",
        },
    )
    """The regression is the best; (20) is not used near the crossing."""
    gamma: Literal["slope", "end"] = parameter(
        "slope",
        title="Slope at the crossing from",
        group="motion",
        advanced=True,
        choices={"slope": "the window at the crossing", "end": "the window's Doppler over the time since the crossing"},
    )
    """How fast the Doppler falls at the crossing."""
    zone_windows: float = parameter(
        0.5, title="Zone without (20)", unit="1", group="motion", advanced=True, ge=0, le=10
    )
    """Within so many windows of the crossing (20) is singular and its last value is held; 0 = never held."""
    height_corrected: bool = parameter(False, title="Allow for the height", group="motion", advanced=True)
    """Where elevations are measured: find the distance again with the height known."""


def run(recording: DopplerPairs, parameters: AngleParameters, context: RunContext) -> Result:
    """Follow every pass of a recording by its first Doppler and its azimuths.

    Raises
    ------
    RecordingError
        No site, or no azimuths at all.
    """
    notes: tuple[Note, ...] = ()
    if len(recording.channels) > 1:
        notes = (Note("first_doppler", "Of several Dopplers the first one is used, with its receiver."),)
    one = first_channel(recording)
    conditions = conditions_of(one, parameters)
    conditions = replace(conditions, settings=conditions.settings | others_of(parameters))
    if one.azimuth_rad.size and not np.isfinite(one.azimuth_rad).any():
        raise RecordingError(
            "the recording has no azimuths",
            pointer="/recording_id",
            remedy="use forward_scatter_ml with two Dopplers, or read a file with the column azimuth_deg",
            code="azimuth_missing",
        )

    def method(piece: Piece, arrays: Arrays) -> None:
        options = angle_sequence.AngleOptions(
            window=parameters.window,
            rule=RULES.index(parameters.freeze_rule),
            delay=parameters.freeze_delay,
            confirm=parameters.confirm,
            omega=("slope", "ends", "regression").index(parameters.omega),
            gamma=("slope", "end").index(parameters.gamma),
            robust=ROBUST.index(parameters.robust),
            with_height=parameters.height_corrected,
            sigma=conditions.sigma,
            sigma_rate=float(parameters.sigma_doppler_rate_hz_s or 0.0),
            sigma_phi=float(np.radians(parameters.sigma_azimuth_deg)),
            zone=parameters.zone_windows * parameters.window * piece.interval,
            a=conditions.a,
            wavelength=conditions.wavelength,
        )
        out = angle_sequence.angle_answers(piece.time.size, piece.lanes.size)
        rate = np.ascontiguousarray(piece.rate[:, :1])
        angle_sequence.follow_angle(piece.time, piece.doppler, rate, piece.azimuth, piece.elevation, options, out)
        theta = np.zeros((piece.time.size, UNKNOWNS, piece.lanes.size))
        theta[:, :3] = out.theta
        spread = np.zeros((piece.time.size, UNKNOWNS, UNKNOWNS, piece.lanes.size))
        spread[:, :3, :3] = out.covariance
        piece.put(arrays, "status", _STATUS[out.status])
        piece.put(arrays, "theta", theta)
        piece.put(arrays, "theta_covariance", spread)
        piece.put(arrays, "used", np.isfinite(piece.doppler))
        for name, values in (
            ("gamma_hz_s", out.gamma),
            ("omega_rad_s", out.omega),
            ("height_m", out.height),
            ("azimuth_rad", piece.azimuth),
        ):
            piece.put(arrays, name, values)

    arrays, more = estimate(
        one, conditions, parameters, context, method, extra=("gamma_hz_s", "omega_rad_s", "height_m", "azimuth_rad")
    )
    # What is estimated of the height goes into the state; the other methods only know what they are told.
    height = np.asarray(arrays["height_m"], float)
    state = np.asarray(arrays["state"], float)
    known = np.isfinite(height) & np.isfinite(state[:, 6])
    state[:, 6] = np.where(known, height + conditions.frame.origin_m[2], state[:, 6])
    # The tables speak of all columns of the file.
    others = len(recording.channels) - 1
    arrays["used"] = np.pad(arrays["used"], ((0, 0), (0, others), (0, 0)))
    arrays["residual_hz"] = np.pad(arrays["residual_hz"], ((0, 0), (0, others), (0, 0)), constant_values=np.nan)
    return Result(arrays, (*notes, *more), conditions.settings)


def first_channel(recording: DopplerPairs) -> DopplerPairs:
    """Return the recording with its first Doppler alone, and the site with that transmitter and receiver."""
    if len(recording.channels) == 1:
        return recording
    site = recording.site
    first: Site | None = None
    if site is not None:
        first = site.model_copy(update={"transmitters": site.transmitters[:1], "receivers": site.receivers[:1]})
    return replace(recording, doppler_hz=recording.doppler_hz[:, :1], channels=("1",), site=first)


def score(recording: DopplerPairs, parameters: AngleParameters, context: RunContext) -> Scores:
    """Follow simulated passes and score them against the truth."""
    # The site's first receiver alone: bounds and crossings are those of what the method sees.
    return score_with(
        run, first_channel(recording), parameters, context, float(np.radians(parameters.sigma_azimuth_deg))
    )


def _tables(recording: DopplerPairs, result: Result) -> dict[str, Table]:
    return tabulate(recording, result) | calibration_tables(run, AngleParameters, first_channel(recording), result)


ALGORITHM = Algorithm(
    name="forward_scatter_angle",
    title="One receiver with azimuth",
    summary="Slope of the Doppler at the crossing and rate of the azimuth give distance and velocity; an elevation "
    "gives the height.",
    family="forward_scatter",
    takes=("doppler_pairs",),
    parameters=AngleParameters,
    outputs=(
        *OUTPUTS,
        Output("gamma_hz_s", ("mark", "trial"), "Hz/s", "slope of the Doppler at the crossing"),
        Output("omega_rad_s", ("mark", "trial"), "rad/s", "angular velocity seen from the receiver"),
        Output("height_m", ("mark", "trial"), "m", "height above the receiver, from elevations"),
        Output("azimuth_rad", ("mark", "trial"), "rad", "azimuth from the base line, positive to its left"),
    ),
    charts=(
        "base_plan",
        "crossing",
        "angular_velocity",
        "azimuth",
        "doppler_residuals",
        "sensitivity",
        "base_bound",
        "plan",
        "trials_crossing",
        "trials_range",
        "trials_crossing_sweep",
        "trials_paths",
    ),
    references=(Reference("scatter2014", "eqs. (19), (20)"),),
    run=run,
    tabulate=_tables,
    measure=measure,
    score=score,
)
