"""One scan of the paper's tracker: plots to tracks, Q and histories, births and deaths; trials side by side.

Differences from the paper, each a choice in `Rules`: a plot outside the outer ellipse and a missed scan make Q = 2 for
the next gate (the paper is silent, and its literal reading loses every second turning target); the history is bounded;
the order of the three stages is tracks with three plots, then two, then one, each on the plots that are still free.

References
----------
plots2006, section 2; specification 6.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking import gates
from algorithms.plot_tracking.base_points import fit_by_base_points
from algorithms.plot_tracking.curve_fit import CURVE_PLOTS, FREE, LINE, Limits, fit, is_sound
from algorithms.plot_tracking.line_fit import fit_line
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.track_table import TrackTable
from algorithms.plot_tracking.window import Fit, Window, covariance_of
from algorithms.toolbox.association.sparse import most_pairs_at_least_cost, pairs_within
from algorithms.toolbox.motion.curvature import position, position_jacobian, wrapped

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MISSED_AFTER = 1.5
"""A track whose last plot is older than so many periods has missed a scan."""
COASTING_GATE = 3.0
"""So many times wider is the exact gate of a track that has missed a scan."""
MISS_LIMITS = (1, 2, 3, 5)
"""Scans missed in a row that delete a track with one plot, with two, unconfirmed, confirmed."""

STARTED, SECOND, ACQUIRED, INNER, MIDDLE, MANOEUVRE = range(1, 7)
"""What a plot was to its track."""


@dataclass(frozen=True)
class Rules:
    """Everything about the tracker that can be chosen."""

    sigma_r: float
    sigma_th: float
    period_s: float
    limits: Limits = field(default_factory=Limits)
    confidences: tuple[float, float, float] = gates.CONFIDENCES
    gate_law: str = "paper"
    predictor: str = "ml6"
    cost: str = "likelihood_ratio"
    reset_on_miss: bool = True
    kept_plots: int = 4
    history_plots: int = 13
    confirm_plots: int = 4
    least_across_m: float = 50.0
    """Near the radar the azimuth loses its meaning: the error across the ray is never taken smaller."""

    def sigma_theta(self, rho: Floats) -> Floats:
        """Standard deviation of an azimuth at a range, rad."""
        out: Floats = np.maximum(self.sigma_th, self.least_across_m / np.maximum(rho, 1.0))
        return out


@dataclass
class Taken:
    """What became of the plots of one scan; arrays (P,)."""

    owner: Ints
    """position of its track in the table of before, -1 = none"""
    role: Ints
    """`STARTED` ... `MANOEUVRE`"""
    distance: Floats
    """D^2, or the squared share of the radius of a start or acquisition gate"""
    rivals: Ints
    """tracks in whose gate it lay"""
    number: Ints
    """of the track, 0 = none yet"""
    at: Ints
    """position of its track in the table of afterwards, -1 = none"""
    pairs: list[tuple[int, Ints, Ints, Floats]] = field(default_factory=list)
    """of each stage: its number, and track (in the table of before), plot and distance of every pair inside a gate"""
    areas: list[tuple[int, Ints, Floats, Floats]] = field(default_factory=list)
    """of each stage: its number, tracks, centres (T, 2) and covariances (T, 2, 2) times the squared radius"""
    after: Ints = field(default_factory=lambda: np.empty(0, np.int64))
    """(T,) where each track of before stands afterwards, -1 = it ended"""

    @classmethod
    def of(cls, plots: int) -> Taken:
        """Nothing has become of them yet."""
        zero = np.zeros(plots, np.int64)
        return cls(zero - 1, zero.copy(), np.full(plots, np.nan), zero.copy(), zero.copy(), zero - 1)

    @property
    def free(self) -> Ints:
        """Positions of plots that no track has taken."""
        return np.flatnonzero(self.owner < 0)


@dataclass(frozen=True)
class Ending:
    """Tracks that were deleted in a scan."""

    lane: Ints
    number: Ints
    last_s: Floats
    confirmed: NDArray[np.bool_]
    misses: Ints


def advance(tracks: TrackTable, scan: Scan, rules: Rules, next_number: Ints) -> tuple[TrackTable, Taken, Ending]:
    """Give the plots of a scan to tracks and return the tracks that live on; `next_number` (L,) moves on."""
    taken = Taken.of(scan.rho.size)
    # What a track was before the scan decides its stage: nobody is acquired and followed at once.
    stages = np.minimum(tracks.plots, 3)
    followed = np.flatnonzero(stages == 3)
    taken.areas.append((3, followed, *_areas(tracks, followed, scan, rules)))
    for stage, circle in ((2, _acquisition_circle), (1, _start_circle)):
        which = np.flatnonzero(stages == stage)
        (north, east), radius = circle(tracks, which, scan, rules)
        shape = radius[:, None, None] ** 2 * np.eye(2)
        taken.areas.append((stage, which, np.stack([east, north], axis=1), shape))
    for stage, offer in ((3, _offer_follow), (2, _offer_acquisition), (1, _offer_second)):
        which = np.flatnonzero(stages == stage)
        track, plot, distance, cost = offer(tracks, which, scan, taken.free, rules)
        np.add.at(taken.rivals, plot, 1)
        taken.pairs.append((stage, track, plot, distance))
        chosen = most_pairs_at_least_cost(track, plot, cost)
        _give(tracks, track[chosen], plot[chosen], distance[chosen], scan, taken, stage, rules)
    hit = np.zeros(len(tracks), bool)
    hit[taken.owner[taken.owner >= 0]] = True
    tracks.misses[~hit] += 1
    tracks.confirmed |= tracks.hits >= rules.confirm_plots
    _number(tracks, next_number)
    _refit(tracks, np.flatnonzero(hit & (tracks.plots >= 3)), rules)
    limit = np.where(tracks.confirmed, MISS_LIMITS[3], np.array(MISS_LIMITS)[np.minimum(tracks.plots, 3) - 1])
    dies = tracks.misses >= limit
    ending = Ending(
        tracks.lane[dies], tracks.number[dies], tracks.last_s[dies], tracks.confirmed[dies], tracks.misses[dies]
    )
    owned = taken.owner >= 0
    taken.number[owned] = tracks.number[taken.owner[owned]]
    starting = taken.free
    taken.role[starting] = STARTED
    # Where each plot's track stands afterwards.
    after = np.where(dies, -1, np.cumsum(~dies) - 1)
    taken.after = after
    taken.at[owned] = after[taken.owner[owned]]
    taken.at[starting] = int((~dies).sum()) + np.arange(starting.size)
    return tracks.take(~dies).joined(TrackTable.starting_from(scan, starting, rules.history_plots)), taken, ending


Circle = tuple[tuple[Floats, Floats], Floats]
"""North and east of the centres, radii, m."""
Offer = tuple[Ints, Ints, Floats, Floats]
"""Pairs inside gates: track, plot (positions in table and scan), distance, cost."""


def _offer_follow(tracks: TrackTable, which: Ints, scan: Scan, free: Ints, rules: Rules) -> Offer:
    """Pairs inside the outer tracking ellipse; cost: -L, or D^2 + ln det S with the exact gate."""
    ahead = scan.time_s - tracks.last_s[which]
    rho, theta = _polar(tracks.p[:, which], ahead)
    q, m = _gate_factor(tracks, which, scan.time_s, rules)
    outer = float(gates.radius_of(np.array(rules.confidences[2])))
    reach = outer * m * rules.sigma_r
    spread = _innovation(tracks, which, ahead, rules) if rules.gate_law == "exact" else None
    if spread is not None:
        wider = np.where(_missed(tracks, which, scan.time_s, rules), COASTING_GATE**2, 1.0)
        spread = (wider * spread[0], wider * spread[1], wider * spread[2])
        reach = outer * np.sqrt(spread[0])
    sweep = float(np.abs(scan.t - scan.time_s).max(initial=0.0))
    reach = reach + sweep * np.abs(tracks.p[3, which])
    i, j = pairs_within(tracks.lane[which], rho - reach, rho + reach, scan.lane[free], scan.rho[free])
    plot = free[j]
    if spread is None and sweep == 0.0:
        # Most of what lies at the range of a track is on another bearing, and needs no prediction of its own.
        near = np.abs(wrapped(scan.theta[plot] - theta[i])) <= (outer * m * rules.sigma_theta(rho))[i] * (1.0 + 1e-9)
        i, plot = i[near], plot[near]
    at = scan.t[plot] - tracks.last_s[which[i]]
    pair = _polar(tracks.p[:, which[i]], at)
    across = rules.sigma_theta(pair[0])
    if spread is None:
        d2 = gates.squared_distance(scan.rho[plot], scan.theta[plot], pair, rules.sigma_r, across, m[i])
        cost = -gates.log_likelihood_ratio(d2, q[i]) if rules.cost == "likelihood_ratio" else d2 + 4.0 * np.log(m[i])
    else:
        rr, rt, tt = (s[i] for s in spread)
        dr, dt = scan.rho[plot] - pair[0], wrapped(scan.theta[plot] - pair[1])
        determinant = rr * tt - rt * rt
        d2 = (tt * dr * dr - 2.0 * rt * dr * dt + rr * dt * dt) / determinant
        cost = d2 + np.log(determinant)
    inside = np.flatnonzero(d2 <= outer**2)
    return which[i[inside]], plot[inside], d2[inside], cost[inside]


def _areas(tracks: TrackTable, which: Ints, scan: Scan, rules: Rules) -> tuple[Floats, Floats]:
    """Centres (T, 2) and shapes (T, 2, 2) of the outer ellipses, east and north."""
    ahead = scan.time_s - tracks.last_s[which]
    rho, theta = _polar(tracks.p[:, which], ahead)
    _, m = _gate_factor(tracks, which, scan.time_s, rules)
    outer = float(gates.radius_of(np.array(rules.confidences[2])))
    if rules.gate_law == "exact":
        wider = np.where(_missed(tracks, which, scan.time_s, rules), COASTING_GATE**2, 1.0)
        rr, rt, tt = (wider * part for part in _innovation(tracks, which, ahead, rules))
    else:
        rr, rt, tt = (rules.sigma_r * m) ** 2, np.zeros(which.size), (rules.sigma_theta(rho) * m) ** 2
    sin, cos = np.sin(theta), np.cos(theta)
    # Along the ray and across it, in the order of east and north.
    to = np.array([[sin, rho * cos], [cos, -rho * sin]])
    shape = outer**2 * np.einsum("imt,mnt,jnt->tij", to, np.array([[rr, rt], [rt, tt]]), to)
    return np.stack([rho * sin, rho * cos], axis=1), shape


def _gate_factor(tracks: TrackTable, which: Ints, now_s: float, rules: Rules) -> tuple[Ints, Floats]:
    """Q that counts for the gate, and m."""
    q = tracks.q[which]
    periods = np.maximum(np.round((now_s - tracks.seen_s[which]) / rules.period_s), 1.0)
    missed = _missed(tracks, which, now_s, rules)
    if rules.reset_on_miss:
        q = np.where(missed, gates.LEAST_Q, q)
    ratio = gates.variance_ratio(q)
    m = ratio if rules.gate_law == "paper" else np.sqrt(ratio)
    if not rules.reset_on_miss:
        m = m * np.where(missed, np.sqrt(gates.line_variance_ratio(q, periods) / ratio), 1.0)
    return q, m


def _missed(tracks: TrackTable, which: Ints, now_s: float, rules: Rules) -> NDArray[np.bool_]:
    """Whether a track has no plot in the scan before this one."""
    out: NDArray[np.bool_] = now_s - tracks.seen_s[which] > MISSED_AFTER * rules.period_s
    return out


def _innovation(tracks: TrackTable, which: Ints, ahead: Floats, rules: Rules) -> tuple[Floats, Floats, Floats]:
    """Covariance of a plot's range and azimuth about the prediction: variances and what is common, (T,) each."""
    p, information = tracks.p[:, which], tracks.information[:, :, which]
    covariance = np.zeros_like(information)
    straight = information[5, 5] == 0
    line = np.flatnonzero(straight)
    covariance[:4, :4, line] = covariance_of(information[:4, :4, line])
    curved = np.flatnonzero(~straight)
    covariance[:, :, curved] = covariance_of(information[:, :, curved])
    x, y, dx, dy = position_jacobian(p, ahead)
    rho = np.hypot(x, y)
    to_rho = (x * dx + y * dy) / rho
    to_theta = (x * dy - y * dx) / rho**2
    rr, rt, tt = np.zeros_like(rho), np.zeros_like(rho), np.zeros_like(rho)
    for i in range(6):
        for j in range(6):
            rr = rr + to_rho[i] * covariance[i, j] * to_rho[j]
            rt = rt + to_rho[i] * covariance[i, j] * to_theta[j]
            tt = tt + to_theta[i] * covariance[i, j] * to_theta[j]
    return rr + rules.sigma_r**2, rt, tt + rules.sigma_theta(rho) ** 2


