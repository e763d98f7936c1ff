"""Fill the arrays of a result look by look: what every algorithm on plots of two radars has in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.identification.outputs import (
    ACCEPTED,
    ALONE,
    MISSING,
    NOT_COMPARED,
    REJECTED,
    UNUSABLE,
)
from algorithms.identification.pairs import PairStatistics, Side, fused, pair_statistics, points_of
from algorithms.identification.parameters import PairParameters
from algorithms.identification.plots import Look, Plots, plots_of
from algorithms.identification.registration import Accepted, hypotheses_of, notes_of
from algorithms.identification.scoring import Judged
from algorithms.identification.suspicion import suspected
from algorithms.recording import PolarPlots
from algorithms.result import Note, Result, Setting
from algorithms.spec import RunContext
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

DOF = 2
# A run on more pairs than this keeps those alone that could belong together in some trial.
KEPT_PAIRS = 200_000
WIDE_TAIL = 1e-6


@dataclass(frozen=True)
class Decided:
    """What an algorithm made of one look: n plots of the first radar, m of the second, L trials.

    Attributes
    ----------
    partner : (n, L) and (m, L) for the two sides, accepted partner or -1
    decision : (n, L) and (m, L)
    pair_decision : (n, m, L)
    pairs : (n, m, L) probabilities, or None
    best : (n, L) and (m, L) most likely partner whatever was decided, -1 = none
    several : (n, L) and (m, L) undecided because of several
    ties : (n, L) and (m, L)
    """

    partner: tuple[Ints, Ints]
    decision: tuple[Ints, Ints]
    pair_decision: Ints
    pairs: Floats | None
    best: tuple[Ints, Ints]
    several: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    ties: tuple[NDArray[np.bool_], NDArray[np.bool_]]
    ranked_groups: int = 0
    truncation: float = 0.0


Decide = Callable[[PairStatistics], Decided]


def chosen_radars(recording: PolarPlots, parameters: PairParameters) -> tuple[int, int]:
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
    return Side(
        plots.sites[radar],
        plots.range_m[rows],
        plots.angle_rad[rows],
        float(plots.sigma_range[radar]),
        float(plots.sigma_angle[radar]),
    )


def compare(recording: PolarPlots, parameters: PairParameters, context: RunContext, decide: Decide) -> Result:
    """Compare two radars look by look; a recording that is no simulation is looked at for wrong registration too."""
    plots = plots_of(recording, parameters)
    first, second = chosen_radars(recording, parameters)
    threshold = gate_threshold(parameters.alpha, DOF)
    marks, lanes = plots.range_m.shape
    filled = _Filled(marks, lanes)
    filled.decision[:] = np.where(plots.usable, ALONE, MISSING)
    filled.decision[[bool(word) for word in plots.bad]] = UNUSABLE
    filled.decision[~np.isin(plots.radar, (first, second))] = NOT_COMPARED
    total = sum(look.rows[first].size * look.rows[second].size for look in plots.looks)
    pairs: list[_Pairs] = []
    unsettled = ranked = 0
    truncation = 0.0
    registration = Accepted.nothing()
    for k, look in enumerate(plots.looks):
        context.check_cancelled()
        a, b = (side_of(plots, r, look.rows[r]) for r in (first, second))
        found = pair_statistics(a, b, parameters.conversion)
        decided = decide(found)
        unsettled += found.unsettled
        ranked += decided.ranked_groups
        truncation = max(truncation, decided.truncation)
        filled.take(recording, parameters, (look.rows[first], look.rows[second]), (a, b), found, decided)
        pairs.append(_pairs(recording, look, first, second, found, decided, total))
        if lanes == 1:
            registration = registration.joined(filled.accepted((look.rows[first], look.rows[second]), (a, b), decided))
        context.progress((k + 1) / len(plots.looks))
    if not plots.looks:
        context.check_cancelled()
        context.progress(1.0)
    hypotheses = hypotheses_of(registration)
    notes = [*plots.notes, *_notes(plots, recording, (first, second), unsettled, ranked, truncation, total)]
    if lanes == 1:
        notes += notes_of(hypotheses, (plots.names[first], plots.names[second]))
        notes += suspected(plots, first, second)
    arrays = (
        filled.arrays()
        | _joined(pairs, lanes)
        | {
            "row": recording.row,
            "frame": plots.frame,
            "radar": plots.radar,
            "threshold": np.array([threshold]),
            "registration": np.array([h.numbers() for h in hypotheses]).reshape(-1, 8),
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
            )
        )
    return out


def _seen_from(side: int, values: Floats) -> Floats:
    """(n, m, L) with the plots of that side first."""
    return values if side == 0 else np.swapaxes(values, 0, 1)


def _time_of(recording: PolarPlots, look: Look) -> float:
    return float(min(recording.time_s[rows].min() for rows in look.rows if rows.size))


@dataclass(frozen=True)
class _Pairs:
    row: Ints
    frame: Ints
    statistic: Floats
    probability: Floats
    decision: Ints


def _pairs(
    recording: PolarPlots, look: Look, first: int, second: int, found: PairStatistics, decided: Decided, total: int
) -> _Pairs:
    n, m, lanes = found.statistic.shape
    i, j = np.indices((n, m)).reshape(2, -1)
    statistic = found.statistic.reshape(n * m, lanes)
    probability = np.full((n * m, lanes), np.nan) if decided.pairs is None else decided.pairs.reshape(n * m, lanes)
    decision = decided.pair_decision.reshape(n * m, lanes)
    if total > KEPT_PAIRS:
        near = statistic <= gate_threshold(WIDE_TAIL, DOF)
        keep = np.flatnonzero((near | (decision != REJECTED)).any(axis=1))
        i, j, statistic, probability, decision = i[keep], j[keep], statistic[keep], probability[keep], decision[keep]
    rows = np.stack([recording.row[look.rows[first][i]], recording.row[look.rows[second][j]]], axis=1)
    return _Pairs(rows.reshape(-1, 2), np.full(i.size, look.number), statistic, probability, decision)


def _joined(pairs: list[_Pairs], lanes: int) -> dict[str, NDArray[np.generic]]:
    def of(values: list[NDArray[np.generic]], width: int, kind: type) -> NDArray[np.generic]:
        return np.concatenate(values) if values else np.empty((0, width), kind)

    return {
        "pair_row": of([p.row for p in pairs], 2, np.int64),
        "pair_frame": np.concatenate([p.frame for p in pairs]) if pairs else np.empty(0, np.int64),
        "pair_statistic": of([p.statistic for p in pairs], lanes, np.float64),
        "pair_probability": of([p.probability for p in pairs], lanes, np.float64),
        "pair_decision": of([p.decision for p in pairs], lanes, np.int64),
    }


class _Filled:
    """Arrays of the marks, filled look by look."""

    def __init__(self, marks: int, lanes: int) -> None:
        self.decision = np.full((marks, lanes), ALONE)
        self.group = np.zeros((marks, lanes), np.int64)
        self.probability = np.full((marks, lanes), np.nan)
        self.alone = np.full((marks, lanes), np.nan)
        self.statistic = np.full((marks, lanes), np.nan)
        self.position = np.full((marks, 2, lanes), np.nan)
        self.fused = np.full((marks, 2, lanes), np.nan)
        self.covariance = np.full((marks, 3, lanes), np.nan)

    def arrays(self) -> dict[str, NDArray[np.generic]]:
        """As the outputs are declared."""
        return {
            "decision": self.decision,
            "group": self.group,
            "probability": self.probability,
            "alone_probability": self.alone,
            "statistic": self.statistic,
            "position_m": self.position,
            "fused_m": self.fused,
            "fused_covariance_m2": self.covariance,
        }

    def take(
        self,
        recording: PolarPlots,
        parameters: PairParameters,
        rows: tuple[Ints, Ints],
        sides: tuple[Side, Side],
        found: PairStatistics,
        decided: Decided,
    ) -> None:
        """Put one look in. Plots that are one target get the number of the row of their anchor."""
        anchor = 0 if parameters.reading == "A" else 1
        for s in (0, 1):
            own, partner, best = rows[s], decided.partner[s], decided.best[s]
            points = points_of(sides[s], parameters.conversion)
            self.position[own] = np.stack([points.x, points.y], axis=1)
            here = np.isfinite(sides[s].range_m)
            self.decision[own] = np.where(here, decided.decision[s], self.decision[own])
            statistic = found.statistic if s == 0 else np.swapaxes(found.statistic, 0, 1)
            self.statistic[own] = _of_partner(statistic, best)
            if decided.pairs is not None:
                pairs = decided.pairs if s == 0 else np.swapaxes(decided.pairs, 0, 1)
                alone = np.where(here, np.clip(1 - pairs.sum(axis=1), 0.0, 1.0), np.nan)
                self.alone[own] = alone
                self.probability[own] = np.where(best >= 0, _of_partner(pairs, best), alone)
            place, covariance = fused(sides[s], sides[1 - s], parameters.conversion, partner)
            self.fused[own], self.covariance[own] = place, covariance
            number = recording.row[own][:, None]
            theirs = recording.row[rows[1 - s]]
            if s == anchor:
                group = np.where(partner >= 0, number, 0)
            elif theirs.size:
                group = np.where(partner >= 0, theirs[np.maximum(partner, 0)], 0)
            else:
                group = np.zeros(partner.shape, np.int64)
            self.group[own] = group

    def accepted(self, rows: tuple[Ints, Ints], sides: tuple[Side, Side], decided: Decided) -> Accepted:
        """Return the accepted pairs of the first trial for the test of the registration."""
        i = np.flatnonzero(decided.partner[0][:, 0] >= 0)
        j = decided.partner[0][i, 0]
        points = [points_of(side, "mucm") for side in sides]
        place = [np.stack([p.x[k, 0], p.y[k, 0]], axis=1) for p, k in zip(points, (i, j), strict=True)]
        covariance = [
            np.stack([p.xx[k, 0], p.yy[k, 0], p.xy[k, 0]], axis=1) for p, k in zip(points, (i, j), strict=True)
        ]
        return Accepted(
            place[0] - place[1],
            covariance[0] + covariance[1],
            place[0] - sides[0].site,
            place[1] - sides[1].site,
            np.full((i.size, 2), np.nan),
        )


def _of_partner(values: Floats, partner: Ints) -> Floats:
    """(n, L) from (n, m, L): the value of each row's partner, NaN where it has none."""
    if not values.shape[1]:
        return np.full(partner.shape, np.nan)
    taken = np.take_along_axis(values, np.maximum(partner, 0)[:, None], axis=1)[:, 0]
    out: Floats = np.where(partner >= 0, taken, np.nan)
    return out


