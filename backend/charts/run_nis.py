"""Normalised innovation squared of each mark, with its 95 % chi-square band.

Where the number of degrees of freedom changes from mark to mark, NIS has no common band. Then NIS is divided by its
degrees of freedom, so that 1 is expected everywhere, and the limits of each number of degrees of freedom are drawn as
labelled lines. Marks inside their own band are faint, those outside are strong, and hollow ones did not enter the
estimate as the model foresees. The strong line is the mean of the others in bins of time: it tells an optimistic
filter (above 1) from an over-cautious one, while a single outlier would hide both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from backend.charts import theme
from backend.charts.bins import TimeBins, time_bins
from backend.charts.chi_square import chi_square_band
from backend.charts.columns import Floats, Ints, texts
from backend.charts.decimate import Picked, thin
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import (
    ChartNote,
    HoverWords,
    Trace,
    counted,
    crowd_opacity,
    figure,
    hollow_marker_of,
    hover,
    line_of,
    log_axis,
    marker_of,
    not_applicable,
    outside_view,
    time_axis,
    trace,
)
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Innovations (NIS)"
MARK = "%{x:.3f} s, row %{customdata}"
# The first view reaches this far below the lowest limit.
BELOW_BAND = 10.0
# Marks of these statuses entered the estimate, but not as the model foresees.
DOUBTED = ("downweighted", "ambiguous", "reinitialised")


@dataclass(frozen=True)
class Innovations:
    """NIS and degrees of freedom of an entry's marks, where both are known (positions in `states`)."""

    entry: Entry
    states: Estimates
    known: Ints
    nis: Floats
    dof: Floats
    inside: NDArray[np.bool_]
    doubted: NDArray[np.bool_]


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw NIS (of one number of degrees of freedom) or NIS over its degrees of freedom (of several)."""
    found = [_innovations(entry) for entry in view.entries]
    dofs = np.unique(np.concatenate([i.dof for i in found])) if found else np.empty(0)
    if dofs.size == 0:
        return not_applicable(TITLE, "no_nis")
    by_dof = dofs.size > 1
    bins = time_bins(view.time_s)
    traces, labels = _limits(dofs, by_dof, view.time_s)
    notes: list[ChartNote] = []
    picked: list[Picked] = []
    for innovations in found:
        if innovations.known.size:
            _add_marks(innovations, by_dof, options, traces, picked, notes)
    for innovations in found:
        if innovations.known.size:
            traces.append(_means(innovations, by_dof, bins))
            notes.append(_share_inside(innovations))
            if innovations.doubted.any():
                count = counted(int(innovations.doubted.sum()), "mark")
                text = f"The mean leaves out {count} that did not enter the estimate as the model foresees (hollow)."
                notes.append(ChartNote("mean_without_doubted", text, innovations.entry.label))
    if by_dof:
        notes.append(ChartNote("nis_over_dof", "Degrees of freedom differ between marks: NIS is divided by them."))
    # Far below the band there is nothing to learn, and a logarithmic axis would give it half the chart.
    floor = float((chi_square_band(dofs)[0] / (dofs if by_dof else 1)).min()) / BELOW_BAND
    values = np.concatenate([i.nis / (i.dof if by_dof else 1.0) for i in found])
    values = values[values > 0]
    ceiling = float(max(values.max(initial=1.0), 10.0))
    if (values < floor).any():
        notes.append(outside_view(int((values < floor).sum()), values.size, "mark"))
    vertical = {"range": [np.log10(floor), np.log10(ceiling) + 0.2]} if (values < floor).any() else {}
    return figure(
        TITLE,
        traces,
        recording=view.recording,
        picked=picked,
        notes=notes,
        xaxis=time_axis(view.recording),
        # The chart often stands in a low panel, where longer words would be cut off.
        yaxis=log_axis("NIS per dof" if by_dof else f"NIS ({dofs[0]:g} dof)", traces, **vertical),
        annotations=labels,
    )


def _innovations(entry: Entry) -> Innovations:
    states = estimates_of(entry)
    nis, dof = states.numbers("nis"), states.numbers("dof")
    known = np.flatnonzero(np.isfinite(nis) & (dof > 0))
    nis, dof = nis[known], dof[known]
    low, high = chi_square_band(dof)
    status = texts(states.table, "status")[states.order[known]]
    doubted = ~states.used[known] | status.mapped(np.array([one in DOUBTED for one in status.categories], bool))
    return Innovations(entry, states, known, nis, dof, (nis >= low) & (nis <= high), doubted)


def _limits(dofs: Floats, by_dof: bool, time_s: Floats) -> tuple[list[Trace], list[dict[str, Any]]]:
    """Limits of the 95 % band of each number of degrees of freedom, labelled on the line; the expected value."""
    finite = time_s[np.isfinite(time_s)]
    ends = np.array([finite.min(), finite.max()]) if finite.size else np.zeros(2)
    scale = dofs if by_dof else np.ones(dofs.size)
    low, high = (limit / scale for limit in chi_square_band(dofs))
    expected = 1.0 if by_dof else float(dofs[0])
    line = {"color": theme.BOUND, "dash": "dot", "width": 1}
    traces = [
        trace(
            "bound",
            np.concatenate([[*ends, np.nan] for _ in dofs]),
            np.concatenate([[limit, limit, np.nan] for limit in side]),
            name="95 % band",
            mode="lines",
            line=line,
            showlegend=side is high,
        )
        for side in (low, high)
    ]
    traces.append(
        trace(
            "bound",
            ends,
            np.full(2, expected),
            name="expected",
            mode="lines",
            line={"color": theme.BOUND, "width": 1},
            showlegend=False,
        )
    )
    # Limits of neighbouring numbers lie close together: the outermost are named.
    named = [(float(low[i]), f"2.5 %, {dofs[i]:g} dof") for i in sorted({0, dofs.size - 1})]
    spread = f"{dofs[-1]:g} to {dofs[0]:g} dof" if by_dof else f"{dofs[0]:g} dof"
    named.append((float(high.max()), f"97.5 %, {spread}"))
    named.append((expected, "expected"))
    labels = [
        {
            "x": 1,
            "xref": "paper",
            "xanchor": "right",
            # On a logarithmic axis an annotation's place is the exponent.
            "y": float(np.log10(value)),
            "yanchor": "bottom",
            "text": text,
            "showarrow": False,
            "font": {"size": 10, "color": theme.BOUND},
        }
        for value, text in named
    ]
    return traces, labels


def _add_marks(
    innovations: Innovations,
    by_dof: bool,
    options: ChartOptions,
    traces: list[Trace],
    picked: list[Picked],
    notes: list[ChartNote],
) -> None:
    """Marks inside their band faint, outside strong, doubted or not used ones hollow."""
    entry, states = innovations.entry, innovations.states
    value = innovations.nis / innovations.dof if by_dof else innovations.nis
    zero = int((value <= 0).sum())
    if zero:
        text = f"No place on a logarithmic axis: {counted(zero, 'mark')} with NIS of exactly 0."
        notes.append(ChartNote("zero_on_log_axis", text, entry.label))
    hollow = innovations.doubted
    known, count = innovations.known, innovations.known.size
    reason = states.at_rows(entry.table("decisions"), "reason")
    row, time = states.row[known], states.time_s[known]
    words: HoverWords = [
        ("dof", lambda at: np.array([f"{d:g}" for d in innovations.dof[at]], object)),
        ("", lambda at: states.words_at("status")(known[at])),
        ("", lambda at: reason[known[at]]),
        ("target", lambda at: states.words_at("target")(known[at])),
    ]
    # Marks inside and outside are thinned alike, so that what is drawn keeps their proportion.
    plain = thin(np.flatnonzero(~hollow & (value > 0)), options.marks)
    doubted = thin(np.flatnonzero(hollow & (value > 0)), options.doubted)
    picked += [plain, doubted]
    inside = innovations.inside[plain.positions]
    looks: tuple[tuple[str, Ints, dict[str, Any]], ...] = (
        ("inside the band", plain.positions[inside], marker_of(entry, 3.5, crowd_opacity(count, 0.3))),
        ("outside the band", plain.positions[~inside], marker_of(entry, 4, crowd_opacity(count, 0.8))),
        ("doubted or not used", doubted.positions, hollow_marker_of(entry)),
    )
    for what, chosen, marker in looks:
        points = Picked(chosen, int(chosen.size), int(chosen.size))
        if points.of == 0:
            continue
        traces.append(
            trace(
                "rejected" if chosen is doubted.positions else "series",
                points.take(time),
                options.number(points.take(value)),
                entry=entry,
                name=f"{entry.label}, {what}",
                showlegend=False,
                mode="markers",
                marker=marker,
                customdata=points.take(row),
                **hover(points, f"{entry.label}, {what}", f"%{{y:.3~g}}<br>{MARK}", words),
            )
        )


def _means(innovations: Innovations, by_dof: bool, bins: TimeBins) -> Trace:
    """Mean in bins of time: the sum of NIS over the sum of degrees of freedom, with the band of that sum in hovers."""
    entry = innovations.entry
    plain = ~innovations.doubted
    time = innovations.states.time_s[innovations.known[plain]]
    n, nis = bins.sums(time, innovations.nis[plain])
    _, dof = bins.sums(time, innovations.dof[plain])
    enough = dof > 0
    low, high, mean = (np.full(n.size, np.nan) for _ in range(3))
    scale = dof[enough] if by_dof else n[enough]
    mean[enough] = nis[enough] / scale
    low[enough], high[enough] = (limit / scale for limit in chi_square_band(dof[enough]))
    return trace(
        "series",
        bins.centres,
        np.where(mean > 0, mean, np.nan),
        entry=entry,
        name=entry.label,
        mode="lines+markers",
        line=line_of(entry, 2),
        marker=marker_of(entry, size=5),
        hovertext=[
            f"mean of {int(k)} marks, 95 % band {a:.3g} to {b:.3g}" if k else ""
            for k, a, b in zip(n, low, high, strict=True)
        ],
        hovertemplate=f"<b>{entry.label}</b><br>%{{y:.3~g}}<br>%{{hovertext}}<br>{bins.width_s:g} s around "
        "%{x:.5~g} s<extra></extra>",
    )


def _share_inside(innovations: Innovations) -> ChartNote:
    share = 100 * float(innovations.inside.mean())
    text = f"{share:.1f} % of {counted(innovations.known.size, 'mark')} lie inside their own 95 % band."
    return ChartNote("share_inside", text, innovations.entry.label)


CHART = Chart(name="nis", title=TITLE, source="run", needs=("states", "decisions"), draw=draw, overlay="time")
