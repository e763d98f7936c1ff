"""Results of the multilateration algorithms as long tables (columns as the HTTP API fixes them)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from algorithms.multilateration import lanes
from algorithms.multilateration.altitudes import SOURCES
from algorithms.multilateration.outputs import position_covariance
from algorithms.multilateration.receiver_tables import receiver_tables
from algorithms.multilateration.separated import as_told_apart, emitter_decisions, emitter_lives, with_reasons_of_nobody
from algorithms.recording import ToaMarks
from algorithms.result import Result, Table
from algorithms.texts import Texts

# What became of a mark that entered the estimate just as it should.
_PLAINLY_USED = (lanes.UPDATED, lanes.INITIALISED)
_UPDATING = (
    lanes.UPDATED,
    lanes.INITIALISED,
    lanes.REINITIALISED,
    lanes.DOWNWEIGHTED,
    lanes.ALTITUDE_ONLY,
    lanes.AMBIGUOUS,
)
# Marks that entered as they should, of which something is to be told all the same.
_WORTH_TELLING = (
    lanes.R_TOGETHER,
    lanes.R_LEFT_RECEPTION,
    lanes.R_LEFT_ALTITUDE,
    lanes.R_LEFT_IMPOSSIBLE,
    lanes.R_LEFT_DOUBTFUL,
    lanes.R_HEIGHT,
)
MODELS = ("straight flight", "manoeuvre")
_POSITION = [0, 3, 6]
_VELOCITY = [1, 4, 7]
_ACCELERATION = [2, 5, 8]


def tabulate(recording: ToaMarks, result: Result) -> dict[str, Table]:
    """Return the tables states, errors (with truth), tracks, decisions and receivers of one recording."""
    of_emitters = emitter_decisions(recording, result)
    lives = None if of_emitters is None else emitter_lives(recording, result)
    recording = as_told_apart(recording, result)
    # Of a long recording the work on the receivers takes as much memory as the large tables, which are made after it.
    receivers = receiver_tables(recording, result)
    tracks = _tracks(recording, result)
    rows = _Rows.of(recording, result)
    decisions = with_reasons_of_nobody(_decisions(recording, result, rows), recording, result)
    tables = {"states": _states(recording, result, rows), "tracks": tracks, "decisions": decisions} | receivers
    if recording.has_truth:
        tables["errors"] = _errors(recording, result, rows)
    if "mode_probability" in result.arrays:
        tables["mode_probabilities"] = _probabilities(result, rows)
    if of_emitters is not None:
        tables["emitters"] = of_emitters
    if lives is not None:
        tables["track_events"] = lives
    return tables


@dataclass(frozen=True)
class _Rows:
    """Which mark, trial, track and target each row is of: trial by trial, marks in time order.

    Of a long recording each table has the same columns, once in memory.
    """

    trial: NDArray[np.float64]
    track: NDArray[np.float64]
    row: NDArray[np.int64]
    target: Texts

    @classmethod
    def of(cls, recording: ToaMarks, result: Result) -> _Rows:
        a = result.arrays
        marks, trials = a["time_s"].shape
        track = _flat(a["track"])
        # An uploaded recording is no trial.
        trial = np.broadcast_to(np.nan, marks) if trials == 1 else np.repeat(np.arange(trials, dtype=float), marks)
        return cls(
            trial=trial,
            track=np.where(track > 0, track, np.nan),
            row=a["row"] if trials == 1 else np.tile(a["row"], trials),
            target=Texts.coded(np.tile(recording.target, trials), recording.targets),
        )

    def taken(self, keep: NDArray[np.bool_] | NDArray[np.int64]) -> _Rows:
        """Only these rows."""
        return _Rows(self.trial[keep], self.track[keep], self.row[keep], self.target[keep])


def _flat(array: NDArray[Any]) -> NDArray[Any]:
    """(mark, trial) -> rows: trial by trial, marks in time order."""
    return array.T.reshape(-1)


def _states(recording: ToaMarks, result: Result, rows: _Rows) -> Table:
    a = result.arrays
    state, cov, time = a["state"], position_covariance(result), a["time_s"]
    # One after another: of a long recording what lies between is a part of the memory that a worker has.
    sd = [np.sqrt(cov[:, i]) for i in (0, 2, 5)]
    if not np.isfinite(time).all():
        time = np.where(np.isfinite(time), time, recording.time_s[:, None])
    columns: dict[str, Any] = {"trial": rows.trial, "track": rows.track, "time_s": _flat(time)}
    for prefix, where, unit in (
        ("", _POSITION, "m"),
        ("velocity_", _VELOCITY, "mps"),
        ("acceleration_", _ACCELERATION, "mps2"),
    ):
        for axis, i in zip(("east", "north", "up"), where, strict=True):
            columns[f"{prefix}{axis}_{unit}"] = _flat(state[:, i])
    for axis, values in zip(("east", "north", "up"), sd, strict=True):
        columns[f"sigma_{axis}_m"] = _flat(values)
    columns["drms_m"] = _flat(np.hypot(sd[0], sd[1]))
    columns["nis"] = _flat(a["nis"])
    columns["dof"] = _flat(a["dof"])
    columns["status"] = Texts.coded(_flat(a["status"]), lanes.STATUS)
    columns["used"] = _used(recording.stations, a["used"], a["altitude_used"])
    columns["row"] = rows.row
    columns["target"] = rows.target
    columns["covariance_east_north_m2"] = _flat(cov[:, 1])
    if "altitude_source" in a:
        columns["altitude_source"] = Texts.coded(_flat(a["altitude_source"]), SOURCES)
        columns["altitude_given_m"] = _flat(a["altitude_given_m"])
        columns["altitude_sigma_m"] = _flat(a["altitude_sigma_m"])
    if "altitude_bias_m" in a:
        columns["altitude_bias_m"] = _flat(a["altitude_bias_m"])
        columns["altitude_bias_sd_m"] = _flat(a["altitude_bias_sd_m"])
    return Table(columns)


def _used(stations: tuple[str, ...], receptions: NDArray[np.bool_], altitude: NDArray[np.bool_]) -> Texts:
    """What went into each row, as words; a recording has few different sets.

    receptions: (mark, station, trial), altitude: (mark, trial).
    """
    rows = np.concatenate([receptions, altitude[:, None]], axis=1).transpose(2, 0, 1).reshape(-1, len(stations) + 1)
    words = np.array((*stations, "altitude"), object)
    packed = np.packbits(rows, axis=1)
    _, first, which = np.unique(packed.view(f"V{packed.shape[1]}").ravel(), return_index=True, return_inverse=True)
    return Texts.coded(which, [" ".join(words[rows[i]]) for i in first])


def position_errors(
    recording: ToaMarks, result: Result, rows: slice | NDArray[np.int64] = slice(None)
) -> NDArray[np.float64]:
    """(mark, 3, trial) m: estimate minus truth at these marks; NaN where either is unknown."""
    errors: NDArray[np.float64] = result.arrays["state"][rows, 0:9:3] - recording.truth_m[rows, :, None]
    return errors


def _errors(recording: ToaMarks, result: Result, rows: _Rows) -> Table:
    a = result.arrays
    errors = position_errors(recording, result)
    squares = ((a["state"][:, i] - recording.truth_velocity_mps[:, k, None]) ** 2 for k, i in enumerate(_VELOCITY))
    speed = np.sqrt(sum(squares))
    keep = np.isfinite(_flat(errors[:, 0]))
    if not keep.all():
        rows = rows.taken(keep)

    def column(values: NDArray[Any]) -> NDArray[Any]:
        flat = _flat(values)
        return flat if keep.all() else flat[keep]

    return Table(
        {
            "trial": rows.trial,
            "track": rows.track,
            "target": rows.target,
            "time_s": column(a["time_s"]),
            "error_east_m": column(errors[:, 0]),
            "error_north_m": column(errors[:, 1]),
            "error_up_m": column(errors[:, 2]),
            "error_horizontal_m": column(np.hypot(errors[:, 0], errors[:, 1])),
            "error_velocity_mps": column(speed),
            "row": rows.row,
        }
    )


def _tracks(recording: ToaMarks, result: Result) -> Table:
    a = result.arrays
    rows: list[tuple[Any, ...]] = []
    of_target = recording.rows_by_target()
    for trial in range(a["track"].shape[1]):
        number, status, reason = a["track"][:, trial], a["status"][:, trial], a["reason"][:, trial]
        for track, where in _marks_of_tracks(number):
            target = recording.target[where[0]]
            mine = of_target[target]
            later = mine[np.searchsorted(mine, where[-1], side="right") :]
            end = "end of the recording" if later.size == 0 else _end_reason(later, where, reason, recording)
            updating = np.isin(status[where], _UPDATING)
            rows.append(
                (
                    track,
                    recording.targets[target] or None,
                    "open" if later.size == 0 else "ended",
                    float(a["time_s"][where[0], trial]),
                    float(a["time_s"][where[-1], trial]),
                    int(updating.sum()),
                    int((~updating).sum()),
                    end,
                    _inconsistent_marks(a["nis"][where, trial], a["dof"][where, trial]),
                )
            )
    names = ("track", "target", "state", "start_s", "end_s", "updates", "misses", "reason", "inconsistent_marks")
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(names)
    texts = {"target", "state", "reason"}
    return Table({n: list(c) if n in texts else np.array(c, float) for n, c in zip(names, columns, strict=True)})


def _marks_of_tracks(number: NDArray[np.int32]) -> Iterator[tuple[int, NDArray[np.int64]]]:
    """Each track's number with the positions of its marks."""
    order = np.argsort(number, kind="stable")
    tracks, count = np.unique(number, return_counts=True)
    ends = np.cumsum(count)
    for track, begin, end in zip(tracks.tolist(), ends - count, ends, strict=True):
        if track > 0:
            yield track, order[begin:end]