def _notes(
    plots: Plots,
    recording: PolarPlots,
    radars: tuple[int, int],
    unsettled: int,
    ranked: int,
    truncation: float,
    total: int,
) -> list[Note]:
    out = []
    bad = sum(1 for word in plots.bad if word)
    if bad:
        out.append(Note("unusable_plots", "Plots without a usable range or azimuth are left out; see decisions.", bad))
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
    if ranked:
        out.append(
            Note(
                "ranked_matchings",
                "Groups too large for the sum over all matchings are summed over the most likely ones; no probability "
                f"is wrong by more than {truncation:.2g}.",
                ranked,
            )
        )
    if total > KEPT_PAIRS:
        out.append(
            Note("pairs_not_kept", "Pairs that cannot belong together in any trial are not listed one by one.", total)
        )
    apart = _largest_delay(recording, plots, radars)
    if apart > 0:
        out.append(
            Note(
                "not_simultaneous",
                f"Plots of one look are up to {apart:.3g} s apart, and a moving target goes on meanwhile: 1 s at "
                "250 m/s shifts a pair by 250 m. Nothing is extrapolated; track_association does it.",
            )
        )
    return out


def _largest_delay(recording: PolarPlots, plots: Plots, radars: tuple[int, int]) -> float:
    largest = 0.0
    for look in plots.looks:
        a, b = (recording.time_s[look.rows[r]] for r in radars)
        if a.size and b.size:
            largest = max(largest, float(max(a.max() - b.min(), b.max() - a.min())))
    return largest


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


__all__ = [
    "ACCEPTED",
    "Decided",
    "chosen_radars",
    "compare",
    "judged",
    "pair_decisions",
    "partners_both_ways",
    "side_of",
]
