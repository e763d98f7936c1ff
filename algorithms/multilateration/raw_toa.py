"""Raw times of arrival: the emission time of each mark is one more state, with next to no prior.

Filtering the receptions as they come, with the emission time of every pulse as a state of its own, is the textbook's
other way to get rid of it. With a prior of 1000 km it gives the same as the range differences to a centimetre; a
narrower prior says that the emission is known so well before the mark came, and biases what is not so.

Differences from the paper: it removes the emission time by differences. The emission's prior mean is what the
prediction makes of the mark itself, so that its width alone matters; the state is dropped after the mark, as the next
pulse has another emission.

References
----------
Specification 6.3.
"""

from __future__ import annotations

from typing import Literal

from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import FILTER_OUTPUTS
from algorithms.multilateration.parameters import FilterWithAltitudeParameters
from algorithms.multilateration.tables import tabulate
from algorithms.multilateration.tracker import run_filter, score_filter
from algorithms.recording import ToaMarks
from algorithms.result import Result, Setting
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter


class RawToaParameters(FilterWithAltitudeParameters):
    """Parameters of the filter on raw times of arrival."""

    altitude: Literal["none", "white"] = parameter(
        "white",
        title="Altitude",
        group="measurement",
        choices={"none": "not used", "white": "an observation with the error above"},
    )
    """Whether a decoded altitude is used."""
    emission_prior_m: float = parameter(
        1e6, title="Prior of the emission time", unit="m", group="measurement", advanced=True, gt=0, le=1e7
    )
    """Standard deviation of c times the emission time before its mark comes."""


def run(recording: ToaMarks, parameters: RawToaParameters, context: RunContext) -> Result:
    """Filter every target of a recording by its times of arrival."""
    altitude = parameters.altitude == "white"
    result = run_filter(recording, parameters, context, altitude=altitude, emission_sd_m=parameters.emission_prior_m)
    own = {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in ("altitude", "emission_prior_m")
    }
    return Result(result.arrays, result.notes, dict(result.settings) | own)


def score(recording: ToaMarks, parameters: RawToaParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    altitude = parameters.altitude == "white"
    return score_filter(recording, parameters, context, altitude=altitude, emission_sd_m=parameters.emission_prior_m)


ALGORITHM = Algorithm(
    name="raw_toa",
    title="Filter on raw times of arrival",
    summary="Receptions enter as they are, the emission time of each mark is a state. For comparison: it gives what "
    "the range differences give.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=RawToaParameters,
    outputs=FILTER_OUTPUTS,
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(Reference("barshalom2001", "sec. 10.3"), Reference("chugunov2023")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