def _offer_acquisition(tracks: TrackTable, which: Ints, scan: Scan, free: Ints, rules: Rules) -> Offer:
    """Pairs within the acquisition circle."""
    return _offer_circle(tracks, which, scan, free, *_acquisition_circle(tracks, which, scan, rules))


def _acquisition_circle(tracks: TrackTable, which: Ints, scan: Scan, rules: Rules) -> Circle:
    """Around the straight continuation of two plots."""
    rho, theta, t = tracks.rho[-2:, which], tracks.theta[-2:, which], tracks.t[-2:, which]
    x, y = rho * np.cos(theta), rho * np.sin(theta)
    step = (scan.time_s - t[1]) / (t[1] - t[0])
    centre = x[1] + (x[1] - x[0]) * step, y[1] + (y[1] - y[0]) * step
    across = rules.sigma_theta(np.hypot(*centre))
    return centre, np.maximum(*gates.acquisition_axes(np.hypot(*centre), np.full(which.size, rules.sigma_r), across))


def _offer_second(tracks: TrackTable, which: Ints, scan: Scan, free: Ints, rules: Rules) -> Offer:
    """Pairs within the start circle."""
    return _offer_circle(tracks, which, scan, free, *_start_circle(tracks, which, scan, rules))


def _start_circle(tracks: TrackTable, which: Ints, scan: Scan, rules: Rules) -> Circle:
    """Around a single plot."""
    rho, theta = tracks.rho[-1, which], tracks.theta[-1, which]
    across = rules.sigma_theta(rho)
    way = rules.limits.max_speed_mps * (scan.time_s - tracks.last_s[which])
    radius = np.maximum(*gates.start_axes(rho, way, np.full(which.size, rules.sigma_r), across))
    return (rho * np.cos(theta), rho * np.sin(theta)), radius