def _inconsistent_marks(nis: NDArray[np.float64], dof: NDArray[np.int64]) -> int:
    """How often NIS per degree of freedom, averaged over the last twenty marks, exceeded what is believable."""
    tested = np.isfinite(nis) & (dof > 0)
    ratio = np.minimum(nis[tested] / dof[tested], lanes.WINDOW_CAP)
    if ratio.size < lanes.WINDOW_MARKS:
        return 0
    mean = np.convolve(ratio, np.ones(lanes.WINDOW_MARKS) / lanes.WINDOW_MARKS, mode="valid")
    return int((mean > lanes.DOUBTFUL_RATIO).sum())


def _end_reason(
    later: NDArray[np.int64], where: NDArray[np.int64], reason: NDArray[np.int64], recording: ToaMarks
) -> str:
    first = later[0]
    if recording.time_s[first] - recording.time_s[where[-1]] > lanes.GAP_S:
        return lanes.REASONS[lanes.R_GAP]
    return lanes.REASONS[reason[first]] or "restarted"


def _decisions(recording: ToaMarks, result: Result, rows: _Rows) -> Table:
    """List every mark that was not simply used: what was decided, against which threshold, and why."""
    a = result.arrays
    status, reason = _flat(a["status"]), _flat(a["reason"])
    keep = np.flatnonzero(~np.isin(status, _PLAINLY_USED) | np.isin(reason, _WORTH_TELLING))
    rows = rows.taken(keep)
    nis, dof = _flat(a["nis"])[keep], _flat(a["dof"])[keep]
    scaled = status[keep] == lanes.DOWNWEIGHTED
    threshold = np.where(scaled, _thresholds(result, dof), np.nan)
    return Table(
        {
            "track": rows.track,
            "row": rows.row,
            "time_s": recording.time_s[keep % len(recording)],
            "decision": Texts.coded(status[keep], lanes.STATUS),
            "distance": np.sqrt(nis),
            "threshold": threshold,
            "probability": np.full(keep.size, np.nan),
            "reason": _reasons(recording, result, reason, keep),
            "target": rows.target,
            "trial": rows.trial,
            "code": Texts.coded(reason[keep], lanes.REASON_CODES),
        }
    )


