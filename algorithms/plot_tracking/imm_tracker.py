"""The recommended tracker: interacting straight and turning filters, nearest neighbours or joint probabilities.

Tracks begin with two plots within the reach of the largest speed, have a number from the third on and are confirmed
with `confirm_plots`. A confirmed track coasts over missed scans with a wider gate and ends after `drop_after` antenna
periods by time, whether scans came or not.

References
----------
blom1988; barshalom2001, sections 11.6 and 6.4; crouse2016; specification 9.

Differences from the paper
--------------------------
The paper's memory, counter and curved trajectory are replaced by two filters that interact, so that no manoeuvre has
to be decided upon; one is said to be on where the turning model has the larger probability.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.plot_tracking import outputs
from algorithms.plot_tracking.bound import bound
from algorithms.plot_tracking.history import Estimates, History, Ints
from algorithms.plot_tracking.imm_filter import Motion, predicted
from algorithms.plot_tracking.imm_rules import Clutter, Identity, Rules, Taken, gate_radius
from algorithms.plot_tracking.imm_scan import advance, limits_of, plot_covariances, twins
from algorithms.plot_tracking.imm_tracks import ImmTracks
from algorithms.plot_tracking.joined import joining_of
from algorithms.plot_tracking.measures import measure
from algorithms.plot_tracking.outside import just_outside
from algorithms.plot_tracking.parameters import ImmParameters
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.radars import Feed, feeds_of
from algorithms.plot_tracking.scoring import score_result
from algorithms.plot_tracking.tables import tabulate
from algorithms.recording import PolarPlots
from algorithms.result import Note, Output, Result, Setting
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.tracks import life_cycle

_CHECK_EVERY = 10
_NOTHING = Scan(0.0, np.empty(0, np.int64), np.empty(0, np.int64), t=np.empty(0), rho=np.empty(0), theta=np.empty(0))


def run(recording: PolarPlots, parameters: ImmParameters, context: RunContext) -> Result:
    """Track the plots of every radar, one after the other; numbers of tracks run on."""
    feeds, settings, notes = feeds_of(recording, parameters)
    history = History(*recording.range_m.shape)
    numbers = np.ones(history.lanes, np.int64)
    scans = max(sum(len(feed.plots.scans) for feed in feeds), 1)
    context.check_cancelled()
    done = too_large = 0
    for feed in feeds:
        history.begin(feed)
        rules = rules_of(parameters, feed)
        tracks = _no_tracks(rules)
        clutter = _clutter(feed)
        for scan in feed.plots.scans:
            if done % _CHECK_EVERY == 0:
                context.check_cancelled()
                context.progress(done / scans)
            identity = _identity(recording, scan, use=parameters.use_identity)
            tracks, large = _scan(feed, scan, identity, tracks, rules, clutter, numbers, history)
            too_large += large
            done += 1
    context.progress(1.0)
    if too_large:
        notes.append(
            Note(
                "cluster_too_large",
                "More tracks and plots lay in common gates than probabilities are summed for; there the nearest were "
                "taken.",
                too_large,
            )
        )
    settings |= {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in settings and getattr(parameters, name) is not None
    }
    joining = joining_of(recording, feeds, parameters, identities=parameters.use_identity)
    return Result(history.arrays(recording.row, len(outputs.MODELS), joining), tuple(notes), settings)


def rules_of(p: ImmParameters, feed: Feed) -> Rules:
    """The tracker's rules for one radar."""
    return Rules(
        motion=Motion(
            period_s=feed.period_s,
            sd_straight=p.sd_straight_mps2,
            sd_turn=p.sd_turn_mps2,
            sd_turn_rate_step=float(np.radians(p.sd_turn_rate_step_deg_s)),
            sd_turn_rate=float(np.radians(p.sd_turn_rate_deg_s)),
            stay=(p.stay_straight, p.stay_turning),
            turning=p.motion == "imm",
        ),
        sigma_r=feed.sigma_r,
        sigma_th=feed.sigma_th,
        across_m=feed.across_m,
        max_speed_mps=p.limits[0],
        gate=gate_radius(p.gate_probability),
        coasting_gate=p.coasting_gate,
        joint=p.association == "joint",
        detection=p.detection_probability,
        largest_cluster=p.largest_cluster,
        confirm_plots=p.confirm_plots,
        drop_after=p.drop_after,
    )


def _no_tracks(rules: Rules) -> ImmTracks:
    none = np.empty(0, np.int64)
    return ImmTracks.starting_from(_NOTHING, none, np.empty((0, 2)), np.empty((0, 2, 2)), rules.motion)


def _clutter(feed: Feed) -> Clutter:
    """Nothing is known of false plots at first; they lie in the disc that holds all plots of a trial."""
    farthest = np.ones(feed.plots.lanes)
    for scan in feed.plots.scans:
        np.maximum.at(farthest, scan.lane, scan.rho)
    return Clutter(np.pi * farthest**2, np.zeros(feed.plots.lanes))


