"""Fill the arrays of a result look by look: what every algorithm on plots of two radars has in common."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.identification.diagnosis import diagnosed
from algorithms.identification.filled import DOF, KEPT_PAIRS, Decided, Filled, Pairs, joined_pairs, listed_pairs
from algorithms.identification.instants import brought_together
from algorithms.identification.outputs import NOT_COMPARED, ONE_LINE, REJECTED, TIED
from algorithms.identification.pairs import PairStatistics, Points, Side, fused, pair_statistics, points_of
from algorithms.identification.parameters import PairParameters, TwoRadarParameters
from algorithms.identification.plots import Look, Plots, plots_of, refuse_nothing
from algorithms.identification.scoring import Judged
from algorithms.recording import PolarPlots
from algorithms.result import Note, Result, Setting
from algorithms.spec import RunContext
from algorithms.toolbox.association.exact import EXACT_COLUMNS, LARGEST_EXACT
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


Decide = Callable[[PairStatistics], Decided]


def chosen_radars(recording: PolarPlots, parameters: TwoRadarParameters) -> tuple[int, int]:
    """Positions of the two radars that are compared."""
    out: list[int] = []
    for field, default in (("first_radar", 0), ("second_radar", 1)):
        name = getattr(parameters, field)
        if not name:
            free = [k for k in range(len(recording.radars)) if k not in out]
            out.append(default if default in free else free[0])
            continue
        if name not in recording.radars:
            raise ParameterError(
                f"The recording has no radar {name!r}.",
                pointer=f"/{field}",
                remedy=f"Take one of {', '.join(recording.radars)}.",
            )
        out.append(recording.radars.index(name))
    if out[0] == out[1]:
        raise ParameterError(
            "A radar cannot be compared with itself.", pointer="/second_radar", remedy="Name two different radars."
        )
    return out[0], out[1]


def side_of(plots: Plots, radar: int, rows: Ints) -> Side:
    """Return the plots of one radar at one look."""
    ahead = None if plots.ahead is None else Points(*(c[:, None] for c in plots.ahead[rows].T))
    return Side(
        plots.sites[radar],
        plots.range_m[rows],
        plots.angle_rad[rows],
        float(plots.sigma_range[radar]),
        float(plots.sigma_angle[radar]),
        ahead,
    )


def compare(recording: PolarPlots, parameters: PairParameters, context: RunContext, decide: Decide) -> Result:
    """Compare two radars look by look; a recording that is no simulation is looked at for wrong registration too."""
    plots = plots_of(recording, parameters)
    refuse_nothing(plots)
    first, second = chosen_radars(recording, parameters)
    together = brought_together(recording, plots, (first, second), extrapolate=parameters.extrapolate)
    plots = together.plots
    threshold = gate_threshold(parameters.alpha, DOF)
    lanes = plots.lanes
    filled = Filled(plots)
    filled.decision[~np.isin(plots.radar, (first, second))] = NOT_COMPARED
    total = sum(look.rows[first].size * look.rows[second].size for look in plots.looks)
    pairs: list[Pairs] = []
    unsettled = ranked = split = 0
    truncation = 0.0
    accepted: list[Ints] = []
    for k, look in enumerate(plots.looks):
        context.check_cancelled()
        a, b = (side_of(plots, r, look.rows[r]) for r in (first, second))
        found = pair_statistics(a, b, parameters.conversion)
        decided = decide(found)
        unsettled += found.unsettled
        ranked += decided.ranked_groups
        split += decided.split
        truncation = max(truncation, decided.truncation)
        filled.take(recording, parameters, (look.rows[first], look.rows[second]), (a, b), found, decided)
        rows = (look.rows[first], look.rows[second])
        pairs.append(
            listed_pairs(recording, look.number, rows, found.statistic, decided.pairs, decided.pair_decision, total)
        )
        i = np.flatnonzero(decided.partner[0][:, 0] >= 0) if lanes == 1 else np.empty(0, np.int64)
        accepted.append(np.stack([rows[0][i], rows[1][decided.partner[0][i, 0]]], axis=1))
        context.progress((k + 1) / len(plots.looks))
    if not plots.looks:
        context.check_cancelled()
        context.progress(1.0)
    pairs_made = np.concatenate(accepted) if accepted else np.empty((0, 2), np.int64)
    hypotheses, wrong = diagnosed(*together.at_instants, first, second, pairs_made) if lanes == 1 else ([], [])
    notes = [*plots.notes, *unusable_plots(plots), *together.notes]
    notes += _notes(plots, recording, (first, second), unsettled, total)
    notes += [*doubts(filled), *exactness(parameters, split, ranked, truncation), *wrong]
    arrays = (
        filled.arrays()
        | joined_pairs(pairs, lanes)
        | {
            "row": recording.row,
            "instant_s": together.instant_s,
            "frame": plots.frame,
            "radar": plots.radar,
            "threshold": np.array([threshold]),
            "registration": np.array([h.numbers() for h in hypotheses]).reshape(-1, 9),
        }
    )
    settings = plots.settings | {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in plots.settings and getattr(parameters, name) not in (None, "")
    }
    return Result(arrays, tuple(notes), settings)


def judged(
    recording: PolarPlots, parameters: PairParameters, context: RunContext, decide: Decide, *, matched: bool
) -> list[Judged]:
    """Return what is to be counted of simulated plots; `reading` says whose plots look for a partner."""
    plots = plots_of(recording, parameters)
    first, second = chosen_radars(recording, parameters)
    threshold = gate_threshold(parameters.alpha, DOF)
    side = 0 if parameters.reading == "A" else 1
    out: list[Judged] = []
    for look in plots.looks:
        context.check_cancelled()
        ends = tuple(side_of(plots, r, look.rows[r]) for r in (first, second))
        found = pair_statistics(ends[0], ends[1], parameters.conversion)
        decided = decide(found)
        place, covariance = fused(ends[side], ends[1 - side], parameters.conversion, decided.partner[side])
        rows = (look.rows[first], look.rows[second])
        own = points_of(ends[side], parameters.conversion) if parameters.conversion != "polar" else None
        out.append(
            Judged(
                time_s=_time_of(recording, look),
                anchors=rows[side],
                others=rows[1 - side],
                statistic=_seen_from(side, found.statistic),
                partner=decided.partner[side],
                several=decided.several[side],
                best=decided.best[side] if matched else None,
                pairs=_seen_from(side, decided.pairs) if decided.pairs is not None else None,
                ties=decided.ties[side] if matched else None,
                place=place,
                covariance=covariance,
                threshold=threshold,
                own_place=None if own is None else np.stack([own.x, own.y], axis=1),
                own_covariance=None if own is None else np.stack([own.xx, own.yy, own.xy], axis=1),
            )
        )
    return out


def _seen_from(side: int, values: Floats) -> Floats:
    """(n, m, L) with the plots of that side first."""
    return values if side == 0 else np.swapaxes(values, 0, 1)


def _time_of(recording: PolarPlots, look: Look) -> float:
    return float(min(recording.time_s[rows].min() for rows in look.rows if rows.size))


def unusable_plots(plots: Plots) -> list[Note]:
    """Tell how many rows cannot be used."""
    bad = sum(1 for word in plots.bad if word)
    text = "Plots without a usable range or azimuth are left out; see decisions."
    return [Note("unusable_plots", text, bad)] if bad else []


def _notes(
    plots: Plots,
    recording: PolarPlots,
    radars: tuple[int, int],
    unsettled: int,
    total: int,
) -> list[Note]:
    out = []
    others = [name for k, name in enumerate(plots.names) if k not in radars]
    if others:
        count = int((~np.isin(recording.radar, radars)).sum())
        out.append(
            Note(
                "radars_left_out",
                "Two radars are compared; the plots of the others are left out. multi_radar_assignment takes all.",
                count,
            )
        )
    if unsettled:
        out.append(
            Note(
                "not_settled",
                "Pairs whose exact likelihood did not settle are judged by their converted points.",
                unsettled,
            )
        )
    if total > KEPT_PAIRS:
        out.append(
            Note("pairs_not_kept", "Pairs that cannot belong together in any trial are not listed one by one.", total)
        )
    return out


def exactness(parameters: object, split: int, ranked: int, truncation: float) -> list[Note]:
    """Tell where probabilities are not one sum over all matchings, what took its place, and how exact that is."""
    limit = getattr(parameters, "exact_plots", EXACT_COLUMNS)
    out = []
    if split:
        out.append(
            Note(
                "groups_summed",
                f"Looks with more than {limit} plots or tracks on the shorter side are too large for one sum over all "
                f"matchings (exact_plots, at most {LARGEST_EXACT}). They were split into groups that no pair inside "
                "the gate (tail 0.000001) joins, and each group of up to as many plots was summed exactly.",
                split,
            )
        )
    if ranked:
        out.append(
            Note(
                "ranked_matchings",
                f"Groups of more than {limit} plots on the shorter side were summed over their most likely matchings; "
                f"no probability is wrong by more than {truncation:.2g}.",
                ranked,
            )
        )
    return out


def doubts(filled: Filled) -> list[Note]:
    """Plots that no better method would decide."""
    out = []
    if (filled.reason == ONE_LINE).any():
        out.append(
            Note(
                "geometry_cannot_separate",
                "Plots are undecided because both radars look along one line there: targets beside each other at the "
                "same range cannot be told apart. A radar beside that line would separate them.",
                int((filled.reason == ONE_LINE).sum()),
            )
        )
    if (filled.reason == TIED).any():
        out.append(
            Note(
                "exact_ties",
                "Plots have two partners that are exactly as probable, such as a plot that stands there twice; they "
                "stay undecided.",
                int((filled.reason == TIED).sum()),
            )
        )
    return out


def partners_both_ways(partner: Ints, m: int) -> Ints:
    """(m, L) row of each column from (n, L) the column of each row; of several rows the first."""
    n, lanes = partner.shape
    out = np.full((m, lanes), -1)
    for i in range(n - 1, -1, -1):
        lane = np.flatnonzero(partner[i] >= 0)
        out[partner[i, lane], lane] = i
    return out


def pair_decisions(shape: tuple[int, ...], partner: Ints, decision: Ints) -> Ints:
    """(n, m, L): the decision of the row where the column is its partner, else rejected."""
    out = np.full(shape, REJECTED)
    n, m, _ = shape
    for i in range(n if m else 0):
        lane = np.flatnonzero(partner[i] >= 0)
        out[i, partner[i, lane], lane] = decision[i, lane]
    return out