def _thresholds(result: Result, dof: NDArray[Any]) -> NDArray[np.float64]:
    """From which normalised distance on the noise of a mark is scaled up."""
    if "gate_probability" in result.settings:
        gate: NDArray[np.float64] = np.sqrt(
            chi2.ppf(float(result.settings["gate_probability"].value), np.maximum(dof, 1))
        )
        return gate
    scaled: NDArray[np.float64] = lanes.SCALE_FROM_SIGMA * np.sqrt(dof)
    return scaled


def _reasons(recording: ToaMarks, result: Result, reason: NDArray[Any], keep: NDArray[np.int64]) -> Texts:
    """Words of each reason; a start in vain also tells the error that it would have had, to two digits, and what was
    left out is named.
    """
    words = Texts.coded(reason[keep], lanes.REASONS)
    more: dict[int, str] = {}
    if "start_error_m" in result.arrays:
        error = _flat(result.arrays["start_error_m"])[keep]
        for i in np.flatnonzero(np.isfinite(error)).tolist():
            more[i] = f"predicted error {float(f'{error[i] / 1e3:.2g}'):g} km"
    marks = len(recording)
    # Also of a mark that something else is told of: a reception of it may have been left out.
    for i in np.flatnonzero(np.isin(_flat(result.arrays["status"])[keep], _UPDATING)).tolist():
        mark, trial = keep[i] % marks, keep[i] // marks
        used = result.arrays["used"][mark, :, trial]
        left = np.flatnonzero(np.isfinite(recording.toa_s[mark, :, trial]) & ~used)
        if left.size and used.any():
            more[i] = "without " if reason[keep[i]] not in _WORTH_TELLING else ""
            more[i] += "station " + ", ".join(recording.stations[s] for s in left)
    if not more:
        return words
    longer = list(words)
    for i, text in more.items():
        longer[i] = f"{longer[i]}; {text}"
    return Texts.of(longer)


def _probabilities(result: Result, rows: _Rows) -> Table:
    """How probable straight flight and manoeuvre are after each mark, where the models carry the track."""
    a = result.arrays
    straight, manoeuvre = (_flat(a["mode_probability"][:, m]) for m in range(2))
    keep = np.flatnonzero(np.isfinite(straight))
    twice = rows.taken(np.repeat(keep, 2))
    return Table(
        {
            "trial": twice.trial,
            "track": twice.track,
            "time_s": np.repeat(_flat(a["time_s"])[keep], 2),
            "model": Texts.coded(np.tile([0, 1], keep.size), MODELS),
            "probability": np.stack([straight[keep], manoeuvre[keep]], axis=1).ravel(),
            "row": twice.row,
            "target": twice.target,
        }
    )
