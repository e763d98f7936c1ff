"""The usual rival of the range-difference filter: each complete mark is solved first, then the fixes are filtered.

A linear Kalman filter with constant acceleration disturbed by jerk runs over the one-mark solutions, each with the
Cramer-Rao bound of its mark as measurement covariance (specification 6.6). A mark that cannot be solved by itself is
lost: the track coasts, which is what the paper argues against. The fixes come from the same code as `single_mark`, the
motion from the same model as `rdf`, so that a comparison shows the difference between the methods alone.

Differences from the paper: it names the method without formulas; the gate over three degrees of freedom, the restart
after five fixes in a row outside it and the end of a track after 60 s without a fix are ours.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration import lanes
from algorithms.multilateration.conditions import conditions_of, given_or_default, toa_of
from algorithms.multilateration.fixes import solve_recording
from algorithms.multilateration.measures import measure
from algorithms.multilateration.outputs import OUTPUTS, position_part
from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.scoring import score_marks
from algorithms.multilateration.tables import tabulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.scores import Scores
from algorithms.spec import Algorithm, Reference, RunContext, parameter
from algorithms.toolbox.kernels.symmetric import pack, unpack
from algorithms.toolbox.motion.jerk import PROCESS_NOISE, jerk_matrices

Floats = NDArray[np.float64]

POSITION = [0, 3, 6]
# Chi-square of three degrees of freedom, 99.9 %.
GATE = 16.266
# So many fixes in a row outside the gate are the target, not mistakes.
OUTSIDE_IN_A_ROW = 5


class FixFilterParameters(AltitudeParameters):
    """Parameters of the filter over one-mark solutions."""

    altitude: Literal["none", "white"] = parameter(
        "white",
        title="Altitude",
        group="measurement",
        choices={"none": "not used", "white": "an observation with the error above"},
    )
    """Whether a decoded altitude is used."""
    sigma_jerk_mps3: float = parameter(
        0.1,
        title="Jerk",
        unit="m/s³",
        symbol="σ_ξ",
        group="motion",
        gt=0,
        le=1e4,
    )
    """Standard deviation of the jerk that disturbs the motion."""


class _Lanes(NamedTuple):
    """Tracks of all trials of one target."""

    x: Floats
    p: Floats
    time: Floats
    """Of the state; NaN without a track."""
    updated: Floats
    outside: NDArray[np.int64]
    number: NDArray[np.int64]


def run(recording: ToaMarks, parameters: FixFilterParameters, context: RunContext) -> Result:
    """Solve every mark by itself, then filter the fixes of every target.

    Raises
    ------
    RecordingError, ParameterError
        No site, or WGS-84 without an origin.
    """
    with_altitude = parameters.altitude == "white"
    conditions = conditions_of(recording, parameters, with_altitude=with_altitude)
    altitude = recording.altitude_m if with_altitude else np.full_like(recording.altitude_m, np.nan)
    arrays: dict[str, NDArray[Any]] = solve_recording(
        recording, conditions, toa_of(recording, conditions), altitude, context
    )
    del arrays["roots_m"]
    marks, _, trials = arrays["state"].shape
    arrays["covariance"] = np.concatenate([arrays["covariance"], np.full((marks, 39, trials), np.nan)], axis=1)
    before = np.zeros(trials, np.int64)
    for rows in recording.rows_by_target():
        if rows.size:
            context.check_cancelled()
            before = _filter(recording, parameters, arrays, rows, before)
    settings = conditions.settings | {
        name: given_or_default(parameters, name) for name in ("altitude", "sigma_jerk_mps3")
    }
    return Result(arrays, conditions.notes, settings)


def score(recording: ToaMarks, parameters: FixFilterParameters, context: RunContext) -> Scores:
    """Filter the fixes of simulated marks and score the tracks against the truth."""
    arrays = run(recording, parameters, context).arrays
    covariance = position_part(arrays["covariance"])
    return score_marks(recording, arrays["state"], covariance, arrays["nis"], arrays["dof"])


def _filter(
    recording: ToaMarks,
    parameters: FixFilterParameters,
    arrays: dict[str, NDArray[Any]],
    rows: NDArray[np.int64],
    before: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Filter the marks of one target through all trials, in place; return the highest track number of each trial."""
    trials = before.size
    tracks = _Lanes(
        x=np.zeros((trials, 9)), p=np.zeros((trials, 9, 9)), time=np.full(trials, np.nan),
        updated=np.full(trials, np.nan), outside=np.zeros(trials, np.int64), number=before.copy(),
    )  # fmt: skip
    form = PROCESS_NOISE.index("white")
    for k in rows:
        fix = arrays["state"][k][POSITION].T
        noise = np.moveaxis(unpack(arrays["covariance"][k, :6]), 2, 0)
        solved = np.isfinite(fix[:, 0])
        now = np.where(solved, arrays["time_s"][k], recording.time_s[k])
        # A track that nothing has updated for a minute is over.
        over = ~(now - tracks.updated <= lanes.GAP_S)
        tracks.time[over] = np.nan
        going = np.flatnonzero(np.isfinite(tracks.time))
        if going.size:
            f, q = jerk_matrices(np.maximum(now[going] - tracks.time[going], 0.0), parameters.sigma_jerk_mps3, form)
            tracks.x[going] = np.einsum("lij,lj->li", f, tracks.x[going])
            tracks.p[going] = f @ tracks.p[going] @ np.swapaxes(f, 1, 2) + q
            tracks.time[going] = np.maximum(now[going], tracks.time[going])
        nis = np.full(trials, np.nan)
        chosen = going[solved[going]]
        outside = np.zeros(trials, bool)
        if chosen.size:
            nis[chosen], outside[chosen] = _update(tracks, chosen, fix, noise)
        tracks.outside[:] = np.where(outside, tracks.outside + 1, np.where(solved, 0, tracks.outside))
        again = outside & (tracks.outside >= OUTSIDE_IN_A_ROW)
        fresh = solved & (np.isnan(tracks.time) | again)
        _start(tracks, np.flatnonzero(fresh), fix, noise, now)
        tracks.updated[:] = np.where(solved & ~(outside & ~again), now, tracks.updated)
        _report(arrays, k, tracks, solved, fresh, again, outside, nis)
    return tracks.number


