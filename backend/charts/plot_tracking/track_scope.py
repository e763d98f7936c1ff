"""What the radar sees, as it measures: azimuth to the right, range upwards; plots, tracks, their gates and vectors.

Gates that are round in the plan are drawn here in the radar's own coordinates: near it they are wide in azimuth, far
away narrow. Of few tracks every gate is drawn, of many the last one of those that live at the end; a vector says where
a track is in 30 s. Azimuths are cut where nothing was seen.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from algorithms.recording import PolarPlots
from backend.charts import theme
from backend.charts.columns import Floats, Ints, numbers, words
from backend.charts.decimate import Picked, curve
from backend.charts.estimates import Estimates, estimates_of
from backend.charts.figure import ChartNote, Trace, axis, figure, hover, line_of, not_applicable, trace
from backend.charts.plots import plot_positions, radar_place
from backend.charts.view import Chart, ChartOptions, Entry, Figure, RunView

TITLE = "Range and azimuth"
# Gates of all scans are drawn of so many tracks; of more the last one of each, of so many tracks at most.
FEW_TRACKS, MOST_GATES = 2, 400
AHEAD_S = 30.0
HALF_TURN = 180.0
# A sector of so many degrees without a plot is left out.
EMPTY_SECTOR = 90.0
OUTLINE = np.linspace(0.0, 2 * np.pi, 33)


def draw(view: RunView, options: ChartOptions) -> Figure:
    """Draw the plots, then each entry's tracks with gates and vectors."""
    recording = view.recording
    if not isinstance(recording, PolarPlots) or not len(recording):
        return not_applicable(TITLE, "no_marks")
    found = plot_positions(recording)
    scope = _scope(radar_place(recording), found.east_m, found.north_m)
    traces: list[Trace] = []
    picked: list[Picked] = []
    drawn = [(entry, estimates_of(entry)) for entry in view.entries]
    for entry, states in drawn:
        if states.time_s.size:
            traces += _tracks(entry, states, scope, options, picked)
    if not traces:
        return not_applicable(TITLE, "no_states")
    notes = [ChartNote("scope", "Gates as ellipses of range and azimuth; a vector says where a track is in 30 s.")]
    if len(recording.radars) > 1:
        notes.append(
            ChartNote("first_radar", "From the place of the first radar; plots of the others are seen from there.")
        )
    return figure(
        TITLE,
        [_plots(recording, scope.polar(found.east_m, found.north_m), options), *traces],
        recording=recording,
        picked=picked,
        notes=notes,
        xaxis=axis("Azimuth, deg", range=list(scope.azimuths), dtick=45 if scope.whole else None),
        yaxis=axis("Range, km", range=[0, scope.range_km]),
    )


class _Scope(NamedTuple):
    """From where, where azimuths are cut, and what the axes show."""

    place: tuple[float, float]
    cut_deg: float
    azimuths: tuple[float, float]
    range_km: float

    @property
    def whole(self) -> bool:
        """Whether all azimuths are shown."""
        return self.azimuths[1] - self.azimuths[0] >= 2 * HALF_TURN

    def polar(self, east: Floats, north: Floats) -> tuple[Floats, Floats]:
        """Azimuth in degrees, from the cut on, and range in km."""
        e, n = east - self.place[0], north - self.place[1]
        azimuth = np.degrees(np.arctan2(e, n))
        return self.cut_deg + np.mod(azimuth - self.cut_deg, 2 * HALF_TURN), np.hypot(e, n) / 1000.0


def _scope(place: tuple[float, float], east: Floats, north: Floats) -> _Scope:
    """Axes around the plots; a sector without any is left out where it is wide."""
    azimuth, range_km = _Scope(place, 0.0, (0.0, 0.0), 0.0).polar(east, north)
    known = np.sort(azimuth[np.isfinite(azimuth)])
    farthest = 1.08 * float(np.nanmax(range_km, initial=0.01))
    if not known.size:
        return _Scope(place, 0.0, (0.0, 360.0), farthest)
    gap = np.diff(np.append(known, known[0] + 360.0))
    widest = int(gap.argmax())
    if gap[widest] < EMPTY_SECTOR:
        return _Scope(place, 0.0, (0.0, 360.0), farthest)
    cut = float(known[widest] + 0.5 * gap[widest])
    pad = min(0.05 * (360.0 - gap[widest]) + 1.0, 0.5 * gap[widest])
    if cut + 360.0 - 0.5 * gap[widest] > 360.0:
        # North is 0, not 360.
        cut -= 360.0
    return _Scope(place, cut, (cut + 0.5 * gap[widest] - pad, cut + 360.0 - 0.5 * gap[widest] + pad), farthest)


