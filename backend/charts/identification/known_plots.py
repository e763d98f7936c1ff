"""The plots of a run as its algorithm took them: places of radars, ground ranges, angles, accuracies."""

from __future__ import annotations

from algorithms.errors import InputError
from algorithms.identification.compare import chosen_radars
from algorithms.identification.instants import brought_together
from algorithms.identification.parameters import RadarParameters, TwoRadarParameters
from algorithms.identification.plots import Plots, plots_of
from algorithms.recording import PolarPlots
from algorithms.registry import algorithms_by_name
from backend.charts.view import Entry


def parameters_of(entry: Entry) -> RadarParameters:
    """The entry's parameters with their defaults; those of every radar where it is no algorithm on radars."""
    declared = algorithms_by_name().get(entry.algorithm)
    if declared is None or not issubclass(declared.parameters, RadarParameters):
        return RadarParameters()
    return declared.parameters(**entry.parameters)


def plots_of_entry(recording: PolarPlots, entry: Entry | None) -> Plots | None:
    """What the algorithm compared; None where radars or accuracies are missing."""
    parameters = RadarParameters() if entry is None else parameters_of(entry)
    try:
        plots = plots_of(recording, parameters)
        radars = (
            chosen_radars(recording, parameters)
            if isinstance(parameters, TwoRadarParameters)
            else tuple(range(len(plots.names)))
        )
    except InputError:
        return None
    extrapolate: bool | None = getattr(parameters, "extrapolate", None)
    if extrapolate is None:
        return plots
    return brought_together(recording, plots, radars, extrapolate=extrapolate).plots


def tail_of(entry: Entry) -> float:
    """Tail of the entry's gate."""
    return parameters_of(entry).alpha
