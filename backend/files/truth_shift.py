"""By how much the clock of a truth file differs from that of the measurements, as far as the two can tell.

The shift is fitted without any tracking: it is the one number, added to the times of the truth, for which the true
path explains the measurements best. A mark is explained by its range differences c (TOA_i - mean) - (r_i - mean), a
plot by its position. What a shift could be mistaken for is fitted along with it: a constant error of every station
(of every radar, east and north). A wrong reception or a plot of something else loses its weight (Tukey's biweight).

The standard error comes from blocks of consecutive rows (a cluster-robust variance): errors of neighbouring rows
resemble each other, and a formula that takes them for independent would find a shift everywhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from algorithms.recording import Floats, Ints, PolarPlots, Recording, ToaMarks
from backend.files.truth_tracks import PathPoints, TruthTrack

# The clocks of two recorders are seconds apart, or by the 18 s between GPS and UTC; more is another mistake.
_SEARCHED_S = np.arange(-32.0, 33.0, 2.0)
_LARGEST_S = 40.0
_SEARCH_ROWS = 500
_LARGEST_MATRIX = 4_000_000
_FEWEST_ROWS, _BLOCKS, _FEWEST_BLOCKS = 20, 60, 10
_BIWEIGHT = 4.685
# A shift under which much less of the truth meets a measurement explains little, however well it fits.
_LEAST_COVER = 0.6
# Rows at the edge of a gap come and go with the shift, so the last steps may swing by a fraction of the error: after
# so many steps they are halved, and a coarser end will do.
_SETTLED, _SETTLED_LATE, _LATE = 0.1, 0.5, 10
# Four standard errors: one recording in ten thousand is accused without a cause.
_SIGNIFICANT = 4.0


@dataclass(frozen=True)
class TimeShift:
    """Seconds to add to the times of the truth, their standard error, and the rows that told it."""

    shift_s: float
    standard_error_s: float
    rows: int

    @property
    def is_significant(self) -> bool:
        """Whether chance hardly explains it."""
        return abs(self.shift_s) > _SIGNIFICANT * self.standard_error_s


@dataclass(frozen=True)
class Paths:
    """The true paths, and which of them each row follows (-1 = none); None where the nearest one is meant."""

    tracks: Sequence[TruthTrack]
    track_of: Ints | None

    def at(self, rows: Ints, time_s: Floats) -> PathPoints:
        """Where the target of each row was at `time_s`."""
        assert self.track_of is not None
        out = PathPoints(
            np.full((len(rows), 3), np.nan),
            np.full((len(rows), 3), np.nan),
            np.zeros(len(rows), bool),
            np.full((len(rows), 2), -1, np.int64),
        )
        for i, track in enumerate(self.tracks):
            mine = np.flatnonzero(self.track_of[rows] == i)
            points = track.at(time_s[mine])
            out.position_m[mine], out.velocity_mps[mine] = points.position_m, points.velocity_mps
            out.exact[mine], out.between[mine] = points.exact, points.between
        return out


@dataclass(frozen=True)
class _Equations:
    """What is left unexplained under one shift, what a second more would change, and what else could explain it.

    Attributes
    ----------
    residual, slope : (n,) float, m and m/s
    nuisance : (n, k) float, columns of the constant errors
    row : (n,) int, row of the recording
    unknowns : how many of the equations the times of emission take, one in each mark
    """

    residual: Floats
    slope: Floats
    nuisance: Floats
    row: Ints
    unknowns: int


_Observe = Callable[[float, Ints], _Equations]


def estimate_time_shift(recording: Recording, paths: Paths) -> TimeShift | None:
    """Fit the shift; None where the recording cannot tell it (no site, too few rows, no change of direction)."""
    observe = _observer(recording, paths)
    if observe is None or not len(recording):
        return None
    rows = np.arange(len(recording))
    few = rows[:: max(1, len(rows) // _SEARCH_ROWS)]
    start = _search(observe, few)
    if start is None:
        return None
    columns = observe(start, few[:1]).nuisance.shape[1] + 1
    per_row = columns * max(columns, 2)
    return _refine(observe, rows[:: max(1, len(rows) * per_row // _LARGEST_MATRIX)], start)


def _observer(recording: Recording, paths: Paths) -> _Observe | None:
    if isinstance(recording, ToaMarks) and recording.site is not None and paths.track_of is not None:
        stations = recording.site.station_positions()
        offsets_s = np.array([s.clock_offset_ns for s in recording.site.stations]) * 1e-9
        return lambda shift_s, rows: _marks(recording, stations, offsets_s, paths, shift_s, rows)
    if isinstance(recording, PolarPlots):
        radars = _radar_positions(recording)
        if np.isfinite(radars[:, :2]).all():
            return lambda shift_s, rows: _plots(recording, radars, paths, shift_s, rows)
    return None


def _marks(
    recording: ToaMarks, stations: Floats, offsets_s: Floats, paths: Paths, shift_s: float, rows: Ints
) -> _Equations:
    toa = recording.toa_s[rows, :, 0] - offsets_s
    received = np.isfinite(toa)
    count = np.maximum(received.sum(axis=1), 1)

    # It stands among what is compiled, for which no server waits at its start.
    from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

    def centred(values: Floats) -> Floats:
        values = np.where(received, values, 0.0)
        out: Floats = values - values.sum(axis=1, keepdims=True) / count[:, None]
        return out

    # The pulse leaves after the gate has opened, by what its flight leaves of the time of arrival.
    time_s = recording.time_s[rows] - shift_s
    start = paths.at(rows, time_s).position_m
    flight = np.linalg.norm(start[:, None] - stations, axis=2) / SPEED_OF_LIGHT_MPS
    emission = np.where(received, toa - flight, 0.0).sum(axis=1) / count
    points = paths.at(rows, time_s + np.where(np.isfinite(emission), emission, 0.0))
    difference = points.position_m[:, None] - stations
    distance = np.linalg.norm(difference, axis=2)
    closing = np.einsum("msi,mi->ms", difference, points.velocity_mps) / np.maximum(distance, 1.0)
    usable = received & np.isfinite(distance) & np.isfinite(closing) & (count >= 2)[:, None]
    residual = centred(SPEED_OF_LIGHT_MPS * toa) - centred(distance)
    indicator = np.where(received[:, :, None], np.eye(len(stations)) - received[:, None] / count[:, None, None], 0.0)
    mark, _ = np.nonzero(usable)
    unknowns = len(np.unique(mark))
    return _Equations(residual[usable], centred(closing)[usable], indicator[usable], rows[mark], unknowns)


def _radar_positions(recording: PolarPlots) -> Floats:
    site = recording.site
    fixed = np.full((len(recording), 3), np.nan)
    if site is not None and site.radars:
        fixed = site.radar_positions()[recording.radar]
    moving = np.stack([recording.radar_east_m, recording.radar_north_m, np.full(len(recording), np.nan)], axis=1)
    return np.where(np.isfinite(moving), moving, fixed)


def _plots(recording: PolarPlots, radars: Floats, paths: Paths, shift_s: float, rows: Ints) -> _Equations:
    time_s = recording.time_s[rows] - shift_s
    if paths.track_of is not None:
        points = paths.at(rows, time_s)
        position, velocity = points.position_m, points.velocity_mps
        difference = _plot_positions(recording, radars, rows, position) - position[:, :2]
    else:
        candidates = [track.at(time_s) for track in paths.tracks]
        options = np.stack(
            [_plot_positions(recording, radars, rows, c.position_m) - c.position_m[:, :2] for c in candidates]
        )
        away = np.where(np.isfinite(options).all(axis=2), np.hypot(options[..., 0], options[..., 1]), np.inf)
        nearest = away.argmin(axis=0)
        each = np.arange(len(rows))
        difference, velocity = options[nearest, each], np.stack([c.velocity_mps for c in candidates])[nearest, each]
        difference[~_best_of_scan(time_s, nearest, away[nearest, each], paths)] = np.nan
    usable = np.isfinite(difference).all(axis=1) & np.isfinite(velocity[:, :2]).all(axis=1)
    columns = np.eye(2 * len(recording.radars)).reshape(len(recording.radars), 2, -1)
    return _Equations(
        difference[usable].ravel(),
        velocity[usable, :2].ravel(),
        columns[recording.radar[rows[usable]]].reshape(-1, 2 * len(recording.radars)),
        np.repeat(rows[usable], 2),
        0,
    )


def _plot_positions(recording: PolarPlots, radars: Floats, rows: Ints, truth_m: Floats) -> Floats:
    """Return where the plots lie in the plane; a slant range is laid down with the height of the truth."""
    ground = recording.range_m[rows, 0]
    azimuth = recording.azimuth_rad[rows, 0]
    site = recording.site
    slant = np.array([r.range_kind != "ground" for r in site.radars])[recording.radar[rows]] if site else True
    rise = np.where(slant, np.nan_to_num(truth_m[:, 2] - radars[rows, 2]), 0.0)
    ground = np.sqrt(np.maximum(ground**2 - rise**2, 0.0))
    polar = np.stack([ground * np.sin(azimuth), ground * np.cos(azimuth)], axis=1)
    plane = np.stack([recording.east_m[rows, 0], recording.north_m[rows, 0]], axis=1)
    return radars[rows, :2] + np.where(np.isfinite(plane), plane, polar)


def _best_of_scan(time_s: Floats, track: Ints, away: Floats, paths: Paths) -> np.ndarray:
    """Mark the plot nearest to each target in each of its periods: a target has one plot in a turn of the antenna."""
    periods = [t.period_s for t in paths.tracks if np.isfinite(t.period_s)]
    turn = np.floor((time_s - time_s[0]) / (float(np.median(periods)) if periods else 1.0)).astype(np.int64)
    order = np.lexsort((away, turn, track))
    first = np.ones(len(order), bool)
    first[1:] = (np.diff(track[order]) != 0) | (np.diff(turn[order]) != 0)
    best = np.zeros(len(order), bool)
    best[order[first]] = True
    return best & np.isfinite(away)


def _search(observe: _Observe, rows: Ints) -> float | None:
    spreads: list[tuple[float, int]] = []
    for shift_s in _SEARCHED_S:
        found = observe(float(shift_s), rows)
        if not len(found.residual):
            spreads.append((np.inf, 0))
            continue
        constant = np.linalg.lstsq(found.nuisance, found.residual, rcond=None)[0]
        spreads.append((float(np.median(np.abs(found.residual - found.nuisance @ constant))), len(found.residual)))
    most = max(n for _, n in spreads)
    if most == 0:
        return None
    allowed = [
        (s, abs(x), x) for (s, n), x in zip(spreads, _SEARCHED_S.tolist(), strict=True) if n >= _LEAST_COVER * most
    ]
    return float(min(allowed)[2])


def _refine(observe: _Observe, rows: Ints, shift_s: float) -> TimeShift | None:
    """Gauss-Newton steps with Tukey's weights, until the step is far below the standard error."""
    for step in range(30):
        found = observe(shift_s, rows)
        used = np.unique(found.row)
        if len(used) < _FEWEST_ROWS:
            return None
        matrix = np.column_stack([found.slope, found.nuisance])
        solved = _solve(matrix, found.residual)
        weight = np.ones(len(found.residual))
        for _ in range(20):
            left = found.residual - matrix @ solved
            scale = 1.4826 * float(np.median(np.abs(left))) or 1e-9
            weight = np.maximum(1 - (left / (_BIWEIGHT * scale)) ** 2, 0.0) ** 2
            root = np.sqrt(weight)
            newer = _solve(matrix * root[:, None], found.residual * root)
            settled = np.abs(newer[0] - solved[0]) < 1e-9
            solved = newer
            if settled:
                break
        error = _standard_error(found, matrix, weight, found.residual - matrix @ solved, used)
        if error is None:
            return None
        # A positive residual on a path that moves away: the truth is of an earlier instant than it says.
        shift_s -= float(np.clip(solved[0], -2.0, 2.0)) * (1.0 if step < _LATE else 0.5)
        if abs(shift_s) > _LARGEST_S:
            return None
        if abs(solved[0]) < (_SETTLED if step < _LATE else _SETTLED_LATE) * error:
            return TimeShift(shift_s, error, len(used))
    return None


