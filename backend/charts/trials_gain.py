"""How much one algorithm gains over another at each instant: the ratio of their rms horizontal errors."""

from __future__ import annotations

import numpy as np

from backend.charts import theme
from backend.charts.decimate import Picked
from backend.charts.figure import ChartNote, Trace, axis, figure, not_applicable, time_axis, trace
from backend.charts.trial_curves import Floats, Series, leg_shapes, line, series_of
from backend.charts.view import Chart, ChartOptions, Figure, RunView

TITLE = "Gain over the first algorithm"
METRIC = "rms_horizontal_m"


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the error of the first label over that of every other one, under the same conditions (specification 12)."""
    found = [s for s in series_of(view) if np.isfinite(s.numbers(METRIC)).any()]
    if not found:
        return not_applicable(TITLE, "no_curves")
    first = found[0].entry.label
    if all(s.entry.label == first for s in found):
        return not_applicable(TITLE, "nothing_to_compare")
    own = [s for s in found if s.entry.label == first]
    reference = {s.conditions: s for s in own}
    if len(reference) < len(own):
        return not_applicable(TITLE, "no_reference")
    traces: list[Trace] = []
    picked: list[Picked] = []
    for series in found:
        against = reference.get(series.conditions)
        if series.entry.label == first or against is None:
            continue
        gain = _gain(against, series)
        if np.isfinite(gain).any():
            traces.append(line(series, series.name, gain, options, picked, f"error of {first}: %{{y:.3~r}} times"))
    if not traces:
        return not_applicable(TITLE, "no_curves")
    ends = found[0].time_s[[0, -1]]
    one = {"color": theme.BOUND, "dash": "dot", "width": 1}
    traces.append(trace("bound", ends, np.ones(2), name="no gain", mode="lines", line=one))
    text = f"Root mean square error of {first} over that of the others, on the same draws: 2 is half the error."
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=[ChartNote("gain", text)],
        xaxis=time_axis(view.recording),
        yaxis=axis("Gain", rangemode="tozero"),
        **leg_shapes(view.legs),
    )


def _gain(reference: Series, series: Series) -> Floats:
    """Ratio of the errors, at the instants of the series; NaN where the reference has none."""
    errors = reference.numbers(METRIC)
    known = np.isfinite(errors)
    place = np.searchsorted(reference.time_s[known], series.time_s)
    inside = place < np.count_nonzero(known)
    same = np.zeros(series.time_s.size, np.bool_)
    same[inside] = reference.time_s[known][place[inside]] == series.time_s[inside]
    out = np.full(series.time_s.size, np.nan)
    out[same] = errors[known][place[same]]
    own = series.numbers(METRIC)
    ratio: Floats = out / np.where(own > 0, own, np.nan)
    return ratio


CHART = Chart(name="trials_gain", title=TITLE, source="run", needs=("curves",), draw=draw, least_entries=2)
