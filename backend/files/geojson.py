"""Tracks as GeoJSON (RFC 7946): a line per track, a point per station, one feature to a line of the file.

A line that crosses the date line is cut there, as section 3.1.9 asks. `coordTimes` beside the coordinates is what
readers of tracks look for; heights are over the WGS-84 ellipsoid, as section 4 wants them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from typing import Any, TextIO

import numpy as np

from algorithms.recording import Floats
from backend.files.geo_tracks import GeoPlace, GeoTrack, utc_texts

# Eight decimals of a degree are a millimetre, and so are three of a metre.
_DECIMALS = np.array([8, 8, 3])


def write_geojson(
    tracks: Iterable[GeoTrack], places: Sequence[GeoPlace], stream: TextIO, *, start_utc: str | None
) -> None:
    """Write a FeatureCollection, feature by feature."""
    stream.write('{"type":"FeatureCollection","features":[')
    separator = "\n"
    for place in places:
        stream.write(
            separator
            + _text(_feature("Point", _rounded(np.array([place.position]))[0], role="station", name=place.name))
        )
        separator = ",\n"
    for track in tracks:
        stream.write(separator + _text(_line(track, start_utc)))
        separator = ",\n"
    stream.write("\n]}\n")


def _line(track: GeoTrack, start_utc: str | None) -> dict[str, Any]:
    parts = _cut_at_the_date_line(track.position, track.time_s)
    about: dict[str, Any] = {
        "role": track.role,
        "name": track.name,
        "label": track.label or None,
        "target": track.target or None,
        "track": track.track or None,
        "time_s": [t.round(6).tolist() for _, t in parts],
    }
    if start_utc is not None:
        about["start_utc"] = start_utc
        about["coordTimes"] = [utc_texts(t, start_utc) for _, t in parts]
    coordinates = [_rounded(p) for p, _ in parts]
    if len(parts) > 1:
        # One point has no line; beside a cut it is drawn as a line without length.
        return _feature("MultiLineString", [c if len(c) > 1 else [*c, *c] for c in coordinates], **about)
    about |= {n: about[n][0] for n in ("time_s", "coordTimes") if n in about}
    if len(coordinates[0]) == 1:
        return _feature("Point", coordinates[0][0], **about)
    return _feature("LineString", coordinates[0], **about)


def _cut_at_the_date_line(position: Floats, time_s: Floats) -> list[tuple[Floats, Floats]]:
    """Parts on either side of 180 degrees, each with the point at which the line crosses it."""
    step = np.diff(position[:, 0])
    crossings = np.flatnonzero(np.abs(step) > 180.0)
    parts: list[tuple[Floats, Floats]] = []
    head_position, head_time = np.empty((0, 3)), np.empty(0)
    start = 0
    for i in crossings.tolist():
        before, after = position[i], position[i + 1].copy()
        side = 180.0 if before[0] > 0 else -180.0
        after[0] += 2 * side
        share = (side - before[0]) / (after[0] - before[0]) if after[0] != before[0] else 0.0
        edge = before + share * (after - before)
        moment = time_s[i] + share * (time_s[i + 1] - time_s[i])
        edge[0] = side
        parts.append(
            (
                np.concatenate([head_position, position[start : i + 1], edge[None]]),
                np.concatenate([head_time, time_s[start : i + 1], [moment]]),
            )
        )
        edge = edge.copy()
        edge[0] = -side
        head_position, head_time, start = edge[None], np.array([moment]), i + 1
    parts.append((np.concatenate([head_position, position[start:]]), np.concatenate([head_time, time_s[start:]])))
    return parts


def _rounded(position: Floats) -> list[list[float]]:
    scale = 10.0**_DECIMALS
    out: list[list[float]] = (np.round(position * scale) / scale).tolist()
    return out


def _feature(kind: str, coordinates: Any, **properties: Any) -> dict[str, Any]:
    return {"type": "Feature", "geometry": {"type": kind, "coordinates": coordinates}, "properties": properties}


def _text(feature: dict[str, Any]) -> str:
    return json.dumps(feature, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