def _offer_circle(
    tracks: TrackTable, which: Ints, scan: Scan, free: Ints, centre: tuple[Floats, Floats], radius: Floats
) -> Offer:
    rho = np.hypot(*centre)
    i, j = pairs_within(tracks.lane[which], rho - radius, rho + radius, scan.lane[free], scan.rho[free])
    plot = free[j]
    x, y = scan.rho[plot] * np.cos(scan.theta[plot]), scan.rho[plot] * np.sin(scan.theta[plot])
    share = ((x - centre[0][i]) ** 2 + (y - centre[1][i]) ** 2) / radius[i] ** 2
    inside = np.flatnonzero(share <= 1.0)
    return which[i[inside]], plot[inside], share[inside], share[inside]


def _give(
    tracks: TrackTable, track: Ints, plot: Ints, distance: Floats, scan: Scan, taken: Taken, stage: int, rules: Rules
) -> None:
    """Put plots into their tracks: Q, histories, roles."""
    taken.owner[plot] = track
    taken.distance[plot] = distance
    if stage < 3:
        taken.role[plot] = SECOND if stage == 1 else ACQUIRED
        if stage == 1:
            tracks.second[track] = scan.position[plot]
        tracks.append(track, scan, plot)
        return
    of_class = np.minimum(gates.classes(distance, rules.confidences), 2)
    taken.role[plot] = INNER + of_class
    tracks.q[track] = gates.counted(tracks.q[track], of_class)
    tracks.keep_newest(track[of_class == 2], rules.kept_plots - 1)
    tracks.append(track, scan, plot)


