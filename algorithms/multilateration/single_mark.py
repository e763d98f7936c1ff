"""Each mark solved by itself: closed form, then Levenberg-Marquardt.

Three receptions with an altitude, or four and more with or without, give a position whose covariance is the
Cramer-Rao bound of the mark. Three receptions with altitude can have two solutions that fit equally well: the mark
is then ambiguous, it has no state, and both are given (`roots_m`, table `roots`). A mark with more receptions than
unknowns is held against the residual gate; without it about one real mark in a hundred lands on a wrong branch, up to
177 km away.

Differences from the paper: it has no one-mark solution at all.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from algorithms.multilateration.conditions import conditions_of, given_or_default, toa_of
from algorithms.multilateration.fixes import solve_recording
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import OUTPUTS
from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.scoring import score_marks
from algorithms.multilateration.tables import tabulate
from algorithms.recording import ToaMarks
from algorithms.result import Output, Result, Table
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter
from algorithms.texts import Texts


class SingleMarkParameters(AltitudeParameters):
    """Parameters of the one-mark solution."""

    altitude: Literal["none", "white"] = parameter(
        "white",
        title="Altitude",
        group="measurement",
        choices={"none": "not used", "white": "an observation with the error above"},
    )
    """Whether a decoded altitude is used."""


def run(recording: ToaMarks, parameters: SingleMarkParameters, context: RunContext) -> Result:
    """Solve every mark of a recording by itself.

    Raises
    ------
    RecordingError, ParameterError
        No site, or WGS-84 without an origin.
    """
    with_altitude = parameters.altitude == "white"
    conditions = conditions_of(recording, parameters, with_altitude=with_altitude)
    toa = toa_of(recording, conditions)
    altitude = recording.altitude_m if with_altitude else np.full_like(recording.altitude_m, np.nan)
    arrays = solve_recording(recording, conditions, toa, altitude, context)
    settings = conditions.settings | {"altitude": given_or_default(parameters, "altitude")}
    return Result(arrays, conditions.notes, settings)


def score(recording: ToaMarks, parameters: SingleMarkParameters, context: RunContext) -> Scores:
    """Solve simulated marks and score them against the truth; an ambiguous mark has no estimate."""
    arrays = run(recording, parameters, context).arrays
    return score_marks(recording, arrays["state"], arrays["covariance"], arrays["nis"], arrays["dof"])


def _tabulate(recording: ToaMarks, result: Result) -> dict[str, Table]:
    """Return the common tables and the table `roots`: two rows for each ambiguous mark."""
    tables = tabulate(recording, result)
    roots = result.arrays["roots_m"]
    marks, number, trial = np.nonzero(np.isfinite(roots[:, :, 0]))
    place = roots[marks, number, :, trial]
    tables["roots"] = Table(
        {
            "row": recording.row[marks],
            "time_s": recording.time_s[marks],
            "target": Texts.coded(recording.target[marks], recording.targets),
            "root": number + 1,
            "east_m": place[:, 0],
            "north_m": place[:, 1],
            "up_m": place[:, 2],
        }
    )
    return tables


ALGORITHM = Algorithm(
    name="single_mark",
    title="One-mark solution",
    summary="Each mark is solved by itself from three receptions with altitude, or four and more. No motion model, "
    "no memory: the yardstick for every filter.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=SingleMarkParameters,
    outputs=(
        *OUTPUTS,
        Output(
            "roots_m", ("mark", "root", "axis", "trial"), "m", "the two solutions of an ambiguous mark, nearer first"
        ),
    ),
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(Reference("smith1987"), Reference("more1978"), Reference("chugunov2023", "eq. (27)")),
    run=run,
    tabulate=_tabulate,
    measure=measure,
    score=score,
)