def _plots(recording: PolarPlots, seen: tuple[Floats, Floats], options: ChartOptions) -> Trace:
    azimuth, range_km = seen
    known = np.flatnonzero(np.isfinite(azimuth))
    most = options.marks
    if most is not None and known.size > most:
        known = known[:: -(-known.size // most)]
    return trace(
        "measurement",
        options.number(azimuth[known]),
        options.number(range_km[known]),
        name="plots",
        mode="markers",
        marker={"size": 3, "color": theme.TRUTH, "opacity": 0.5},
        customdata=recording.row[known],
        hovertemplate="%{x:.2f}°, %{y:.2f} km<extra></extra>",
    )


def _tracks(entry: Entry, states: Estimates, scope: _Scope, options: ChartOptions, picked: list[Picked]) -> list[Trace]:
    azimuth, range_km = scope.polar(states.numbers("east_m"), states.numbers("north_m"))
    starts = states.starts.copy()
    starts[1:] |= np.abs(np.diff(azimuth)) > HALF_TURN
    points = curve(states.time_s, (azimuth, range_km), starts, options.curve_points)
    picked.append(points)
    line = trace(
        "series",
        options.number(points.take(azimuth)),
        options.number(points.take(range_km)),
        entry=entry,
        name=entry.label,
        mode="lines",
        line=line_of(entry),
        customdata=points.take(states.row),
        **hover(
            points,
            entry.label,
            "%{x:.2f}°, %{y:.2f} km<br>row %{customdata}",
            [("track", states.words_at("track")), ("target", states.words_at("target"))],
        ),
    )
    track = states.numbers("track")
    ends = np.append(track[1:] != track[:-1], True)
    last = np.flatnonzero(ends)
    if last.size > FEW_TRACKS:
        # Those that ended long ago say nothing of what comes.
        period = float(np.median(np.diff(states.time_s)[~ends[:-1]])) if (~ends[:-1]).any() else 0.0
        last = last[states.time_s[last] >= states.time_s.max() - 1.5 * period]
    return [line, *_vectors(entry, states, last, scope), *_gates(entry, track[last], scope)]


def _vectors(entry: Entry, states: Estimates, last: Ints, scope: _Scope) -> list[Trace]:
    """From the last estimate of each track to where it is in 30 s."""
    here = [states.numbers(n)[last] for n in ("east_m", "north_m")]
    speed = [states.numbers(n)[last] for n in ("velocity_east_mps", "velocity_north_mps")]
    ends = [scope.polar(here[0] + t * speed[0], here[1] + t * speed[1]) for t in (0.0, AHEAD_S)]
    known = np.flatnonzero(np.isfinite(ends[1][0]) & (np.abs(ends[1][0] - ends[0][0]) < HALF_TURN))
    if not known.size:
        return []
    gap = np.full(known.size, np.nan)
    x, y = (np.stack([ends[0][i][known], ends[1][i][known], gap], axis=1).ravel() for i in (0, 1))
    return [_outline(entry, x, y, 2.5, "solid", "vectors")]


def _gates(entry: Entry, track: Floats, scope: _Scope) -> list[Trace]:
    areas = entry.table("gate_areas")
    if not len(areas):
        return []
    shown = np.unique(track)
    of = numbers(areas, "track")
    mine = np.flatnonzero(np.isin(of, shown) & (words(areas, "gate") == "tracking"))
    if shown.size > FEW_TRACKS and mine.size:
        # The last of each track; of interacting models two of one scan.
        time = numbers(areas, "time_s")[mine]
        latest = {t: time[of[mine] == t].max() for t in np.unique(of[mine]).tolist()}
        mine = mine[time == np.array([latest[t] for t in of[mine].tolist()])]
    mine = mine[-MOST_GATES:]
    if not mine.size:
        return []
    turn = np.radians(numbers(areas, "azimuth_deg")[mine])[:, None]
    major, minor = (numbers(areas, n)[mine][:, None] for n in ("semi_major_m", "semi_minor_m"))
    along, across = major * np.cos(OUTLINE), minor * np.sin(OUTLINE)
    east = numbers(areas, "east_m")[mine][:, None] + along * np.sin(turn) + across * np.cos(turn)
    north = numbers(areas, "north_m")[mine][:, None] + along * np.cos(turn) - across * np.sin(turn)
    azimuth, range_km = scope.polar(east, north)
    # One that lies across the cut is drawn in two pieces.
    azimuth[:, 1:][np.abs(np.diff(azimuth, axis=1)) > HALF_TURN] = np.nan
    gap = np.full((mine.size, 1), np.nan)
    x, y = (np.concatenate([part, gap], axis=1).ravel() for part in (azimuth, range_km))
    return [_outline(entry, x, y, 1.0, "dot", "gates")]


def _outline(entry: Entry, x: Floats, y: Floats, width: float, dash: str, name: str) -> Trace:
    look: dict[str, Any] = {"color": theme.series_color(entry.index), "width": width, "dash": dash}
    return trace(
        "interval", x, y, entry=entry, name=f"{entry.label}, {name}", showlegend=False, mode="lines", line=look,
        hoverinfo="skip",
    )  # fmt: skip


CHART = Chart(
    name="track_scope", title=TITLE, source="run", needs=("states",), draw=draw, kinds=("polar_plots",), overlay="frame"
)