def _number(tracks: TrackTable, next_number: Ints) -> None:
    """Give tracks with their third plot the next number of their trial, in the order of the table."""
    new = np.flatnonzero((tracks.plots >= 3) & (tracks.number == 0))
    for i in new.tolist():
        tracks.number[i] = next_number[tracks.lane[i]]
        next_number[tracks.lane[i]] += 1


def _refit(tracks: TrackTable, which: Ints, rules: Rules) -> None:
    """New trajectories of the tracks that took a plot."""
    if not which.size:
        return
    window = tracks.window(which, rules.sigma_r, rules.sigma_theta)
    if rules.predictor == "line":
        found, how = fit_line(window), np.full(which.size, LINE)
    elif rules.predictor == "base_points":
        found, how = _by_base_points(window, rules)
    else:
        found, how = fit(window, rules.limits, penalised=rules.predictor == "map6")
    tracks.p[:, which], tracks.information[:, :, which], tracks.how[which] = found.p, found.information, how


def _by_base_points(window: Window, rules: Rules) -> tuple[Fit, Ints]:
    """The free fit in the coordinates of three base plots; what does not converge there is held as ever."""
    out, how = fit(window, rules.limits, penalised=True)
    curved = np.flatnonzero(window.plots >= CURVE_PLOTS)
    part = window.take(curved)
    found, _ = fit_by_base_points(part)
    sound = is_sound(part, found, rules.limits)
    out.put(curved[sound], found.take(np.flatnonzero(sound)))
    how[curved[sound]] = FREE
    return out, how


def _polar(p: Floats, t: Floats) -> tuple[Floats, Floats]:
    x, y = position(p, t)
    return np.hypot(x, y), np.arctan2(y, x)