def _solve(matrix: Floats, residual: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(matrix.T @ matrix, matrix.T @ residual, rcond=1e-10)[0], np.float64)


def _standard_error(found: _Equations, matrix: Floats, weight: Floats, left: Floats, used: Ints) -> float | None:
    blocks = np.searchsorted(used, found.row) * min(_BLOCKS, len(used) // 2) // len(used)
    count = int(blocks.max()) + 1
    if count < _FEWEST_BLOCKS:
        return None
    # What the constant errors explain of the slope says nothing about the shift.
    root = np.sqrt(weight)
    slope, nuisance = matrix[:, 0] * root, matrix[:, 1:] * root[:, None]
    own = slope - nuisance @ _solve(nuisance, slope)
    information = float(own @ own)
    if information <= 1e-6 * float(slope @ slope) or information == 0.0:
        return None
    # A block with much weight pulls the fit towards itself, so what it leaves is set off against its share.
    share = np.bincount(blocks, weights=own**2, minlength=count) / information
    score = np.bincount(blocks, weights=own * root * left, minlength=count) / np.maximum(1 - share, 0.1)
    by_blocks = float(score @ score) / information**2
    # Few blocks may agree by chance, but no better than independent errors would allow.
    freedom = max(float(weight.sum()) - found.unknowns - nuisance.shape[1], 1.0)
    independent = float(weight @ left**2) / freedom / information
    # Exact data have no spread at all; floating point still has.
    return max(float(np.sqrt(max(by_blocks, independent))), 1e-9)
