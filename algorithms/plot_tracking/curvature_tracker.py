"""The paper's tracker: three gates, a counter of the memory, and a trajectory of constant acceleration and curvature.

A plot starts a track; the second must lie within the reach of the largest speed, the third near the straight
continuation, every later one in the tracking gate of three nested ellipses. Inside the inner one the counter Q grows
and with it the memory; in the outermost ring lies a manoeuvre, and all but the last plots are forgotten.

References
----------
plots2006; specification 4 to 6.

Differences from the paper
--------------------------
Each is a choice: `gate`, `on_miss`, `confidence_*`, `kept_plots`, `predictor`, `cost`. The defaults are the printed
formulas where they mean something (`gates`, `curve_fit`, `curvature_scan` say what they do not), and a missed scan
opens the gate, which the paper does not mention. The memory is bounded.
"""

from __future__ import annotations

import numpy as np

from algorithms.plot_tracking import outputs
from algorithms.plot_tracking.bound import bound
from algorithms.plot_tracking.curvature_scan import (
    ACQUIRED,
    INNER,
    MIDDLE,
    MISS_LIMITS,
    SECOND,
    STARTED,
    Ending,
    Rules,
    Taken,
    advance,
)
from algorithms.plot_tracking.curve_fit import Limits
from algorithms.plot_tracking.gates import radius_of
from algorithms.plot_tracking.history import Estimates, History, Ints
from algorithms.plot_tracking.joined import joining_of
from algorithms.plot_tracking.measures import measure
from algorithms.plot_tracking.outside import just_outside
from algorithms.plot_tracking.parameters import CurvatureParameters
from algorithms.plot_tracking.placed import covariances_of, placed
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.radars import Feed, feeds_of
from algorithms.plot_tracking.scoring import score_result
from algorithms.plot_tracking.tables import tabulate
from algorithms.plot_tracking.track_table import TrackTable
from algorithms.recording import PolarPlots
from algorithms.result import Result, Setting
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext
from algorithms.toolbox.motion.curvature import shifted
from algorithms.toolbox.tracks import life_cycle

_DECISIONS = {STARTED: outputs.STARTED, SECOND: outputs.SECOND, ACQUIRED: outputs.ACQUIRED, INNER: outputs.UPDATED,
              MIDDLE: outputs.MIDDLE}  # fmt: skip
_CHECK_EVERY = 10


def run(recording: PolarPlots, parameters: CurvatureParameters, context: RunContext) -> Result:
    """Track the plots of every radar, one after the other; numbers of tracks run on."""
    feeds, settings, notes = feeds_of(recording, parameters)
    history = History(*recording.range_m.shape)
    numbers = np.ones(history.lanes, np.int64)
    scans = max(sum(len(feed.plots.scans) for feed in feeds), 1)
    context.check_cancelled()
    done = 0
    for feed in feeds:
        history.begin(feed)
        rules = rules_of(parameters, feed)
        tracks = TrackTable.starting_from(_NOTHING, np.empty(0, np.int64), rules.history_plots)
        for scan in feed.plots.scans:
            if done % _CHECK_EVERY == 0:
                context.check_cancelled()
                context.progress(done / scans)
            tracks = _scan(feed, scan, tracks, rules, numbers, history)
            done += 1
    context.progress(1.0)
    settings |= {
        name: Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")
        for name in type(parameters).model_fields
        if name not in settings and getattr(parameters, name) is not None
    }
    joining = joining_of(recording, feeds, parameters, identities=False)
    return Result(history.arrays(recording.row, joining=joining), tuple(notes), settings)


_NOTHING = Scan(0.0, np.empty(0, np.int64), np.empty(0, np.int64), t=np.empty(0), rho=np.empty(0), theta=np.empty(0))


