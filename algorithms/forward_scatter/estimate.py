"""What all forward-scatter methods share around their kernels: passes, unsigned Dopplers, positions from theta, notes.

A method fills theta and its covariance for one pass of some trials; here the rows of a recording are dealt out to it
and what it says becomes a trajectory: x = s + v_x d, y = v_y d + a_y d^2 / 2, turned into the local frame.

References
----------
specification 2, 4 (step 7), 10.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from algorithms.forward_scatter.calibration import widen
from algorithms.forward_scatter.conditions import Conditions, median_interval
from algorithms.forward_scatter.doubts import doubts, sign_notes
from algorithms.forward_scatter.motion import UNKNOWNS, doppler_rows
from algorithms.forward_scatter.outputs import ANSWERED, HELD, INSUFFICIENT
from algorithms.forward_scatter.parameters import GAP_INTERVALS, ScatterParameters
from algorithms.forward_scatter.passes import JUMPS, TURNS, passes, signs
from algorithms.forward_scatter.piece import Arrays, Method, Piece, empty_arrays
from algorithms.forward_scatter.profile import NORMAL_95
from algorithms.recording import DopplerPairs
from algorithms.result import Note
from algorithms.spec import RunContext

Floats = NDArray[np.float64]

RIDGE = "ridge_covariance"
"""While methods run: (M, 5, 5, L) covariance of theta along a curved ridge, of which that of positions is made; NaN
where the method knows of none."""


def estimate(
    recording: DopplerPairs,
    conditions: Conditions,
    parameters: ScatterParameters,
    context: RunContext,
    method: Method,
    *,
    lines: bool = False,
    extra: tuple[str, ...] = (),
) -> tuple[Arrays, tuple[Note, ...]]:
    """Cut the recording into passes, let `method` work on each, and turn what it found into positions.

    `extra` names arrays (M, L) of the method's own.
    """
    context.check_cancelled()
    arrays = empty_arrays(recording, lines=lines)
    arrays |= {name: np.full(arrays["time_s"].shape, np.nan) for name in extra}
    arrays[RIDGE] = np.full(arrays["theta_covariance"].shape, np.nan)
    pieces = _pieces(recording, conditions, parameters, arrays)
    notes = [] if parameters.unsigned else sign_notes(recording)
    for i, piece in enumerate(pieces):
        context.check_cancelled()
        method(piece, arrays)
        before = _covariance(piece, arrays)
        widen(piece, method, parameters, conditions, arrays)
        _interval(piece, arrays, before[:, 1, 1])
        # Of a ridge too it is made wider by what errors of calibration cost.
        piece.put(arrays, RIDGE, _covariance(piece, arrays, RIDGE) + _covariance(piece, arrays) - before)
        _position(piece, conditions, arrays)
        _residuals(piece, conditions, arrays)
        context.progress((i + 1) / len(pieces))
    if not pieces:
        context.progress(1.0)
    del arrays[RIDGE]
    notes += doubts(pieces, conditions, arrays)
    return arrays, (*conditions.notes, *notes)


def _pieces(
    recording: DopplerPairs, conditions: Conditions, parameters: ScatterParameters, arrays: Arrays
) -> list[Piece]:
    """Passes of every target; trials whose passes are cut alike go together."""
    out: list[Piece] = []
    track = arrays["track"]
    begun = np.zeros(track.shape[1], np.int64)
    for target in range(len(recording.targets)):
        rows = recording.rows_of(target)
        if not rows.size:
            continue
        time = np.ascontiguousarray(recording.time_s[rows])
        doppler = np.ascontiguousarray(recording.doppler_hz[rows])
        interval = median_interval(time)
        if parameters.passes == "one":
            number = np.ones((rows.size, doppler.shape[2]), np.int64)
        else:
            number = np.zeros((rows.size, doppler.shape[2]), np.int64)
            gap = parameters.gap_s or GAP_INTERVALS * interval
            how = TURNS if parameters.unsigned else JUMPS
            passes(time, doppler, conditions.sigma, float(gap), how, number)
        track[rows] = np.where(number > 0, number + begun, 0)
        groups: dict[bytes, list[int]] = {}
        for lane in range(number.shape[1]):
            groups.setdefault(number[:, lane].tobytes(), []).append(lane)
        for lanes in groups.values():
            cut = number[:, lanes[0]]
            out += [
                _piece(recording, conditions, parameters, rows[cut == one], np.array(lanes), interval)
                for one in range(1, int(cut.max(initial=0)) + 1)
            ]
        begun += number.max(axis=0, initial=0)
    return out


def _piece(
    recording: DopplerPairs,
    conditions: Conditions,
    parameters: ScatterParameters,
    rows: NDArray[np.int64],
    lanes: NDArray[np.int64],
    interval: float,
) -> Piece:
    def of(values: Floats) -> Floats:
        return np.ascontiguousarray(values[rows][..., lanes])

    time = np.ascontiguousarray(recording.time_s[rows])
    doppler = of(recording.doppler_hz)
    if parameters.unsigned:
        signs(doppler, time, 0, rows.size)
    bearing = np.arctan2(conditions.frame.sine, conditions.frame.cosine)
    azimuth = np.pi / 2 - of(recording.azimuth_rad) - bearing
    return Piece(
        rows=rows,
        lanes=lanes,
        time=time,
        doppler=doppler,
        rate=of(recording.doppler_rate_hz_s),
        azimuth=azimuth - 2 * np.pi * np.round(azimuth / (2 * np.pi)),
        elevation=of(recording.elevation_rad),
        interval=interval,
    )


def _covariance(piece: Piece, arrays: Arrays, name: str = "theta_covariance") -> Floats:
    """(K, 5, 5, L) of theta."""
    both = np.arange(UNKNOWNS)
    return np.asarray(arrays[name], float)[np.ix_(piece.rows, both, both, piece.lanes)]


def _interval(piece: Piece, arrays: Arrays, spread: Floats) -> None:
    """95 % interval of the distance: of the method, with what errors of calibration added to `spread`."""
    index = np.ix_(piece.rows, piece.lanes)
    answered = np.isin(arrays["status"][index], ANSWERED)
    distance = np.asarray(arrays["theta"], float)[:, 1][index]
    variance = _covariance(piece, arrays)[:, 1, 1]
    found = np.asarray(arrays["distance_interval_m"], float)[np.ix_(piece.rows, np.arange(2), piece.lanes)]
    with np.errstate(invalid="ignore"):
        plain = NORMAL_95 * np.sqrt(np.where(spread > 0, spread, np.nan))
        for end, sign in ((0, -1.0), (1, 1.0)):
            half = np.where(np.isfinite(found[:, end]), np.abs(found[:, end] - distance), plain)
            half = np.sqrt(half**2 + NORMAL_95**2 * np.maximum(variance - spread, 0.0))
            found[:, end] = np.where(answered, distance + sign * half, np.nan)
    piece.put(arrays, "distance_interval_m", found)


def _position(piece: Piece, conditions: Conditions, arrays: Arrays) -> None:
    """Turn theta of a pass into states and covariances of its rows."""
    theta = np.asarray(arrays["theta"], float)[np.ix_(piece.rows, np.arange(UNKNOWNS), piece.lanes)]
    ridge = _covariance(piece, arrays, RIDGE)
    covariance = np.where(np.isfinite(ridge), ridge, _covariance(piece, arrays))
    status = arrays["status"][np.ix_(piece.rows, piece.lanes)]
    theta = np.where(np.isin(status, ANSWERED)[:, None], theta, np.nan)
    tau, s, vy, vx, ay = (theta[:, i] for i in range(UNKNOWNS))
    d = piece.time[:, None] - tau
    zero = np.zeros_like(d)
    height = np.full_like(d, conditions.altitude)
    position = np.stack([s + vx * d, vy * d + 0.5 * ay * d * d, height], axis=-1)
    velocity = np.stack([vx, vy + ay * d, zero], axis=-1)
    place = conditions.frame.to_enu(position)
    speed = conditions.frame.turned_to_enu(velocity)
    push = conditions.frame.turned_to_enu(np.stack([zero, ay, zero], axis=-1))
    state = np.empty((len(piece.rows), 9, len(piece.lanes)))
    for axis in range(3):
        state[:, 3 * axis] = place[..., axis]
        state[:, 3 * axis + 1] = speed[..., axis]
        state[:, 3 * axis + 2] = push[..., axis]
    state[:, :, :] = np.where(np.isfinite(d)[:, None], state, np.nan)
    piece.put(arrays, "state", state)
    # dx = ds + d dv_x - v_x dtau, dy = d dv_y + d^2/2 da_y - (v_y + a_y d) dtau.
    by = np.zeros((2, UNKNOWNS, *d.shape))
    by[0, 0], by[0, 1], by[0, 3] = -vx, 1.0, d
    by[1, 0], by[1, 2], by[1, 4] = -(vy + ay * d), d, 0.5 * d * d
    plane = np.zeros((2, 2, *d.shape))
    for p in range(2):
        for q in range(p + 1):
            total = zero
            for i in range(UNKNOWNS):
                for j in range(UNKNOWNS):
                    total = total + by[p, i] * covariance[:, i, j] * by[q, j]
            plane[p, q] = plane[q, p] = total
    c, n = conditions.frame.cosine, conditions.frame.sine
    turn = np.array([[c, -n], [n, c]])
    out = np.zeros((len(piece.rows), 3, 3, len(piece.lanes)))
    for p in range(2):
        for q in range(p + 1):
            total = zero
            for i in range(2):
                for j in range(2):
                    total = total + turn[p, i] * turn[q, j] * plane[i, j]
            out[:, p, q] = out[:, q, p] = total
    known = np.isfinite(d) & np.isfinite(out[:, 0, 0]) & (out[:, 0, 0] >= 0) & (out[:, 1, 1] >= 0)
    piece.put(arrays, "covariance", np.where(known[:, None, None], out, np.nan))


def _residuals(piece: Piece, conditions: Conditions, arrays: Arrays) -> None:
    """Dopplers minus those of the pass's last answer."""
    theta = np.asarray(arrays["theta"], float)
    for i, lane in enumerate(piece.lanes):
        answered = np.flatnonzero(np.isin(arrays["status"][piece.rows, lane], ANSWERED))
        if answered.size:
            last = np.nan_to_num(theta[piece.rows[answered[-1]], :, lane])
            value, _ = doppler_rows(piece.time, last, conditions.feet, conditions.wavelength, conditions.altitude)
            arrays["residual_hz"][piece.rows, :, lane] = piece.doppler[:, :, i] - value.T


def held_where_thinned(piece: Piece, arrays: Arrays, stride: int) -> None:
    """Rows between those that were computed take the answer before them."""
    for k in range(len(piece.rows)):
        if k % stride and k != len(piece.rows) - 1:
            for name in ("theta", "theta_covariance", RIDGE, "distance_interval_m", "chi2", "dof"):
                arrays[name][piece.rows[k]][..., piece.lanes] = arrays[name][piece.rows[k - 1]][..., piece.lanes]
            before = arrays["status"][piece.rows[k - 1], piece.lanes]
            arrays["status"][piece.rows[k], piece.lanes] = np.where(np.isin(before, ANSWERED), HELD, before)


def without_one_receiver(piece: Piece, arrays: Arrays) -> None:
    """Take answers back as long as only one channel was heard in a pass: it fits two places equally well."""
    heard = np.logical_or.accumulate(np.isfinite(piece.doppler), axis=0).sum(axis=1)
    index = np.ix_(piece.rows, piece.lanes)
    arrays["status"][index] = np.where(heard < 2, INSUFFICIENT, arrays["status"][index])
