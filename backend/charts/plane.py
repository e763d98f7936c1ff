"""The plane seen from above: what both plans share. Stations, true paths, measured plots, unit and first view."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.recording import AntennaPlots, PolarPlots, Recording
from algorithms.site import Site
from backend.charts import theme
from backend.charts.columns import Floats, by_key_and_time
from backend.charts.decimate import Picked, curve, line_starts, thin
from backend.charts.figure import (
    ChartNote,
    Trace,
    axis,
    counted,
    figure,
    hover,
    name_pieces,
    not_applicable,
    outside_view,
    thousands,
    trace,
)
from backend.charts.plots import plot_positions
from backend.charts.view import ChartOptions, Figure

# Names are written beside so many stations; more would cover each other and stand in the hover alone.
NAMED_STATIONS = 40
KILOMETRES_FROM_M = 3000.0
# The first view holds what lies within half a span of the middle 90 % of the points; the rest is counted.
VIEW_SPANS = 0.5
# Where the stations stand and the targets really were is always in view.
FIXED = ("station", "truth")
# Outlines of errors and lines of a map do not decide what is shown: a claim of 500 km would hide the tracks.
OUTLINES = ("interval", "bound")
# In a hover: where the point is, in the unit that `Plane.draw` settles on, and which mark it stands for.
PLACE = "PLACE"
MARK = "%{text:.3f} s, row %{customdata}"


@dataclass
class Plane:
    """Collects traces in metres, then gives them one unit and finds the first view."""

    recording: Recording
    options: ChartOptions
    traces: list[Trace] = field(default_factory=list)
    picked: list[Picked] = field(default_factory=list)
    notes: list[ChartNote] = field(default_factory=list)

    def add_truth(self, recording: Recording) -> None:
        """True paths: one broken line for all targets, from the whole paths where they are known."""
        tracks = recording.truth_tracks
        if tracks is not None:
            # Truth of a whole day must not shrink the minutes that were measured.
            seen = (tracks.time_s >= recording.time_s.min()) & (tracks.time_s <= recording.time_s.max())
            target, time, position = tracks.target[seen], tracks.time_s[seen], tracks.position_m[seen]
            names, row, when = tracks.targets, np.full(len(time), -1), "%{text:.3f} s"
        elif recording.has_truth:
            order = by_key_and_time(recording.target, recording.time_s)
            target, time, row = recording.target[order], recording.time_s[order], recording.row[order]
            position, names, when = recording.truth_m[order], recording.targets, MARK
        else:
            return
        east, north = position[:, 0], position[:, 1]
        points = curve(time, (east, north), line_starts(target, time), self.options.curve_points)
        if points.of == 0:
            return
        self.picked.append(points)
        self.traces.append(
            trace(
                "truth",
                points.take(east),
                points.take(north),
                name="true path",
                # A target seen once has no line.
                mode="lines+markers" if points.shown <= theme.DOTTED_TRUTH else "lines",
                line={"color": theme.TRUTH, "width": 1, "dash": "dash"},
                marker={"color": theme.TRUTH, "size": 2.5},
                customdata=points.take(row),
                text=points.take(time),
                **hover(points, "true position", f"{PLACE}<br>{when}", [("target", np.array(names, object)[target])]),
            )
        )
        name_pieces(self.traces[-1], [names[target[i]] for i in points.piece_starts.tolist()])

    def add_plots(self) -> None:
        """Plots of radars as grey points."""
        if not isinstance(self.recording, AntennaPlots | PolarPlots):
            return
        where = plot_positions(self.recording)
        points = thin(np.flatnonzero(np.isfinite(where.east_m + where.north_m)), self.options.marks)
        self.picked.append(points)
        self.traces.append(
            trace(
                "measurement",
                points.take(where.east_m),
                points.take(where.north_m),
                name="plot",
                mode="markers",
                marker={"color": theme.MEASUREMENT, "size": 4},
                customdata=points.take(self.recording.row),
                text=points.take(self.recording.time_s),
                **hover(points, "plot", f"{PLACE}<br>{MARK}"),
            )
        )
        if where.slant_as_ground:
            count = counted(where.slant_as_ground, "slant range")
            text = f"Drawn as ground ranges for want of elevation and altitude: {count}."
            self.notes.append(ChartNote("slant_as_ground", text))
        if where.radar_at_origin:
            text = "The site does not name every radar; its plots are drawn around the origin."
            self.notes.append(ChartNote("radar_at_origin", text))

    def add_stations(self, receptions: Mapping[str, int] | None = None) -> None:
        """Stations, radars and terminals; the area of a station's marker stands for its receptions."""
        if self.recording.site is None:
            return
        positions, names, words = _places(self.recording.site)
        if not names:
            return
        size: Any = 9
        if receptions and max(receptions.values()) > 0:
            got = np.array([receptions.get(name, 0) for name in names], float)
            # A station that received nothing stays visible.
            size = (5 + 15 * np.sqrt(got / got.max())).astype(np.float32) if got.max() > 0 else 5
            counts = [thousands(receptions.get(name, 0)) for name in names]
            words = [f"{word}<br>{count} receptions" for word, count in zip(words, counts, strict=True)]
        self.traces.append(
            trace(
                "station",
                positions[:, 0],
                positions[:, 1],
                name="station",
                mode="markers+text" if len(names) <= NAMED_STATIONS else "markers",
                text=names,
                hovertext=words,
                textposition="top center",
                textfont={"size": 11, "color": theme.STATION},
                marker={
                    "symbol": "triangle-up",
                    "size": size,
                    "opacity": 1,
                    "color": theme.STATION,
                    "line": {"color": theme.SURFACE, "width": 1},
                },
                hovertemplate=f"%{{hovertext}}<br>{PLACE}<extra></extra>",
            )
        )

    def first_view(self) -> tuple[tuple[float, float], tuple[float, float]] | None:
        """Ends of the first view, east and north, m; None where nothing has a place."""
        east, north, fixed = self._shown()
        return (_view(east, fixed), _view(north, fixed)) if east.size else None

    def _shown(self) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        """Points that decide what is in view, and which of them must be in it."""
        shown = [t for t in self.traces if t["meta"]["role"] not in OUTLINES]
        if not shown:
            return np.empty(0), np.empty(0), np.empty(0, bool)
        east, north = (np.concatenate([np.asarray(t[key], np.float64) for t in shown]) for key in "xy")
        finite = np.isfinite(east) & np.isfinite(north)
        fixed = np.concatenate([np.full(len(t["x"]), t["meta"]["role"] in FIXED) for t in shown])
        return east[finite], north[finite], fixed[finite]

    def draw(self, title: str) -> Figure:
        """Scale every trace to one unit and put the figure together."""
        east, north, fixed = self._shown()
        if not east.size:
            return not_applicable(title, "no_position")
        view = _view(east, fixed), _view(north, fixed)
        inside = np.ones(east.size, bool)
        for values, (low, high) in zip((east, north), view, strict=True):
            inside &= (values >= low) & (values <= high)
        if not inside.all():
            self.notes.append(outside_view(int((~inside).sum()), inside.size, "point"))
        in_km = max(high - low for low, high in view) >= KILOMETRES_FROM_M
        scale, unit, digits = (1e-3, "km", 3) if in_km else (1.0, "m", 1)
        place = f"%{{x:.{digits}f}} {unit} east, %{{y:.{digits}f}} {unit} north"
        for t in self.traces:
            t["x"] = self.options.number(np.asarray(t["x"]) * scale)
            t["y"] = self.options.number(np.asarray(t["y"]) * scale)
            if "hovertemplate" in t:
                t["hovertemplate"] = t["hovertemplate"].replace(PLACE, place)
        x_range, y_range = ([low * scale, high * scale] for low, high in view)
        return figure(
            title,
            self.traces,
            recording=self.recording,
            picked=self.picked,
            notes=self.notes,
            xaxis=axis(f"East, {unit}", range=x_range),
            yaxis=axis(f"North, {unit}", range=y_range, scaleanchor="x", scaleratio=1),
            dragmode="pan",
        )


def _view(values: Floats, fixed: NDArray[np.bool_]) -> tuple[float, float]:
    low, high = np.percentile(values, (5, 95))
    reach = VIEW_SPANS * max(high - low, 1.0)
    near = values[fixed | ((values >= low - reach) & (values <= high + reach))]
    low, high = float(near.min()), float(near.max())
    margin = max(0.05 * (high - low), 50.0)
    return low - margin, high + margin


def _places(site: Site) -> tuple[Floats, list[str], list[str]]:
    """Positions of everything on the site, names, and names with what they name."""
    groups = (
        ("station", site.stations, site.station_positions),
        ("radar", site.radars, site.radar_positions),
        ("terminal", (*site.transmitters, *site.receivers), site.terminal_positions),
    )
    present = [(word, places, positions()) for word, places, positions in groups if places]
    if not present:
        return np.empty((0, 3)), [], []
    names = [place.name for _, places, _ in present for place in places]
    words = [f"{word} {place.name}" for word, places, _ in present for place in places]
    return np.vstack([positions for _, _, positions in present]), names, words