def _update(tracks: _Lanes, at: NDArray[np.int64], fix: Floats, noise: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    """Take the fixes of some lanes in; return NIS, and which were outside the gate and left out."""
    p = tracks.p[at]
    innovation = fix[at] - tracks.x[at][:, POSITION]
    across = p[:, :, POSITION]
    s = across[:, POSITION] + noise[at]
    gain = np.swapaxes(np.linalg.solve(s, np.swapaxes(across, 1, 2)), 1, 2)
    nis = np.einsum("li,li->l", innovation, np.linalg.solve(s, innovation[:, :, None])[:, :, 0])
    outside = nis > GATE
    gain[outside] = 0.0
    tracks.x[at] += np.einsum("lij,lj->li", gain, innovation)
    updated = p - gain @ np.swapaxes(across, 1, 2)
    tracks.p[at] = 0.5 * (updated + np.swapaxes(updated, 1, 2))
    return nis, outside


def _start(tracks: _Lanes, at: NDArray[np.int64], fix: Floats, noise: Floats, now: Floats) -> None:
    if not at.size:
        return
    tracks.x[at] = 0.0
    tracks.p[at] = 0.0
    for i, a in enumerate(POSITION):
        tracks.x[at, a] = fix[at, i]
        tracks.p[at, a + 1, a + 1] = lanes.START_VELOCITY_SD_MPS**2
        tracks.p[at, a + 2, a + 2] = lanes.START_ACCELERATION_SD_MPS2**2
        for j, b in enumerate(POSITION):
            tracks.p[at, a, b] = noise[at, i, j]
    tracks.time[at] = now[at]
    tracks.outside[at] = 0
    tracks.number[at] += 1


def _report(
    arrays: dict[str, NDArray[Any]],
    k: int,
    tracks: _Lanes,
    solved: NDArray[np.bool_],
    fresh: NDArray[np.bool_],
    again: NDArray[np.bool_],
    outside: NDArray[np.bool_],
    nis: Floats,
) -> None:
    """Write what became of a mark, in place of what the one-mark solution said of it."""
    live = np.isfinite(tracks.time)
    arrays["state"][k] = np.where(live, tracks.x.T, np.nan)
    arrays["covariance"][k] = np.where(live, pack(np.moveaxis(tracks.p, 0, 2)), np.nan)
    arrays["time_s"][k] = np.where(live, tracks.time, np.nan)
    arrays["track"][k] = np.where(live, tracks.number, 0)
    status, reason = arrays["status"][k], arrays["reason"][k]
    status[solved & ~outside] = lanes.UPDATED
    status[fresh] = lanes.INITIALISED
    status[again] = lanes.REINITIALISED
    reason[again] = lanes.R_FIX
    left_out = outside & ~again
    status[left_out] = lanes.RESIDUAL_GATE
    reason[left_out] = lanes.R_RESIDUAL
    # What the fix said stays as the reason: too few receptions, two solutions, an impossible spread.
    status[live & ~solved & (status == lanes.NOT_INITIALISED)] = lanes.COAST
    used = solved & ~left_out
    arrays["used"][k] &= used
    arrays["altitude_used"][k] &= used
    arrays["residual_m"][k] = np.where(used, arrays["residual_m"][k], np.nan)
    arrays["nis"][k] = np.where(fresh, np.nan, nis)
    arrays["dof"][k] = np.where(np.isfinite(nis) & ~fresh, 3, 0)


ALGORITHM = Algorithm(
    name="fix_filter",
    title="Filter over one-mark solutions",
    summary="Each complete mark is solved for a position, then the positions are filtered with its bound. "
    "Incomplete marks are lost: the rival that the range-difference filters are held against.",
    family="multilateration",
    takes=("toa_marks",),
    parameters=FixFilterParameters,
    outputs=OUTPUTS,
    charts=("plan", "drms", "nis", "radial_error", "altitude", "height", "residuals", "receiver_delays", "receptions"),
    references=(Reference("barshalom2001", "sec. 6.5"), Reference("chugunov2023", "introduction")),
    run=run,
    tabulate=tabulate,
    measure=measure,
    score=score,
)
