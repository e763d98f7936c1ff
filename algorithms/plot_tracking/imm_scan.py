"""One scan of the recommended tracker: tracks with numbers first, then those with two plots, then single plots.

Differences from the paper: gates come from the filters' covariances; a confirmed track lives as long as
`Rules.drop_after` antenna periods by time; a pair costs -2 ln of its likelihood, D^2 + ln det S for one model, so that
an uncertain track has no advantage.

References
----------
barshalom2001, section 11.6; specification 9.1 and 9.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from algorithms.plot_tracking.gates import start_axes
from algorithms.plot_tracking.imm_filter import POSITION, Bank, begun, predicted, updated, updated_by_many
from algorithms.plot_tracking.imm_rules import Clutter, Identity, Offer, Rules, Taken
from algorithms.plot_tracking.imm_tracks import ImmTracks
from algorithms.plot_tracking.joint_association import joint_probabilities
from algorithms.plot_tracking.plots import Scan
from algorithms.toolbox.association.sparse import most_pairs_at_least_cost, pairs_within
from algorithms.toolbox.tracks.life_cycle import periods_missed

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MISS_LIMITS = (1, 2, 3)
"""Periods missed that end a track with one plot, with two, unconfirmed."""
# An agreement of addresses or callsigns is worth so much in D^2: more than the gate, so that it always decides.
AGREEMENT = 30.0
# Altitudes contradict each other beyond their errors and what is climbed at the fastest.
ALTITUDE_SPREAD_M, CLIMB_MPS = 150.0, 60.0
# Within that they speak for the nearer one: errors of a coded altitude, usual climbs, and where altitudes lie.
CODED_SD_M, CLIMB_SD_MPS, ALTITUDES_M = 30.0, 15.0, 12_000.0
# A plot with more than this probability to be a track's is no start of another.
TAKEN_BETA = 0.05
# Two tracks nearer than this share of a plot's error, in place and in what they move in a period, are the same.
TWIN_SHARE, TWIN_SCANS = 0.5, 5
LEAST_STEP_S = 1e-3
LARGEST_DETECTION = 0.999


def plot_covariances(east: Floats, north: Floats, rules: Rules) -> Floats:
    """(P, 2, 2) m2 of plots at these places: the errors along and across the ray, turned."""
    rho = np.maximum(np.hypot(east, north), 1.0)
    s, c = east / rho, north / rho
    along, across = rules.sigma_r**2, np.maximum(rho * rules.sigma_th, rules.across_m) ** 2
    out = np.empty((rho.size, 2, 2))
    out[:, 0, 0] = along * s * s + across * c * c
    out[:, 1, 1] = along * c * c + across * s * s
    out[:, 0, 1] = out[:, 1, 0] = (along - across) * s * c
    return out


def advance(
    tracks: ImmTracks, scan: Scan, identity: Identity, rules: Rules, clutter: Clutter, next_number: Ints
) -> Taken:
    """Give the plots of a scan to tracks, in place; `next_number` (L,) moves on. Tracks begin and end elsewhere."""
    z = np.stack([scan.rho * np.sin(scan.theta), scan.rho * np.cos(scan.theta)], axis=1)
    r = plot_covariances(z[:, 0], z[:, 1], rules)
    taken = Taken.of(scan.rho.size)
    at = _instants(tracks, scan, z)
    stages = np.minimum(tracks.plots, 3)
    hit = np.zeros(len(tracks), bool)
    for stage in (3, 2):
        which = np.flatnonzero(stages == stage)
        if not (which.size and taken.free.size):
            continue
        ahead = predicted(
            tracks.bank.take(which), np.maximum(at[which] - tracks.epoch_s[which], LEAST_STEP_S), rules.motion
        )
        s, wide = _gate(tracks, which, ahead, scan, rules)
        taken.areas.append((stage, which, ahead.x[..., POSITION], s * wide[:, None, None, None] ** 2))
        offer = _offer(tracks, which, ahead, (s, wide), at, scan, z, taken.free, identity)
        np.add.at(taken.rivals, offer.plot, 1)
        taken.pairs.append((stage, offer.track, offer.plot, np.sqrt(offer.d2)))
        score = _scores(tracks, offer, rules, clutter)
        if stage == 3 and rules.joint:
            _share(tracks, which, ahead, at, scan, z, r, offer, score, rules, taken, hit)
        else:
            # What is more probably a missed target and a false plot is no pair.
            offer = offer.take(np.flatnonzero(score > 0)) if stage == 3 else offer
            _give(tracks, which, ahead, at, scan, z, r, offer, taken, stage, hit)
    _second_plots(tracks, np.flatnonzero(stages == 1), scan, z, r, identity, rules, taken, hit)
    took = np.flatnonzero(hit)
    tracks.plots[took] += 1
    tracks.seen_s[took] = scan.time_s
    tracks.misses[:] = periods_missed(scan.time_s, tracks.seen_s, rules.period_s)
    tracks.misses[took] = 0
    _remember(tracks, scan, identity, taken)
    tracks.confirmed |= tracks.plots >= rules.confirm_plots
    for i in np.flatnonzero((tracks.plots >= 3) & (tracks.number == 0)).tolist():
        tracks.number[i] = next_number[tracks.lane[i]]
        next_number[tracks.lane[i]] += 1
    owned = np.where(taken.owner >= 0, tracks.confirmed[taken.owner], False) if len(tracks) else taken.owner >= 0
    clutter.learn(scan.lane[~owned & ~taken.shared])
    return taken


def limits_of(tracks: ImmTracks, rules: Rules) -> Ints:
    """(T,) missed periods that end each track."""
    return np.where(tracks.confirmed, rules.drop_after, np.array(MISS_LIMITS)[np.minimum(tracks.plots, 3) - 1])


def twins(tracks: ImmTracks, rules: Rules) -> NDArray[np.bool_]:
    """(T,) whether a numbered track has been the same as an older one for some scans; counts them in place."""
    which = np.flatnonzero(tracks.number > 0)
    same = np.zeros(len(tracks), bool)
    if which.size > 1:
        mean, _ = tracks.bank.take(which).moments()
        here = mean[:, POSITION] + mean[:, [1, 3]] * (tracks.epoch_s[which].max() - tracks.epoch_s[which])[:, None]
        spread = plot_covariances(here[:, 0], here[:, 1], rules)
        near = TWIN_SHARE * np.sqrt(spread[:, 0, 0] + spread[:, 1, 1])
        order = np.lexsort((here[:, 0], tracks.lane[which]))
        sorted_x, sorted_lane = here[order, 0], tracks.lane[which][order]
        i, j = pairs_within(tracks.lane[which], here[:, 0] - near, here[:, 0] + near, sorted_lane, sorted_x)
        j = order[j]
        older = tracks.number[which[j]] < tracks.number[which[i]]
        i, j = i[older], j[older]
        apart = np.hypot(*(here[i] - here[j]).T)
        drift = np.hypot(*(mean[i][:, [1, 3]] - mean[j][:, [1, 3]]).T) * rules.period_s
        same[which[i[(apart < near[i]) & (drift < near[i])]]] = True
    tracks.twin[:] = np.where(same, tracks.twin + 1, 0)
    out: NDArray[np.bool_] = tracks.twin >= TWIN_SCANS
    return out


def _instants(tracks: ImmTracks, scan: Scan, z: Floats) -> Floats:
    """(T,) when the antenna looked at each track: the scan's instant, or that of the plot nearest to its place."""
    if not scan.t.size or np.ptp(scan.t) == 0.0 or not len(tracks):
        return np.full(len(tracks), scan.time_s)
    mean, _ = tracks.bank.moments()
    there = mean[:, POSITION] + mean[:, [1, 3]] * (scan.time_s - tracks.epoch_s)[:, None]
    _, nearest = cKDTree(z).query(there)
    out: Floats = scan.t[nearest]
    return out


