"""An algorithm of a third party that gives back what it was given: plots of several radars, as they reach it."""

from __future__ import annotations

import numpy as np

from algorithms.recording import PolarPlots
from algorithms.result import Metric, Output, Result, Table
from algorithms.spec import Algorithm, Parameters, RunContext


class EchoParameters(Parameters):
    """None."""


def run(recording: PolarPlots, parameters: EchoParameters, context: RunContext) -> Result:
    """Give the ranges back."""
    return Result({"range_m": recording.range_m[:, 0]})


def tabulate(recording: PolarPlots, result: Result) -> dict[str, Table]:
    """Say which radar each row is of, and where a target at its azimuth would be if the Earth were flat."""
    m = len(recording)
    radar = [recording.radars[i] for i in recording.radar]
    azimuth = recording.azimuth_rad[:, 0]
    states = {
        "track": np.ones(m, np.int64),
        "row": recording.row,
        "time_s": recording.time_s,
        "east_m": result.arrays["range_m"] * np.sin(azimuth),
        "north_m": result.arrays["range_m"] * np.cos(azimuth),
        "status": ["updated"] * m,
        "used": np.ones(m, bool),
    }
    decisions = {"row": recording.row, "time_s": recording.time_s, "reason": radar}
    return {"states": Table(states), "decisions": Table(decisions)}


def measure(recording: PolarPlots, result: Result) -> list[Metric]:
    """Count the radars of the site."""
    radars = () if recording.site is None else recording.site.radars
    return [Metric("continuity", float(len(radars)), "", len(recording))]


ALGORITHM = Algorithm(
    name="echo",
    title="Echo",
    summary="Gives back what it was given.",
    family="echo",
    takes=("polar_plots",),
    parameters=EchoParameters,
    outputs=(Output("range_m", axes=("time",)),),
    charts=("plan",),
    references=(),
    run=run,
    tabulate=tabulate,
    measure=measure,
)
