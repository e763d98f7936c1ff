"""What is counted of the decisions on simulated plots, look by look and target by target (specification 4, 12).

A target counts where both radars detected it. Its anchor is its plot in the radar that looks for a partner:
*correct* where the right partner is taken, *wrong* where another one is, else *undecided*. Recall is the share of pairs
that exist and were accepted, precision the share of accepted pairs that exist.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.scenario import CLUTTER
from algorithms.recording import PolarPlots
from algorithms.scores import Floats, Ints, Sample, Scores, Tally

Bools = NDArray[np.bool_]
DOF = 2


@dataclass(frozen=True)
class Judged:
    """One look: n anchors, m possible partners, L trials.

    Attributes
    ----------
    time_s : of the look
    anchors, others : rows in the recording
    statistic : (n, m, L)
    partner : (n, L) accepted partner, -1 = none
    several : (n, L) undecided because of several, else because of none
    best : (n, L) most likely partner, -1 = none; None where there is none
    pairs : (n, m, L) probabilities, or None
    ties : (n, L) or None
    place, covariance : (n, 2, L), (n, 3, L) fused with the accepted partner
    own_place, own_covariance : the same of the anchor's plot by itself; None where nothing is converted
    """

    time_s: float
    anchors: Ints
    others: Ints
    statistic: Floats
    partner: Ints
    several: Bools
    best: Ints | None
    pairs: Floats | None
    ties: Bools | None
    place: Floats
    covariance: Floats
    threshold: float
    own_place: Floats | None = None
    own_covariance: Floats | None = None


def targets_of(recording: PolarPlots) -> tuple[str, ...]:
    """Names of the true targets, without that of the false plots."""
    return tuple(name for name in recording.targets if name != CLUTTER)


def true_partners(recording: PolarPlots, anchors: Ints, others: Ints) -> tuple[Ints, Ints]:
    """(n,) target of each anchor or -1, and (n,) the position of its right partner or -1."""
    known = np.array([name not in ("", CLUTTER) for name in recording.targets])
    target = np.where(known[recording.target[anchors]], recording.target[anchors], -1)
    own = recording.target[others]
    right = np.full(anchors.size, -1)
    for i, t in enumerate(target):
        where = np.flatnonzero(own == t) if t >= 0 else np.empty(0, np.int64)
        if where.size:
            right[i] = where[0]
    return target, right


def score_looks(recording: PolarPlots, looks: list[Judged]) -> Scores:
    """Count everything; one instant for each look and target."""
    lanes = recording.range_m.shape[1]
    parts: dict[str, list[Floats]] = {}
    time: list[float] = []
    target: list[int] = []
    accepted, right_accepted = np.zeros(lanes), np.zeros(lanes)
    for look in looks:
        truth, right = true_partners(recording, look.anchors, look.others)
        accepted += (look.partner >= 0).sum(axis=0)
        right_accepted += ((look.partner >= 0) & (look.partner == right[:, None])).sum(axis=0)
        for a in np.flatnonzero((truth >= 0) & (right >= 0)):
            for name, values in _one(recording, look, int(a), int(right[a])).items():
                parts.setdefault(name, []).append(values)
            time.append(look.time_s)
            target.append(int(truth[a]))
    empty = np.empty((0, lanes))
    of = {name: np.stack(values) for name, values in parts.items()}

    def got(name: str) -> Floats:
        return of.get(name, empty)

    both = got("both")
    tallies = [
        Tally("probability_correct", "1", got("correct"), both, curve=True, compared=True, share=True),
        Tally("probability_wrong", "1", got("wrong"), both, curve=True, compared=True, share=True),
        Tally("probability_undecided", "1", got("undecided"), both, curve=True, compared=True, share=True),
        Tally("probability_undecided_none", "1", got("none"), both, share=True),
        Tally("probability_undecided_several", "1", got("several"), both, share=True),
        Tally("false_rejection", "1", got("rejected"), both, compared=True, share=True),
        Tally("recall", "1", got("correct"), both, compared=True, share=True),
        Tally("precision", "1", right_accepted, accepted, share=True),
        Tally("nis", "1", got("statistic"), DOF * both, curve=True, chi_square=True),
        Tally("rms_horizontal_m", "m", got("error"), got("fused"), root=True, compared=True),
        Tally("claimed_horizontal_m", "m", got("claim"), got("fused"), root=True),
        Tally("nees", "1", got("nees"), DOF * got("fused"), chi_square=True),
    ]
    samples = [
        Sample("statistic_same", "1", got("same").astype(np.float32)),
        Sample("statistic_other", "1", got("other").astype(np.float32)),
    ]
    if looks and looks[0].best is not None:
        tallies.insert(6, Tally("assignment_correct", "1", got("assigned"), both, compared=True, share=True))
        samples += [
            Sample("stated_probability", "1", got("stated").astype(np.float32)),
            Sample("stated_right", "1", got("stated_right").astype(np.float32)),
        ]
    if looks and looks[0].own_place is not None:
        tallies.append(Tally("plot_nees", "1", got("own_nees"), DOF * both, compared=True))
    names = targets_of(recording) or ("",)
    order = np.argsort(np.array(time), kind="stable") if time else np.empty(0, np.int64)
    return Scores(
        tuple(_sorted(t, order) for t in tallies),
        tuple(Sample(s.name, s.unit, s.values[order], s.curve) for s in samples),
        np.array(time)[order] if time else np.empty(0),
        np.array(target, np.int64)[order],
        names,
    )


def _sorted(tally: Tally, order: Ints) -> Tally:
    if tally.per_trial:
        return tally
    return Tally(
        tally.metric, tally.unit, tally.numerator[order], tally.denominator[order], tally.root, tally.curve,
        tally.compared, tally.chi_square, tally.share,
    )  # fmt: skip


def normalised(error: Floats, covariance: Floats) -> Floats:
    """(L,) squared errors (2, L) over their covariances xx, yy, xy (3, L)."""
    xx, yy, xy = covariance
    squared: Floats = (yy * error[0] ** 2 - 2 * xy * error[0] * error[1] + xx * error[1] ** 2) / (xx * yy - xy * xy)
    return squared


def _one(recording: PolarPlots, look: Judged, a: int, right: int) -> dict[str, Floats]:
    """What is counted of one target at one look, each (L,)."""
    same = look.statistic[a, right]
    both = np.isfinite(same)
    partner = look.partner[a]
    correct, wrong = both & (partner == right), both & (partner >= 0) & (partner != right)
    undecided = both & (partner < 0)
    several = undecided & look.several[a]
    place = look.place[a] - recording.truth_m[look.anchors[a], :2, None]
    fused = correct & np.isfinite(place[0])
    nees = normalised(place, look.covariance[a])
    others = np.delete(look.statistic[a], right, axis=0)
    nearest = np.where(np.isfinite(others), others, np.inf).min(axis=0) if len(others) else np.full(same.shape, np.inf)
    out = {
        "both": both,
        "correct": correct,
        "wrong": wrong,
        "undecided": undecided,
        "none": undecided & ~several,
        "several": several,
        "rejected": both & (same > look.threshold),
        "statistic": np.where(both, same, 0.0),
        "error": np.where(fused, place[0] ** 2 + place[1] ** 2, 0.0),
        "claim": np.where(fused, look.covariance[a, 0] + look.covariance[a, 1], 0.0),
        "nees": np.where(fused, nees, 0.0),
        "fused": fused,
        "same": np.where(both, same, np.nan),
        "other": np.where(both & np.isfinite(nearest), nearest, np.nan),
    }
    if look.own_place is not None and look.own_covariance is not None:
        own = normalised(look.own_place[a] - recording.truth_m[look.anchors[a], :2, None], look.own_covariance[a])
        out["own_nees"] = np.where(both, own, 0.0)
    if look.best is not None and look.pairs is not None and look.ties is not None:
        best = look.best[a]
        assigned = np.where(look.ties[a], 0.5, 1.0) * (best == right)
        # A tie may list the wrong one of two equals first.
        equal = look.ties[a] & (best >= 0) & (best != right)
        share = np.take_along_axis(look.pairs[a], np.maximum(best, 0)[None], axis=0)[0]
        assigned = np.where(equal & (np.abs(look.pairs[a, right] - share) < 1e-12), 0.5, assigned)
        stated = both & (best >= 0)
        out |= {
            "assigned": np.where(both, assigned, 0.0),
            "stated": np.where(stated, share, np.nan),
            "stated_right": np.where(stated, best == right, np.nan),
        }
    return {name: np.asarray(values, float) for name, values in out.items()}
