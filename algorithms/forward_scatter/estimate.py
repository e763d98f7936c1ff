"""What all forward-scatter methods share around their kernels: passes, unsigned Dopplers, positions from theta, notes.

A method fills theta and its covariance for one pass of some trials; here the rows of a recording are dealt out to it
and what it says becomes a trajectory: x = s + v_x d, y = v_y d + a_y d^2 / 2, turned into the local frame.

References
----------
specification 2, 4 (step 7), 10.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from algorithms.forward_scatter.conditions import Conditions, median_interval
from algorithms.forward_scatter.motion import UNKNOWNS, doppler_rows
from algorithms.forward_scatter.outputs import ANSWERED, HELD, INSUFFICIENT, LINE_OUTPUTS, NO_VALUES
from algorithms.forward_scatter.parameters import GAP_INTERVALS, ScatterParameters
from algorithms.forward_scatter.passes import passes, signs
from algorithms.recording import DopplerPairs
from algorithms.result import Note
from algorithms.spec import RunContext

Floats = NDArray[np.float64]
Arrays = dict[str, NDArray[np.generic]]

# Warnings of specification 10.
LARGEST_SIDE = 0.3
SPEED_MPS = (5.0, 3000.0)
CHI2_QUANTILE = 0.999
FEWEST_FOR_SIGN = 6


@dataclass(frozen=True)
class Piece:
    """One pass of some trials: its rows, instants and measurements, and where the answers go."""

    rows: NDArray[np.int64]
    """(K,) positions in the recording."""
    lanes: NDArray[np.int64]
    time: Floats
    doppler: Floats
    """(K, C, L)."""
    rate: Floats
    """(K, 2, L)."""
    azimuth: Floats
    """(K, L) rad from the base line, positive to its left."""
    elevation: Floats
    interval: float

    def put(self, arrays: Arrays, name: str, values: NDArray[np.generic]) -> None:
        """Put (K, ..., L) values of this pass into an array of the result."""
        whole = arrays[name]
        index = np.ix_(self.rows, *(np.arange(n) for n in whole.shape[1:-1]), self.lanes)
        whole[index] = values


Method = Callable[[Piece, Arrays], None]


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
    pieces = _pieces(recording, conditions, parameters, arrays)
    notes = [] if parameters.unsigned else _sign_notes(recording)
    for i, piece in enumerate(pieces):
        context.check_cancelled()
        method(piece, arrays)
        _position(piece, conditions, arrays)
        _residuals(piece, conditions, arrays)
        context.progress((i + 1) / len(pieces))
    if not pieces:
        context.progress(1.0)
    notes += _plausibility(pieces, conditions, arrays)
    return arrays, (*conditions.notes, *notes)


def empty_arrays(recording: DopplerPairs, *, lines: bool) -> Arrays:
    """Room for every output, filled with nothing."""
    m, c, lanes = recording.doppler_hz.shape
    nan = np.nan
    arrays: Arrays = {
        "row": recording.row.copy(),
        "target": recording.target.copy(),
        "time_s": np.repeat(recording.time_s[:, None], lanes, axis=1),
        "state": np.full((m, 9, lanes), nan),
        "covariance": np.full((m, 3, 3, lanes), nan),
        "track": np.zeros((m, lanes), np.int64),
        "status": np.full((m, lanes), NO_VALUES, np.int64),
        "theta": np.full((m, UNKNOWNS, lanes), nan),
        "theta_covariance": np.full((m, UNKNOWNS, UNKNOWNS, lanes), nan),
        "chi2": np.full((m, lanes), nan),
        "dof": np.zeros((m, lanes), np.int64),
        "used": np.zeros((m, c, lanes), np.bool_),
        "residual_hz": np.full((m, c, lanes), nan),
    }
    if lines:
        arrays |= {
            "line": np.full((m, 2, 6, lanes), nan),
            "crossing_s": np.full((m, 2, lanes), nan),
            "frozen": np.zeros((m, 2, lanes), np.bool_),
            "omega_rad_s": np.full((m, lanes), nan),
            "difference_hz": np.full((m, lanes), nan),
        }
        assert set(arrays) == {o.name for o in LINE_OUTPUTS}
    return arrays


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
            passes(time, doppler, conditions.sigma, float(gap), not parameters.unsigned, number)
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


def _position(piece: Piece, conditions: Conditions, arrays: Arrays) -> None:
    """Turn theta of a pass into states and covariances of its rows."""
    theta = np.asarray(arrays["theta"], float)[np.ix_(piece.rows, np.arange(UNKNOWNS), piece.lanes)]
    both = np.arange(UNKNOWNS)
    covariance = np.asarray(arrays["theta_covariance"], float)[np.ix_(piece.rows, both, both, piece.lanes)]
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
            for name in ("theta", "theta_covariance", "chi2", "dof"):
                arrays[name][piece.rows[k]][..., piece.lanes] = arrays[name][piece.rows[k - 1]][..., piece.lanes]
            before = arrays["status"][piece.rows[k - 1], piece.lanes]
            arrays["status"][piece.rows[k], piece.lanes] = np.where(np.isin(before, ANSWERED), HELD, before)


def without_one_receiver(piece: Piece, arrays: Arrays) -> None:
    """Take answers back as long as only one channel was heard in a pass: it fits two places equally well."""
    heard = np.logical_or.accumulate(np.isfinite(piece.doppler), axis=0).sum(axis=1)
    index = np.ix_(piece.rows, piece.lanes)
    arrays["status"][index] = np.where(heard < 2, INSUFFICIENT, arrays["status"][index])


def _sign_notes(recording: DopplerPairs) -> list[Note]:
    f = recording.doppler_hz[:, :, 0]
    known = f[np.isfinite(f)]
    if known.size >= FEWEST_FOR_SIGN * f.shape[1] and (known >= 0).all():
        return [
            Note(
                "doppler_without_sign",
                "No Doppler is negative, though every crossing goes from plus to minus: where the receiver gives "
                "magnitudes, set `unsigned`.",
            )
        ]
    return []


def _plausibility(pieces: list[Piece], conditions: Conditions, arrays: Arrays) -> list[Note]:
    """Warnings about the first trial's passes."""
    counts: dict[str, int] = {}
    for piece in pieces:
        if 0 not in piece.lanes:
            continue
        rows = piece.rows
        answered = rows[np.isin(arrays["status"][rows, 0], ANSWERED)]
        if rising(piece):
            counts["sign_reversed"] = counts.get("sign_reversed", 0) + 1
        if not answered.size:
            continue
        _, s, vy, _, _ = np.asarray(arrays["theta"], float)[answered[-1], :, 0]
        if not SPEED_MPS[0] <= abs(vy) <= SPEED_MPS[1]:
            counts["speed_unlikely"] = counts.get("speed_unlikely", 0) + 1
        local = conditions.frame.from_enu(np.asarray(arrays["state"], float)[answered[-1], ::3, 0])
        if abs(local[1]) > LARGEST_SIDE * min(s, conditions.a - s):
            counts["far_from_base_line"] = counts.get("far_from_base_line", 0) + 1
        chi2, dof = float(arrays["chi2"][answered[-1], 0]), int(arrays["dof"][answered[-1], 0])
        if dof > 0 and chi2 > stats.chi2.ppf(CHI2_QUANTILE, dof):
            counts["chi2_large"] = counts.get("chi2_large", 0) + 1
    said = {
        "sign_reversed": "The Dopplers rise through the pass: the Doppler sign convention is probably reversed.",
        "speed_unlikely": "The velocity across the base line is outside 5 to 3000 m/s: probably a wrong unit, kHz "
        "for Hz or km for m.",
        "far_from_base_line": "The pass ends further from the base line than 0.3 of the distance to its nearer end: "
        "the method is made for |y| much smaller.",
        "chi2_large": "The residuals are larger than the Doppler error allows (99.9 %): false values (set robust to "
        "consensus), an acceleration (five unknowns), or a wrong error.",
    }
    return [Note(code, said[code], count) for code, count in counts.items()]


def rising(piece: Piece) -> bool:
    """Whether every channel of the first trial rises significantly over the whole pass."""
    found = []
    for c in range(piece.doppler.shape[1]):
        f = piece.doppler[:, c, 0]
        known = np.isfinite(f)
        if known.sum() < FEWEST_FOR_SIGN:
            continue
        fit = stats.linregress(piece.time[known], f[known]) if np.ptp(piece.time[known]) > 0 else None
        found.append(fit is not None and fit.slope > 3 * fit.stderr > 0)
    return bool(found) and all(found)