def rules_of(p: CurvatureParameters, feed: Feed) -> Rules:
    """The tracker's rules for one radar."""
    speed, along, across = p.limits
    return Rules(
        sigma_r=feed.sigma_r,
        sigma_th=feed.sigma_th,
        period_s=feed.period_s,
        limits=Limits(speed, along, across, p.sd_acceleration_mps2, p.sd_normal_mps2),
        confidences=(p.confidence_inner, p.confidence_middle, p.confidence_outer),
        gate_law=p.gate,
        predictor=p.predictor,
        cost=p.cost,
        reset_on_miss=p.on_miss == "reset",
        kept_plots=p.kept_plots,
        history_plots=max(p.history_plots, p.kept_plots),
        confirm_plots=p.confirm_plots,
        least_across_m=feed.across_m,
    )


def _scan(feed: Feed, scan: Scan, tracks: TrackTable, rules: Rules, numbers: Ints, history: History) -> TrackTable:
    """Advance by a scan and write down what happened."""
    tracks, silent = _lost_in_silence(tracks, scan.time_s, rules)
    _write_endings(silent, scan.time_s, history, silent=True)
    before = np.where(tracks.number > 0, life_cycle.state_of(tracks.confirmed, tracks.misses), -1)
    old = tracks
    tracks, taken, ending = advance(tracks, scan, rules, numbers)
    history.begin_scan(feed, scan.time_s)
    # The table of before has been changed in place, so that numbers and states of now can be read from it.
    numbered = np.flatnonzero(old.number > 0)
    after = life_cycle.state_of(old.confirmed, old.misses)
    history.diary.steps(old.lane[numbered], old.number[numbered], scan.time_s, before[numbered], after[numbered])
    _write_endings(ending, scan.time_s, history, silent=False)
    new = np.flatnonzero((before < 0) & (old.number > 0))
    for name in ("first", "second"):
        history.baptise(getattr(old, name)[new], old.lane[new], old.number[new])
    _write_plots(scan, taken, old, rules, history)
    for stage, which, centre, covariance in taken.areas:
        gate = outputs.GATE_OF_STAGE[stage]
        history.areas(feed, scan.time_s, gate, old.lane[which], old.number[which], centre, covariance)
    history.estimates(feed, _estimates(scan, taken, tracks, _outside(scan, taken, old, tracks)))
    return tracks


def _outside(scan: Scan, taken: Taken, old: TrackTable, tracks: TrackTable) -> Ints:
    """(T,) row of a plot just outside the gate of each confirmed track that has missed its first scan, -1 = none."""
    out = np.full(len(tracks), -1)
    _, which, centre, shape = taken.areas[0]
    missed = np.flatnonzero((old.misses[which] == 1) & old.confirmed[which])
    found = just_outside(old.lane[which[missed]], centre[missed, None], shape[missed, None], scan, taken.free)
    known = found >= 0
    out[taken.after[which[missed[known]]]] = scan.position[found[known]]
    return out


def _lost_in_silence(tracks: TrackTable, time_s: float, rules: Rules) -> tuple[TrackTable, Ending]:
    """Tracks whose scans were missed by the radar itself: no plot came from anywhere."""
    missed = life_cycle.periods_missed(time_s, tracks.seen_s, rules.period_s) - 1
    limit = np.where(tracks.confirmed, MISS_LIMITS[3], np.array(MISS_LIMITS)[np.minimum(tracks.plots, 3) - 1])
    dies = (missed >= limit) & (missed > tracks.misses)
    ending = Ending(tracks.lane[dies], tracks.number[dies], tracks.last_s[dies], tracks.confirmed[dies], missed[dies])
    return tracks.take(~dies), ending


def _write_endings(ending: Ending, time_s: float, history: History, *, silent: bool) -> None:
    """Only tracks with a number have a life to end."""
    at = np.flatnonzero(ending.number > 0)
    if silent:
        reason: int | Ints = life_cycle.SENSOR_SILENT
    else:
        reason = np.where(ending.confirmed[at], life_cycle.TOO_MANY_MISSES, life_cycle.NEVER_CONFIRMED)
    history.diary.note(ending.lane[at], ending.number[at], time_s, life_cycle.DROPPED, reason)