def _gate(tracks: ImmTracks, which: Ints, ahead: Bank, scan: Scan, rules: Rules) -> tuple[Floats, Floats]:
    """Covariance of the innovation in each model (T, M, 2, 2), and the radius of the gate (T,)."""
    here = np.einsum("tm,tmi->ti", ahead.mu, ahead.x[..., POSITION])
    s = ahead.p[..., POSITION][..., POSITION, :] + plot_covariances(here[:, 0], here[:, 1], rules)[:, None]
    # A track of nothing lives on false plots: one that is not confirmed is given no more of them when it misses one.
    missed = tracks.confirmed[which] & (scan.time_s - tracks.seen_s[which] > 1.5 * rules.period_s)
    return s, rules.gate * np.where(missed, rules.coasting_gate, 1.0)


def _offer(
    tracks: ImmTracks, which: Ints, ahead: Bank, gate: tuple[Floats, Floats], at: Floats, scan: Scan, z: Floats,
    free: Ints, identity: Identity,
) -> Offer:  # fmt: skip
    """Pairs inside the gate of either model, found along east first.

    The likelihood is that of the mixture. A gate from the mixture's covariance would be too narrow where a manoeuvre
    begins: the turning model foresees it, but has little weight yet.
    """
    mean = ahead.x[..., POSITION]
    here = np.einsum("tm,tmi->ti", ahead.mu, ahead.x)
    s, wide = gate
    half = wide[:, None] * np.sqrt(s[..., 0, 0])
    sweep = np.abs(here[:, 1]) * float(np.ptp(scan.t) if scan.t.size else 0.0)
    low, high = (mean[..., 0] - half).min(axis=1) - sweep, (mean[..., 0] + half).max(axis=1) + sweep
    order = free[np.lexsort((z[free, 0], scan.lane[free]))]
    i, j = pairs_within(tracks.lane[which], low, high, scan.lane[order], z[order, 0])
    plot = order[j]
    # Most of what lies near in east is far in north.
    half = wide[:, None] * np.sqrt(s[..., 1, 1])
    sweep = np.abs(here[:, 3]) * float(np.ptp(scan.t) if scan.t.size else 0.0)
    low, high = (mean[..., 1] - half).min(axis=1) - sweep, (mean[..., 1] + half).max(axis=1) + sweep
    near = np.flatnonzero((z[plot, 1] >= low[i]) & (z[plot, 1] <= high[i]))
    i, plot = i[near], plot[near]
    late = here[i][:, [1, 3]] * (scan.t[plot] - at[which[i]])[:, None]
    nu = (z[plot] - late)[:, None] - mean[i]
    xx, yy, xy = s[i, :, 0, 0], s[i, :, 1, 1], s[i, :, 0, 1]
    determinant = xx * yy - xy * xy
    each = (yy * nu[..., 0] ** 2 - 2.0 * xy * nu[..., 0] * nu[..., 1] + xx * nu[..., 1] ** 2) / determinant
    d2 = each.min(axis=1)
    allowed, agreement = _identity(tracks, which[i], plot, scan, identity)
    keep = np.flatnonzero((d2 <= wide[i] ** 2) & allowed)
    each, d2, agreement = each[keep], d2[keep], agreement[keep]
    share = ahead.mu[i[keep]] / np.sqrt(determinant[keep])
    # The smallest distance is taken out of the sum, so that no exponential vanishes.
    mixture = np.log((share * np.exp(-0.5 * (each - d2[:, None]))).sum(axis=1)) - 0.5 * d2 + 0.5 * agreement
    return Offer(which[i[keep]], plot[keep], d2, -2.0 * mixture, mixture - np.log(2 * np.pi))


