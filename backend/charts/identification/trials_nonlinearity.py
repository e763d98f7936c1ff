"""How honest single plots and pairs are over the nonlinearity index: NEES and false rejection by conversion.

Above, the NEES of single converted plots with the leading terms of the theory (specification 8), per degree of freedom:
lin 1 + 3/8 kappa^2; paper (1 + (1 + kappa^2/2) / (1 + 3/2 kappa^2)) / 2; mucm and ucm 1. Below, the share of true pairs
that the gate rejects.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from algorithms.recording import PolarPlots
from backend.charts import theme
from backend.charts.figure import ChartNote, Trace, axis, figure, log_axis, not_applicable, trace
from backend.charts.identification.known_plots import tail_of
from backend.charts.identification.samples import Floats, measured, swept_names
from backend.charts.identification.trials_probability import line_of_metric, ticks_of
from backend.charts.swept import title_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Honesty against the nonlinearity index"
ACCURACIES = ("sigma_azimuth_deg", "sigma_range_m", "target_range_m")
THEORY = (("lin", "dash"), ("paper", "dot"), ("mucm", "solid"))
FINE = 80


def theory(conversion: str, kappa: Floats) -> Floats:
    """NEES of a single plot per degree of freedom, leading order."""
    k2 = kappa * kappa
    if conversion == "lin":
        return 1 + 0.375 * k2
    if conversion == "paper":
        return (1 + (1 + k2 / 2) / (1 + 1.5 * k2)) / 2
    return np.ones_like(kappa)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw both over kappa where an accuracy or the range is swept, else over the swept value."""
    names = [n for entry in view.entries for n in swept_names(entry.table("metrics"))]
    upper: list[Trace] = []
    lower: list[Trace] = []
    index = _index(names[0], view) if names else None
    for entry in view.entries:
        for metric, word, dash, into, more in (
            ("plot_nees", "NEES of single plots", "solid", upper, {}),
            ("false_rejection", "true pairs outside the gate", "dot", lower, {"yaxis": "y2"}),
        ):
            for one in measured(entry, metric):
                if np.isfinite(one.value).any():
                    into.append(line_of_metric(entry, one, word, dash, **more))
    traces = upper + lower
    if not traces:
        return not_applicable(TITLE, "no_sweep")
    swept = np.unique(np.concatenate([np.asarray(t["x"], float) for t in traces]))
    text = (
        "Above: NEES of single converted plots per degree of freedom, 1 is honest. Below: share of true pairs that the "
        "gate rejects. Bars are 95 % intervals over the trials."
    )
    notes = [ChartNote("single_plots", text)]
    if index is None:
        x_axis = axis(title_of(names[0], view), **ticks_of(names[0], swept, view))
    else:
        at = {float(v): index(float(v)) for v in swept}
        for drawn in traces:
            drawn["x"] = np.array([at[float(v)] for v in drawn["x"]])
        kappa = np.array(sorted(at.values()))
        upper += _theory_lines(kappa)
        x_axis = axis("Nonlinearity index κ", type="log")
        text = (
            "κ = range times squared azimuth error over range error; from 0.4 on it matters. Grey lines are the theory "
            "of single plots: lin dashed, paper dotted, mucm and ucm solid."
        )
        notes.append(ChartNote("nonlinearity", text))
    lower += _nominal(view, lower)
    return figure(
        TITLE,
        upper + lower,
        recording=view.recording,
        notes=notes,
        xaxis=x_axis | {"anchor": "y2"},
        yaxis=log_axis("NEES", upper) | {"domain": [0.54, 1]},
        yaxis2=log_axis("Share rejected", lower) | {"domain": [0, 0.46]},
    )


def _index(name: str, view: RunView) -> Callable[[float], float] | None:
    """Nonlinearity index at a value of the swept name; None where the name does not change it."""
    short = name.rpartition(".")[2]
    recording = view.recording
    if short not in ACCURACIES or not isinstance(recording, PolarPlots) or recording.site is None or not len(recording):
        return None
    radar, place = recording.site.radars[0], recording.site.radar_positions()[0]
    if radar.sigma_range_m is None or radar.sigma_azimuth_deg is None or not np.isfinite(recording.truth_m[0, 0]):
        return None
    known: dict[str, Any] = {
        "sigma_azimuth_deg": radar.sigma_azimuth_deg,
        "sigma_range_m": radar.sigma_range_m,
        "target_range_m": float(np.hypot(*(recording.truth_m[0, :2] - place[:2]))),
    }

    def index(value: float) -> float:
        v = known | {short: value}
        return float(v["target_range_m"] * np.radians(v["sigma_azimuth_deg"]) ** 2 / v["sigma_range_m"])

    return index


def _theory_lines(kappa: Floats) -> list[Trace]:
    fine = np.geomspace(max(kappa[0], 1e-6), max(kappa[-1], 2e-6), FINE)
    return [
        trace(
            "bound",
            fine,
            theory(conversion, fine),
            name=f"theory of {conversion}",
            mode="lines",
            line={"color": theme.BOUND, "width": 1.2, "dash": dash},
        )
        for conversion, dash in THEORY
    ]


def _nominal(view: RunView, lower: list[Trace]) -> list[Trace]:
    """What the gates should reject."""
    if not lower:
        return []
    x = np.concatenate([np.asarray(t["x"], float) for t in lower])
    ends = np.array([x.min(), x.max()])
    line = {"color": theme.BOUND, "width": 1.2, "dash": "dash"}
    return [
        trace("bound", ends, np.full(2, tail), name=f"nominal {tail:g}", mode="lines", line=line, yaxis="y2")
        for tail in sorted({tail_of(entry) for entry in view.entries})
    ]


CHART = Chart(
    name="trials_nonlinearity",
    title=TITLE,
    source="run",
    needs=("metrics",),
    draw=draw,
    kinds=("polar_plots",),
    least_sweeps=1,
)
