"""RDF: an extended Kalman filter on range differences, incomplete marks included.

Two receptions are enough to update a track; no one-mark fix is needed once it lives. See `filter_kernel` for the
steps, `begin` for start and restart, `lanes` for the statuses.

Differences from the paper: (19) prints a minus before the gain (positive feedback; 327 km after ten marks); start,
outliers, loss and restart are ours; the rows are Helmert contrasts (the same update, no reference station).
"""

from __future__ import annotations

from algorithms.multilateration.bound import horizontal_bound
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import FILTER_OUTPUTS
from algorithms.multilateration.parameters import FilterParameters, UpdateParameters
from algorithms.multilateration.tables import tabulate
from algorithms.multilateration.tracker import run_filter, score_filter
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.scores import Floats, Scores
from algorithms.spec import Algorithm, Reference, RunContext


class RdfParameters(FilterParameters, UpdateParameters):
    """Parameters of the range-difference filter."""


def run(recording: ToaMarks, parameters: RdfParameters, context: RunContext) -> Result:
    """Filter every target of a recording by its range differences."""
    return run_filter(recording, parameters, context, altitude=False)


def score(recording: ToaMarks, parameters: RdfParameters, context: RunContext) -> Scores:
    """Filter simulated trials and score them against the truth."""
    return score_filter(recording, parameters, context, altitude=False)


def bound(recording: ToaMarks, parameters: RdfParameters) -> Floats:
    """Posterior Cramer-Rao bound of the rms horizontal error for the filter's own model of the motion."""
    return horizontal_bound(recording, parameters, altitude=False)


ALGORITHM = Algorithm(
    name="rdf",
    title="Range-difference filter (RDF)",
    summary="Extended Kalman filter on time differences. Uses marks with two receptions and more; starts from four, "
    "or several marks.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=RdfParameters,
    outputs=FILTER_OUTPUTS,
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(
        Reference("chugunov2023", "eqs. (5)-(23)"),
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