def _identity(
    tracks: ImmTracks, track: Ints, plot: Ints, scan: Scan, identity: Identity
) -> tuple[NDArray[np.bool_], Floats]:
    """Whether nothing contradicts a pair, and how much an agreement takes off its cost."""
    allowed, agreement = np.ones(track.size, bool), np.zeros(track.size)
    for name in ("address", "callsign"):
        a, b = getattr(tracks, name)[track], getattr(identity, name)[plot]
        both = (a >= 0) & (b >= 0)
        allowed &= ~both | (a == b)
        agreement = np.where(both & (a == b), AGREEMENT, agreement)
    since = np.abs(scan.time_s - tracks.altitude_s[track])
    apart = tracks.altitude_m[track] - identity.altitude_m[plot]
    known = np.isfinite(apart + since)
    apart, since = np.where(known, apart, 0.0), np.where(known, since, 0.0)
    spread = np.hypot(CODED_SD_M, CLIMB_SD_MPS * since)
    # Twice the logarithm of its likelihood, over that of an altitude that could be any.
    likely = 2.0 * np.log(ALTITUDES_M / (np.sqrt(2 * np.pi) * spread)) - (apart / spread) ** 2
    allowed &= np.abs(apart) <= ALTITUDE_SPREAD_M + CLIMB_MPS * since
    return allowed, agreement + np.where(known, likely, 0.0)


