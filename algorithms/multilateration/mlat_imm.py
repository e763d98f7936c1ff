"""The recommended filter of marks: two interacting models, the altitude with its bias, a gate that leaves one out.

A straight flight (constant velocity, hardly disturbed) and a manoeuvre (constant acceleration, disturbed by jerk)
interact, so that straight legs are smooth and turns are followed. What the decoded altitude differs by from the
geometric height is estimated: near the stations, where receptions alone tell the height, and remembered farther out.
A mark that fits neither model is tried without each of its receptions and without its altitude; where no single one
is to blame its noise is scaled up. Tracks start, restart and end as those of `rdfv` in its robust profile.

Differences from the paper: it has one model of motion, takes the altitude's error for white, and knows no gate
(chugunov2023). From the specification (6.2, 6.4, 6.5): the model of straight flight forgets its acceleration where time
passes only (two marks at one instant are one), and what disturbs it grows with the interval (`bank.straight_noise`). At
the start height and bias are correlated as the first altitude makes them (`bank.take_over`); before any data the bias
is a mixture of two normals (`bias_prior`). Weights lie between 1e-6 and 1 - 1e-6.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.stats import chi2

from algorithms.multilateration.bank import Choice
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import MODELS_OUTPUTS
from algorithms.multilateration.parameters import (
    PROCESS_NOISES,
    SMOOTHINGS,
    AltitudeParameters,
    FilterWithAltitudeParameters,
    MissingAltitudeParameters,
    StartParameters,
)
from algorithms.multilateration.tables import tabulate
from algorithms.multilateration.tracker import run_filter, score_filter
from algorithms.recording import ToaMarks
from algorithms.result import Result, Setting
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter
from algorithms.toolbox.motion.jerk import PROCESS_NOISE


class MlatImmParameters(MissingAltitudeParameters, StartParameters, AltitudeParameters):
    """Parameters of the filter with interacting models."""

    altitude: Literal["none", "white", "bias_state"] = parameter(
        "bias_state",
        title="Altitude",
        group="measurement",
        choices={
            "bias_state": "used; its slowly changing difference from the geometric height is estimated",
            "white": "used; its errors are taken for independent from mark to mark",
            "none": "not used",
        },
    )
    """What is done with the decoded altitude."""
    sigma_altitude_bias_m: float = parameter(
        100.0, title="Altitude bias", unit="m", symbol="σ_b", group="measurement", gt=0, le=1e5
    )
    """Standard deviation of the difference between decoded altitude and geometric height, where it is estimated.
    Pressure altitude differs from the geometric height by 50-300 m; a bias three times larger than said is still
    followed."""
    altitude_bias_time_s: float = parameter(
        3000.0, title="Time of the bias", unit="s", group="measurement", advanced=True, gt=0, le=1e6
    )
    """Time in which the bias is forgotten to 1/e."""
    gate_probability: float = parameter(0.999, title="Gate", unit="1", group="association", advanced=True, gt=0.5, lt=1)
    """Share of good marks that pass the gate."""
    sigma_acceleration_mps2: float = parameter(
        0.05, title="Acceleration of straight flight", unit="m/s²", symbol="σ_a", group="motion", gt=0, le=100
    )
    """Standard deviation of the acceleration that disturbs the straight flight."""
    sigma_jerk_mps3: float = parameter(
        0.5, title="Jerk of the manoeuvre", unit="m/s³", symbol="σ_ξ", group="motion", gt=0, le=1e4
    )
    """Standard deviation of the jerk that disturbs the manoeuvre."""
    process_noise: Literal["paper", "pwc", "white"] = parameter(
        "white",
        title="Process noise",
        group="motion",
        advanced=True,
        choices=PROCESS_NOISES,
    )
    """Form of the manoeuvre's process noise."""
    stay_straight_s: float = parameter(
        200.0, title="Straight flight lasts", unit="s", symbol="τ_CV", group="motion", advanced=True, gt=0, le=1e6
    )
    """Mean time for which a flight stays straight."""
    stay_manoeuvre_s: float = parameter(
        50.0, title="Manoeuvre lasts", unit="s", symbol="τ_CA", group="motion", advanced=True, gt=0, le=1e6
    )
    """Mean time of a manoeuvre."""
    smoothing: Literal["none", "fixed_interval"] = parameter(
        "none",
        title="Smoothing",
        group="motion",
        choices=SMOOTHINGS,
    )
    """Whether the whole track is smoothed afterwards (Rauch-Tung-Striebel)."""


_SHARED = set(FilterWithAltitudeParameters.model_fields) & set(MlatImmParameters.model_fields)


def _single(parameters: MlatImmParameters) -> FilterWithAltitudeParameters:
    """Parameters of the filter that starts the tracks."""
    given = {name: getattr(parameters, name) for name in parameters.model_fields_set & _SHARED}
    jerk = {"sigma_jerk_mps3": parameters.sigma_jerk_mps3, "process_noise": parameters.process_noise}
    return FilterWithAltitudeParameters(**(jerk | given))


def choice_of(parameters: MlatImmParameters, stations: int) -> Choice:
    """Return what the kernel needs to know of both models."""
    dof = np.arange(1, stations + 2)
    limits = np.concatenate([[np.inf], chi2.ppf(parameters.gate_probability, dof)])
    biased = parameters.altitude == "bias_state"
    return Choice(
        stay_cv_s=parameters.stay_straight_s,
        stay_ca_s=parameters.stay_manoeuvre_s,
        sigma_acceleration=parameters.sigma_acceleration_mps2,
        sigma_jerk=parameters.sigma_jerk_mps3,
        noise_form=PROCESS_NOISE.index(parameters.process_noise),
        altitude_variance=np.nan,
        bias_variance=parameters.sigma_altitude_bias_m**2 if biased else 0.0,
        bias_time_s=parameters.altitude_bias_time_s,
        limits=limits,
    )


def run(recording: ToaMarks, parameters: MlatImmParameters, context: RunContext) -> Result:
    """Filter every target of a recording."""
    result = run_filter(
        recording,
        _single(parameters),
        context,
        altitude=parameters.altitude != "none",
        models=choice_of(parameters, len(recording.stations)),
    )
    single = {"profile"}
    settings = {name: value for name, value in result.settings.items() if name not in single}
    for name in type(parameters).model_fields:
        if name not in settings and name not in ("start", "sigma_altitude_m", "earth"):
            source = "run" if name in parameters.model_fields_set else "default"
            settings[name] = Setting(getattr(parameters, name), source)
    return Result(result.arrays, result.notes, settings)


def score(recording: ToaMarks, parameters: MlatImmParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_filter(
        recording,
        _single(parameters),
        context,
        altitude=parameters.altitude != "none",
        models=choice_of(parameters, len(recording.stations)),
    )


ALGORITHM = Algorithm(
    name="mlat_imm",
    title="Interacting models on marks",
    summary="The recommended filter: straight flight and manoeuvre interact, the altitude's bias is estimated, and a "
    "late reception is left out.",
    family="multilateration",
    recommended=True,
    takes=("toa_marks",),
    parameters=MlatImmParameters,
    outputs=MODELS_OUTPUTS,
    charts=(
        "plan",
        "drms",
        "nis",
        "radial_error",
        "altitude",
        "altitude_bias",
        "height",
        "residuals",
        "receiver_delays",
        "receptions",
        "mode_probabilities",
    ),
    references=(Reference("blom1988"), Reference("barshalom2001", "sec. 11.6.6"), Reference("chugunov2023")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