def _identity(recording: PolarPlots, scan: Scan, *, use: bool) -> Identity:
    none = np.full(scan.position.size, -1)
    if not use:
        return Identity(none, none, np.full(none.size, np.nan))
    # A row that a trial did not measure says nothing in it; a row that is there says the same in every trial.
    return Identity(
        recording.address[scan.position],
        recording.callsign[scan.position],
        recording.altitude_m[scan.position, scan.lane],
    )


def _scan(
    feed: Feed, scan: Scan, identity: Identity, tracks: ImmTracks, rules: Rules, clutter: Clutter, numbers: Ints,
    history: History,
) -> tuple[ImmTracks, int]:  # fmt: skip
    """Advance by a scan and write down what happened."""
    silent = life_cycle.periods_missed(scan.time_s, tracks.seen_s, rules.period_s) - 1
    gone = silent >= limits_of(tracks, rules)
    _end(tracks, gone & (silent > tracks.misses), scan.time_s, life_cycle.SENSOR_SILENT, history)
    _end(tracks, gone & (silent <= tracks.misses), scan.time_s, life_cycle.TOO_MANY_MISSES, history)
    tracks = tracks.take(~gone)
    before = np.where(tracks.number > 0, life_cycle.state_of(tracks.confirmed, tracks.misses), -1)
    taken = advance(tracks, scan, identity, rules, clutter, numbers)
    history.begin_scan(feed, scan.time_s)
    after = life_cycle.state_of(tracks.confirmed, tracks.misses)
    numbered = np.flatnonzero(tracks.number > 0)
    history.diary.steps(tracks.lane[numbered], tracks.number[numbered], scan.time_s, before[numbered], after[numbered])
    new = np.flatnonzero((before < 0) & (tracks.number > 0))
    for name in ("first", "second"):
        history.baptise(getattr(tracks, name)[new], tracks.lane[new], tracks.number[new])
    _write_plots(scan, taken, tracks, rules, history)
    for stage, which, centre, covariance in taken.areas:
        gate = outputs.GATE_OF_STAGE[stage]
        for model in range(centre.shape[1]):
            history.areas(
                feed, scan.time_s, gate, tracks.lane[which], tracks.number[which], centre[:, model],
                covariance[:, model],
            )  # fmt: skip
    dead = tracks.misses >= limits_of(tracks, rules)
    _end(tracks, dead & tracks.confirmed, scan.time_s, life_cycle.TOO_MANY_MISSES, history)
    _end(tracks, dead & ~tracks.confirmed, scan.time_s, life_cycle.NEVER_CONFIRMED, history)
    double = twins(tracks, rules) & ~dead
    _end(tracks, double, scan.time_s, life_cycle.DUPLICATE, history)
    kept = ~(dead | double)
    history.estimates(feed, _estimates(scan, taken, tracks, np.flatnonzero(kept & tracks.confirmed), rules))
    east, north = scan.rho * np.sin(scan.theta), scan.rho * np.cos(scan.theta)
    free = taken.free
    born = ImmTracks.starting_from(
        scan, free, np.stack([east, north], axis=1), plot_covariances(east, north, rules), rules.motion
    )
    for name in ("address", "callsign", "altitude_m"):
        getattr(born, name)[:] = getattr(identity, name)[free]
    born.altitude_s[:] = scan.t[free]
    return tracks.take(kept).joined(born), taken.too_large


def _end(tracks: ImmTracks, which: NDArray[np.bool_], time_s: float, reason: int, history: History) -> None:
    """Only tracks with a number have a life to end."""
    at = np.flatnonzero(which & (tracks.number > 0))
    history.diary.note(tracks.lane[at], tracks.number[at], time_s, life_cycle.DROPPED, reason)


def _write_plots(scan: Scan, taken: Taken, tracks: ImmTracks, rules: Rules, history: History) -> None:
    gates = np.array([outputs.NO_GATE, outputs.START_GATE, outputs.ACQUISITION_GATE, outputs.TRACKING_GATE])
    decisions = np.array([outputs.STARTED, outputs.SECOND, outputs.ACQUIRED, outputs.UPDATED])
    gate, decision = gates[taken.stage], decisions[taken.stage]
    owner = np.maximum(taken.owner, 0)
    if len(tracks):
        turning = tracks.bank.mu[owner, -1] > 0.5 if rules.motion.turning else np.zeros(owner.size, bool)
        decision = np.where((taken.stage == 3) & turning, outputs.MANOEUVRE, decision)
        number = np.where(taken.owner >= 0, tracks.number[owner], 0)
    else:
        number = np.zeros(owner.size, np.int64)
    decision = np.where(taken.shared, outputs.SHARED, decision)
    edge = np.where(taken.stage >= 2, rules.gate, np.where(taken.stage == 1, 1.0, np.nan))
    history.take(
        scan,
        decision=decision,
        gate=gate,
        number=number,
        distance=taken.distance,
        threshold=edge,
        rivals=taken.rivals,
        probability=taken.probability,
    )
    for stage, track, plot, distance in taken.pairs:
        history.pairs(scan, plot, tracks.number[track], int(gates[stage]), distance)


