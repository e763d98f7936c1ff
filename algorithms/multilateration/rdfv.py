"""RDFV: the range-difference filter with the flight altitude as one more scalar observation.

Where complete marks vanish, RDF diverges by kilometres and RDFV follows. A constant altitude error of 100-300 m
(pressure against geometric height) enters as if it were noise: choose `sigma_altitude_m` accordingly.

Differences from the paper: those of `rdf`; the gradient (26) prints z where R + z must stand; (13) prints the time
variance where the altitude's must stand.
"""

from __future__ import annotations

from algorithms.multilateration.bound import horizontal_bound
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import FILTER_OUTPUTS
from algorithms.multilateration.parameters import FilterWithAltitudeParameters, UpdateParameters
from algorithms.multilateration.tables import tabulate
from algorithms.multilateration.tracker import run_filter, score_filter
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext


class RdfvParameters(FilterWithAltitudeParameters, UpdateParameters):
    """Parameters of the range-difference filter with altitude."""


def run(recording: ToaMarks, parameters: RdfvParameters, context: RunContext) -> Result:
    """Filter every target of a recording by its range differences and altitudes."""
    return run_filter(recording, parameters, context, altitude=True)


def score(recording: ToaMarks, parameters: RdfvParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_filter(recording, parameters, context, altitude=True)


def bound(recording: ToaMarks, parameters: RdfvParameters) -> Floats:
    """Posterior Cramer-Rao bound of the rms horizontal error for the filter's own model of the motion."""
    return horizontal_bound(recording, parameters, altitude=True)


ALGORITHM = Algorithm(
    name="rdfv",
    title="Range-difference filter with altitude (RDFV)",
    summary="Extended Kalman filter on time differences and the decoded altitude. Starts from three receptions with "
    "altitude, four, or several marks.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=RdfvParameters,
    outputs=FILTER_OUTPUTS,
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(
        Reference("chugunov2023", "eqs. (15)-(26)"),
        Reference("barshalom2001", "sec. 10.3"),
        Reference("bell1993"),
        Reference("julier1997"),
        Reference("arasaratnam2009"),
    ),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
