"""Service messages of radars, CAT 034 and 002: marks of north and sectors, the period, where the radar stands."""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.recording import Floats
from backend.files.asterix.plots import Reports, source_name
from backend.files.turns import TurnMarks

_NORTH, _SECTOR = 1, 2


def turn_marks(messages: Reports, time_s: Floats) -> TurnMarks | None:
    """Marks of north (azimuth 0) and sectors, with the periods that the radars tell; None where there are none."""
    message, sector = messages.codes["message"], messages.numbers["sector"]
    north = message == _NORTH
    known = np.isfinite(time_s) & (messages.source >= 0) & (north | ((message == _SECTOR) & np.isfinite(sector)))
    sources, radar = np.unique(messages.source[known], return_inverse=True)
    periods: dict[str, float] = {}
    for source in np.unique(messages.source[messages.source >= 0]).tolist():
        if np.isfinite(period := told_period(messages, source)):
            periods[source_name(source)] = period
    if not sources.size and not periods:
        return None
    return TurnMarks(
        radars=tuple(source_name(s) for s in sources.tolist()),
        radar=radar.astype(np.int64),
        time_s=time_s[known],
        azimuth_rad=np.where(north, 0.0, sector)[known],
        period_s=periods,
    )


def told_period(messages: Reports, source: int) -> float:
    """Seconds of one turn as a radar says (item 041), the median; NaN where it says nothing."""
    told = messages.numbers["period"][messages.source == source]
    told = told[told > 0]
    return float(np.median(told)) if told.size else np.nan


def radar_places(messages: Reports) -> dict[str, dict[str, Any]]:
    """Radars whose position CAT 034 tells (item 120), as in Site JSON; the last one counts."""
    latitude, longitude, height = (messages.numbers[n] for n in ("latitude", "longitude", "height"))
    places: dict[str, dict[str, Any]] = {}
    told = np.isfinite(latitude) & np.isfinite(longitude) & (messages.source >= 0)
    for source in np.unique(messages.source[told]).tolist():
        i = int(np.flatnonzero(told & (messages.source == source))[-1])
        places[source_name(source)] = {
            "name": source_name(source),
            # Seven decimals are a centimetre; the item resolves two metres.
            "latitude_deg": round(float(np.degrees(latitude[i])), 7),
            "longitude_deg": round(float(np.degrees(longitude[i])), 7),
            "height_m": float(np.nan_to_num(height[i])),
            "range_kind": "slant",
        }
        if np.isfinite(period := told_period(messages, source)):
            places[source_name(source)]["period_s"] = period
    return places
