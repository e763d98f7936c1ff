"""An algorithm of a third party that does what engines fear: it sleeps, hangs, dies, eats memory, or fails."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Literal

import numpy as np

from algorithms.errors import AlgorithmError
from algorithms.recording import ToaMarks
from algorithms.result import Metric, Note, Output, Result, Setting, Table
from algorithms.spec import Algorithm, Parameters, RunContext, parameter


class RehearsalParameters(Parameters):
    behaviour: Literal["work", "hang", "die", "die_once", "eat", "nibble", "fail", "bug"] = parameter(
        "work", title="Behaviour"
    )
    seconds: float = parameter(0.0, title="Duration", unit="s", ge=0)
    marker: str = parameter("", title="File that every start appends a line to")


_eaten: list[object] = []
"""What a careless algorithm never gives back."""


def run(recording: ToaMarks, parameters: RehearsalParameters, context: RunContext) -> Result:
    first = True
    if parameters.marker:
        path = Path(parameters.marker)
        first = not path.exists()
        with path.open("a") as marker:
            marker.write(f"{os.getpid()}\n")
    match parameters.behaviour:
        case "hang":
            time.sleep(parameters.seconds)
        case "die":
            os._exit(3)
        case "die_once" if first:
            os._exit(3)
        case "eat":
            while True:
                _eaten.append(np.ones(2**21))
        case "nibble":
            while True:
                _eaten.append(bytes(1000))
        case "fail":
            time.sleep(parameters.seconds)
            raise AlgorithmError("The geometry is singular.", time_s=3.0, remedy="Add a station.", code="singular")
        case "bug":
            raise ZeroDivisionError("nobody thought of this")
    end = time.monotonic() + parameters.seconds
    while (left := end - time.monotonic()) > 0:
        context.check_cancelled()
        context.progress(1 - left / parameters.seconds)
        time.sleep(min(0.05, left))
    draw = context.random(0).standard_normal(len(recording))
    return Result(
        {"draw": draw + recording.time_s},
        notes=(Note("rehearsal", "Only a rehearsal.", 1),),
        settings={"seconds": Setting(parameters.seconds, "run"), "nothing": Setting(float("nan"), "default")},
    )


def tabulate(recording: ToaMarks, result: Result) -> dict[str, Table]:
    return {
        "states": Table({"row": recording.row, "nis": result.arrays["draw"], "status": ["updated"] * len(recording)}),
        "tracks": Table({"track": np.array([1]), "start_s": np.array([np.nan]), "reason": [None]}),
    }


def measure(recording: ToaMarks, result: Result) -> list[Metric]:
    return [
        Metric("nis", float(np.mean(result.arrays["draw"])), "", len(recording), 0.5, 1.5),
        Metric("nis", None, "", 0, target="7"),
        Metric("rms_up_m", float("nan"), "m", 0),
    ]


ALGORITHM = Algorithm(
    name="rehearsal",
    title="Rehearsal",
    summary="Does what engines fear.",
    family="rehearsal",
    takes=("toa_marks",),
    parameters=RehearsalParameters,
    outputs=(Output("draw", axes=("time",)),),
    charts=(),
    references=(),
    run=run,
    tabulate=tabulate,
    measure=measure,
)