def _scores(tracks: ImmTracks, offer: Offer, rules: Rules, clutter: Clutter) -> Floats:
    """Log-likelihood ratio of a pair against that of a missed target and a false plot, (K,)."""
    detection = min(rules.detection, LARGEST_DETECTION)
    inside = 1.0 - np.exp(-0.5 * rules.gate**2)
    against = np.log(detection) - np.log1p(-detection * inside) - clutter.log_density[tracks.lane[offer.track]]
    scores: Floats = offer.log_likelihood + against
    return scores


def _give(
    tracks: ImmTracks, which: Ints, ahead: Bank, at: Floats, scan: Scan, z: Floats, r: Floats, offer: Offer,
    taken: Taken, stage: int, hit: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Each track its plot, together the nearest; update the filters."""
    chosen = most_pairs_at_least_cost(offer.track, offer.plot, offer.cost)
    track, plot = offer.track[chosen], offer.plot[chosen]
    if not track.size:
        return
    bank = ahead.take(np.searchsorted(which, track))
    moved = _at_instant(bank, z[plot], scan.t[plot] - at[track])
    tracks.bank.put(track, updated(bank, moved, r[plot]))
    tracks.epoch_s[track], tracks.last_s[track] = at[track], scan.t[plot]
    taken.owner[plot], taken.stage[plot] = track, stage
    taken.distance[plot] = np.sqrt(offer.d2[chosen])
    hit[track] = True


def _at_instant(bank: Bank, z: Floats, late: Floats) -> Floats:
    """Plots carried by the predicted velocity to the instant for which their tracks were predicted."""
    if not late.any():
        return z
    mean, _ = bank.moments()
    moved: Floats = z - mean[:, [1, 3]] * late[:, None]
    return moved


def _share(
    tracks: ImmTracks, which: Ints, ahead: Bank, at: Floats, scan: Scan, z: Floats, r: Floats, offer: Offer,
    score: Floats, rules: Rules, taken: Taken, hit: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Every plot in a gate takes part with its probability."""
    found = joint_probabilities(offer.track, offer.plot, score, offer.cost, rules.largest_cluster)
    taken.too_large += found.too_large
    beta = found.beta
    order = np.argsort(offer.track, kind="stable")
    track, first, count = np.unique(offer.track[order], return_index=True, return_counts=True)
    for size in np.unique(count):
        mine = count == size
        pair = order[first[mine][:, None] + np.arange(size)]
        t, plot = track[mine], offer.plot[pair]
        bank = ahead.take(np.searchsorted(which, t))
        mean, _ = bank.moments()
        moved = z[plot] - mean[:, None, [1, 3]] * (scan.t[plot] - at[t][:, None])[:, :, None]
        none = np.maximum(1.0 - beta[pair].sum(axis=1), 0.0)
        tracks.bank.put(t, updated_by_many(bank, moved, r[plot], beta[pair], none))
        tracks.epoch_s[t] = at[t]
        hit[t[none < 0.5]] = True
        tracks.last_s[t[none < 0.5]] = at[t[none < 0.5]]
    best = np.zeros(scan.rho.size)
    np.maximum.at(best, offer.plot, beta)
    winner = np.flatnonzero((beta == best[offer.plot]) & (beta > TAKEN_BETA))
    plot = offer.plot[winner]
    taken.stage[plot], taken.distance[plot] = 3, np.sqrt(offer.d2[winner])
    taken.owner[plot], taken.probability[plot] = offer.track[winner], beta[winner]
    taken.shared[plot] = beta[winner] < 0.5


def _second_plots(
    tracks: ImmTracks, which: Ints, scan: Scan, z: Floats, r: Floats, identity: Identity, rules: Rules, taken: Taken,
    hit: NDArray[np.bool_],
) -> None:  # fmt: skip
    """Single plots within the reach of the largest speed become tracks with a filter."""
    free = taken.free
    if not (which.size and free.size):
        return
    x = tracks.bank.x[which][:, 0, POSITION]
    rho = np.hypot(x[:, 0], x[:, 1])
    across = np.maximum(rho * rules.sigma_th, rules.across_m) / np.maximum(rho, 1.0)
    step = scan.t.max() - tracks.last_s[which]
    radius = np.maximum(*start_axes(rho, rules.max_speed_mps * step, np.full(rho.size, rules.sigma_r), across))
    taken.areas.append((1, which, x[:, None], (radius[:, None, None] ** 2 * np.eye(2))[:, None]))
    order = free[np.lexsort((z[free, 0], scan.lane[free]))]
    i, j = pairs_within(tracks.lane[which], x[:, 0] - radius, x[:, 0] + radius, scan.lane[order], z[order, 0])
    plot = order[j]
    share = ((z[plot] - x[i]) ** 2).sum(axis=1) / radius[i] ** 2
    allowed, _ = _identity(tracks, which[i], plot, scan, identity)
    later = scan.t[plot] - tracks.last_s[which[i]] > 0.2 * rules.period_s
    keep = np.flatnonzero((share <= 1.0) & allowed & later)
    track, plot, share = which[i[keep]], plot[keep], share[keep]
    np.add.at(taken.rivals, plot, 1)
    taken.pairs.append((1, track, plot, np.sqrt(share)))
    chosen = most_pairs_at_least_cost(track, plot, share)
    track, plot = track[chosen], plot[chosen]
    if not track.size:
        return
    first = tracks.bank.x[track][:, 0, POSITION]
    dt = scan.t[plot] - tracks.last_s[track]
    started = begun(first, z[plot], tracks.begun_r[track], r[plot], dt, rules.max_speed_mps, rules.motion)
    tracks.bank.put(track, started)
    tracks.last_s[track] = tracks.epoch_s[track] = scan.t[plot]
    tracks.second[track] = scan.position[plot]
    taken.owner[plot], taken.stage[plot], taken.distance[plot] = track, 1, np.sqrt(share[chosen])
    hit[track] = True


def _remember(tracks: ImmTracks, scan: Scan, identity: Identity, taken: Taken) -> None:
    """Tracks keep the newest address, callsign and altitude of their plots."""
    plot = np.flatnonzero((taken.owner >= 0) & ~taken.shared)
    track = taken.owner[plot]
    for name in ("address", "callsign"):
        said = getattr(identity, name)[plot]
        getattr(tracks, name)[track[said >= 0]] = said[said >= 0]
    known = np.isfinite(identity.altitude_m[plot])
    tracks.altitude_m[track[known]] = identity.altitude_m[plot[known]]
    tracks.altitude_s[track[known]] = scan.t[plot[known]]