def _outside(scan: Scan, taken: Taken, tracks: ImmTracks) -> Ints:
    """(T,) row of a plot just outside the gates of each confirmed track that has missed its first scan, -1 = none."""
    out = np.full(len(tracks), -1)
    for stage, which, centre, shape in taken.areas:
        if stage == 3:
            missed = np.flatnonzero((tracks.misses[which] == 1) & tracks.confirmed[which])
            found = just_outside(tracks.lane[which[missed]], centre[missed], shape[missed], scan, taken.free)
            known = found >= 0
            out[which[missed[known]]] = scan.position[found[known]]
    return out


def _estimates(scan: Scan, taken: Taken, tracks: ImmTracks, which: Ints, rules: Rules) -> Estimates:
    """Confirmed tracks at the instant of their plot, coasting ones at that of the scan."""
    plot_of = np.full(len(tracks), -1)
    has = np.flatnonzero((taken.owner >= 0) & ~taken.shared)
    plot_of[taken.owner[has]] = has
    plot = plot_of[which]
    hit = (plot >= 0) & (tracks.misses[which] == 0)
    bank = tracks.bank.take(which)
    coasting = np.flatnonzero(scan.time_s - tracks.epoch_s[which] > 0.5 * rules.period_s)
    if coasting.size:
        ahead = scan.time_s - tracks.epoch_s[which[coasting]]
        bank.put(coasting, predicted(bank.take(coasting), ahead, rules.motion))
    mean, covariance = bank.moments()
    time = tracks.epoch_s[which].copy()
    time[coasting] = scan.time_s
    velocity = covariance[:, [1, 3]][:, :, [1, 3]]
    speed = np.maximum(np.hypot(mean[:, 1], mean[:, 3]), 1e-9)
    along = mean[:, [1, 3]] / speed[:, None]
    across = np.stack([along[:, 1], -along[:, 0]], axis=1)
    none = np.full(which.size, np.nan)
    if rules.motion.turning:
        # Counter-clockwise turns are to the left.
        normal = -mean[:, 4] * speed
    else:
        normal = none
    sd = [np.sqrt(np.maximum(np.einsum("ti,tij,tj->t", u, velocity, u), 0.0)) for u in (along, across)]
    weights = np.zeros((which.size, len(outputs.MODELS)))
    weights[:, : bank.mu.shape[1]] = bank.mu
    mark = np.where(hit, scan.position[np.maximum(plot, 0)], -1) if scan.position.size else np.full(which.size, -1)
    distance = taken.distance[np.maximum(plot, 0)] ** 2 if plot.size else none
    order = np.array([0, 2, 1, 3])
    return Estimates(
        lane=tracks.lane[which],
        number=tracks.number[which],
        time_s=time,
        mark=mark,
        outside=_outside(scan, taken, tracks)[which],
        status=life_cycle.state_of(tracks.confirmed[which], tracks.misses[which]),
        misses=tracks.misses[which],
        state=mean[:, order],
        covariance=covariance[:, order[:, None], order],
        motion=np.stack(
            [
                none,
                normal,
                sd[0],
                np.degrees(np.minimum(sd[1] / speed, np.pi)),
                none,
                tracks.plots[which].astype(float),
            ],
            axis=1,
        ),
        nis=np.where(hit, distance, np.nan),
        weights=weights,
    )


def score(recording: PolarPlots, parameters: ImmParameters, context: RunContext) -> Scores:
    """Track the trials side by side and count against the truth."""
    return score_result(recording, run(recording, parameters, context))


ALGORITHM = Algorithm(
    name="imm_tracker",
    title="Tracker with interacting models",
    summary="Straight and turning filters that interact, joint probabilities or nearest neighbours, and a life of "
    "every track with reasons: the recommended way from plots to tracks.",
    family="plot_tracking",
    recommended=True,
    takes=("polar_plots",),
    parameters=ImmParameters,
    outputs=(
        *outputs.TRACK_OUTPUTS,
        Output("estimate_weights", ("estimate", "model"), "probability", "of the motion models"),
    ),
    charts=(
        "plan",
        "track_scope",
        "track_continuity",
        "plot_distances",
        "mode_probabilities",
        "track_motion",
        "track_sets",
        "gate_calibration",
        "radial_error",
        "drms",
        "nis",
        "trials_error",
        "trials_sweep",
        "trials_heat",
        "trials_times",
        "trials_sets",
        "trials_consistency",
    ),
    references=(
        Reference("blom1988"),
        Reference("barshalom2001", "section 11.6"),
        Reference("crouse2016"),
        Reference("schuhmacher2008"),
        Reference("rahmathullah2017"),
    ),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
