"""Lines of equal geometric factor under the plan of a run on marks: where the stations see well."""

from __future__ import annotations

import numpy as np

from algorithms.errors import FrameError
from algorithms.recording import Recording, ToaMarks
from algorithms.toolbox.bounds.accuracy_map import Altitude, places_at, plan_bound
from algorithms.toolbox.frames.earth import altitude_from_position, sphere, wgs84
from backend.charts import theme
from backend.charts.contours import contour_lines, contour_traces, levels_between
from backend.charts.figure import ChartNote
from backend.charts.plane import Plane

# The factor is of a mark that all receive; where stations are many none ever is.
MOST_STATIONS = 8
COUNT = 80
# A panel's width over its height.
WIDEST = 2.0
# Emitters of whose altitude nothing is known.
ALTITUDE_M = 6_000.0
QUANTILES = (0.02, 0.98)


def add_gdop_lines(plane: Plane, recording: Recording) -> None:
    """Put lines of the geometric factor under everything that the plan holds already.

    In space where four stations or more stand, at a known altitude where three do; at the median altitude of the
    recording. Nothing where there is no site, or a place beyond the Earth's edge.
    """
    if not isinstance(recording, ToaMarks) or recording.site is None:
        return
    stations = recording.site.station_positions()
    view = plane.first_view()
    if view is None or not 3 <= len(stations) <= MOST_STATIONS:
        return
    origin = recording.site.frame_origin()
    earth = sphere() if origin is None else wgs84(origin)
    altitude = recording.altitude_m[np.isfinite(recording.altitude_m)]
    if not altitude.size and recording.has_truth:
        heights = altitude_from_position(recording.truth_m.reshape(-1, 3), earth)
        altitude = heights[np.isfinite(heights)]
    height = round(float(np.median(altitude)), -2) if altitude.size else ALTITUDE_M
    # The page shows more than the view in one direction, since both have one scale.
    spans = [high - low for low, high in view]
    halves = max(spans[0], WIDEST * spans[1]) / 2, max(spans) / 2
    middles = (sum(ends) / 2 for ends in view)
    east, north = (np.linspace(m - half, m + half, COUNT) for m, half in zip(middles, halves, strict=True))
    try:
        grid_east, grid_north = np.meshgrid(east, north)
        places = places_at(grid_east.ravel(), grid_north.ravel(), height, earth)
    except FrameError:
        return
    kind: Altitude = "none" if len(stations) > 3 else "known"
    factor = plan_bound(places, stations, np.ones(len(stations)), kind).drms_m.reshape(COUNT, COUNT)
    known = factor[np.isfinite(factor)]
    if not known.size:
        return
    low, high = np.quantile(known, QUANTILES)
    lines = contour_lines(east, north, factor, levels_between(float(low), float(high)))
    plane.traces[:0] = contour_traces(lines, "GDOP", "", theme.BOUND)
    if lines:
        words = "in space" if kind == "none" else "its altitude known"
        text = f"Thin lines: GDOP of a mark that all stations receive, at {height:.0f} m, {words}."
        plane.notes.append(ChartNote("gdop_lines", text))
