"""When nothing fits: which mistake in the data would make the radars agree?

The sign is a median squared distance to the nearest partner beyond all reason. Each known mistake is then undone in
turn (an azimuth counted from east, degrees that were radians, plots that are counted from the other radar's place,
looks that are one or more apart), and the one is named that makes the radars agree.

References
----------
specification 10.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.pairs import Side, compared_points, points_of
from algorithms.identification.plots import Plots
from algorithms.result import Note

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SUSPICIOUS_MEDIAN = 50.0
# The median that makes a suggestion, and how many times smaller than before it must be.
PLAUSIBLE_MEDIAN = 20.0
IMPROVED = 5.0
MOST_LOOKS = 40
FEWEST_PLOTS = 4
LOOKS_APART = (-3, -2, -1, 1, 2, 3)


@dataclass(frozen=True)
class _Idea:
    note: Note
    plots: Plots
    apart: int = 0


def suspected(plots: Plots, first: int, second: int) -> list[Note]:
    """Return a note where the two radars disagree beyond all reason, with the mistake that would explain it."""
    before = median_statistic(plots, first, second)
    if not before > SUSPICIOUS_MEDIAN:
        return []
    best: tuple[float, _Idea] | None = None
    for idea in _ideas(plots, first, second):
        median = median_statistic(idea.plots, first, second, idea.apart)
        if best is None or median < best[0]:
            best = (median, idea)
    out = [
        Note(
            "radars_disagree",
            f"The nearest partners of the two radars are a squared distance of {before:.0f} apart (median); about 1.4 "
            "is usual.",
        )
    ]
    if best is not None and best[0] < PLAUSIBLE_MEDIAN and best[0] * IMPROVED < before:
        out.append(best[1].note)
    else:
        out.append(
            Note(
                "disagreement_unexplained",
                "No known mistake explains it: look at the site, the accuracies, the units and the clocks.",
            )
        )
    return out


def median_statistic(plots: Plots, first: int, second: int, apart: int = 0) -> float:
    """Median over the plots of the first radar of the squared distance to the nearest plot of the second one."""
    nearest: list[Floats] = []
    for k, look in enumerate(plots.looks[:MOST_LOOKS]):
        if not 0 <= k + apart < len(plots.looks):
            continue
        other = plots.looks[k + apart]
        a, b = _side(plots, first, look.rows[first]), _side(plots, second, other.rows[second])
        if not (a.range_m.size and b.range_m.size):
            continue
        statistic = np.empty((a.range_m.shape[0], b.range_m.shape[0], 1))
        compared_points(points_of(a, "mucm"), points_of(b, "mucm"), statistic, None)
        known = np.where(np.isfinite(statistic[:, :, 0]), statistic[:, :, 0], np.inf).min(axis=1)
        nearest.append(known[np.isfinite(known)])
    values = np.concatenate(nearest) if nearest else np.empty(0)
    return float(np.median(values)) if values.size >= FEWEST_PLOTS else 0.0


def _side(plots: Plots, radar: int, rows: Ints) -> Side:
    return Side(
        plots.sites[radar],
        plots.range_m[rows, :1],
        plots.angle_rad[rows, :1],
        float(plots.sigma_range[radar]),
        float(plots.sigma_angle[radar]),
    )


def _ideas(plots: Plots, first: int, second: int) -> Iterator[_Idea]:
    whose = (
        ((first,), f"radar {plots.names[first]}"),
        ((second,), f"radar {plots.names[second]}"),
        ((first, second), "both radars"),
    )
    compass = np.pi / 2 - plots.angle_rad
    for radars, words in whose:
        chosen = np.isin(plots.radar, radars)[:, None]
        yield _Idea(
            Note(
                "suspect_azimuth_convention",
                f"The azimuths of {words} seem to be counted counter-clockwise from east: with 90 degrees less the "
                "azimuth the radars agree.",
            ),
            replace(plots, angle_rad=np.where(chosen, compass, plots.angle_rad)),
        )
        yield _Idea(
            Note(
                "suspect_azimuth_unit",
                f"The azimuths of {words} seem to be radians that were read as degrees: with the unit rad the radars "
                "agree.",
            ),
            replace(plots, angle_rad=np.where(chosen, np.pi / 2 - np.degrees(compass), plots.angle_rad)),
        )
    sites = plots.sites.copy()
    sites[second] = sites[first]
    yield _Idea(
        Note(
            "suspect_translation",
            f"The plots of radars {plots.names[first]} and {plots.names[second]} seem to be counted from one place: "
            "with the same place for both in the site the radars agree.",
        ),
        replace(plots, sites=sites),
    )
    for apart in LOOKS_APART:
        yield _Idea(
            Note(
                "suspect_clock",
                f"The looks of radar {plots.names[second]} seem to be {abs(apart)} too "
                f"{'early' if apart > 0 else 'late'}: shifted by as much the radars agree.",
            ),
            plots,
            apart,
        )