def _write_plots(scan: Scan, taken: Taken, old: TrackTable, rules: Rules, history: History) -> None:
    decision = np.full(taken.role.size, outputs.MANOEUVRE)
    for role, code in _DECISIONS.items():
        decision[taken.role == role] = code
    gate = np.where(taken.role >= INNER, outputs.TRACKING_GATE, outputs.NO_GATE)
    gate = np.where(taken.role == SECOND, outputs.START_GATE, gate)
    gate = np.where(taken.role == ACQUIRED, outputs.ACQUISITION_GATE, gate)
    outer = float(radius_of(np.array(rules.confidences[2])))
    edge = np.where(gate == outputs.TRACKING_GATE, outer, np.where(gate == outputs.NO_GATE, np.nan, 1.0))
    history.take(
        scan,
        decision=decision,
        gate=gate,
        number=taken.number,
        distance=np.sqrt(taken.distance),
        threshold=edge,
        rivals=taken.rivals,
    )
    for stage, track, plot, distance in taken.pairs:
        history.pairs(scan, plot, old.number[track], outputs.GATE_OF_STAGE[stage], np.sqrt(distance))


def _estimates(scan: Scan, taken: Taken, tracks: TrackTable, outside: Ints) -> Estimates:
    """Confirmed tracks at the instant of their plot, coasting ones at that of the scan."""
    which = np.flatnonzero(tracks.confirmed)
    plot_of = np.full(len(tracks), -1)
    has = np.flatnonzero((taken.at >= 0) & (taken.role != STARTED))
    plot_of[taken.at[has]] = has
    plot = plot_of[which]
    hit = plot >= 0
    ahead = np.where(hit, 0.0, scan.time_s - tracks.last_s[which])
    p = shifted(tracks.p[:, which], ahead)
    north, east, course, speed, a, curvature = p
    full = covariances_of(tracks.information[:, :, which])
    place = placed(full, p, ahead)
    role = np.where(hit, taken.distance[plot], np.nan) if plot.size else np.empty(0)
    return Estimates(
        lane=tracks.lane[which],
        number=tracks.number[which],
        time_s=np.where(hit, tracks.last_s[which], scan.time_s),
        mark=np.where(hit, scan.position[plot], -1) if scan.position.size else np.full(which.size, -1),
        outside=outside[which],
        status=life_cycle.state_of(tracks.confirmed[which], tracks.misses[which]),
        misses=tracks.misses[which],
        state=np.stack([east, north, speed * np.sin(course), speed * np.cos(course)], axis=1),
        covariance=place,
        motion=np.stack(
            [
                a,
                curvature * speed**2,
                np.sqrt(full[3, 3]),
                np.degrees(np.sqrt(full[2, 2])),
                tracks.q[which].astype(float),
                tracks.plots[which].astype(float),
            ],
            axis=1,
        ),
        nis=role,
        weights=np.empty((which.size, 0)),
    )


def score(recording: PolarPlots, parameters: CurvatureParameters, context: RunContext) -> Scores:
    """Track the trials side by side and count against the truth."""
    return score_result(recording, run(recording, parameters, context))


ALGORITHM = Algorithm(
    name="curvature_tracker",
    title="Tracker with a curved trajectory",
    summary="The paper's tracker: start, acquisition and tracking gates, a memory that a manoeuvre cuts, and a "
    "trajectory of constant acceleration and curvature fitted to the plots in it.",
    family="plot_tracking",
    takes=("polar_plots",),
    parameters=CurvatureParameters,
    outputs=outputs.TRACK_OUTPUTS,
    charts=(
        "plan",
        "track_scope",
        "track_continuity",
        "plot_distances",
        "track_motion",
        "track_sets",
        "track_memory",
        "gate_calibration",
        "radial_error",
        "drms",
        "trials_error",
        "trials_sweep",
        "trials_heat",
        "trials_times",
        "trials_sets",
        "trials_consistency",
    ),
    references=(Reference("plots2006"), Reference("more1978"), Reference("crouse2016")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
    bound=bound,
)
