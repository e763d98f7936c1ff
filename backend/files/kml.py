"""Tracks as KML 2.2 with `gx:Track`, which a globe plays in time.

KML knows no relative times: where the start of the recording is unknown its times are counted from 1970, and the
document says so. Heights are over the ellipsoid; a globe takes them as over the sea, tens of metres off.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import TextIO
from xml.sax.saxutils import escape

from backend.files.geo_tracks import GeoPlace, GeoTrack, utc_texts

_UNKNOWN_START = "1970-01-01T00:00:00Z"
# Blue, orange, green, pink, yellow, sky as the charts have them, in KML's order: opacity, blue, green, red.
_COLOURS = ("ffb27200", "ff005ed5", "ff739e00", "ffa779cc", "ff009fe6", "ffe9b456")
_TRUTH_COLOUR = "ff28231f"
# A control character has no place in XML.
_CONTROL = {c: "\ufffd" for c in range(32) if chr(c) not in "\t\n\r"}


def write_kml(
    tracks: Iterable[GeoTrack],
    places: Sequence[GeoPlace],
    stream: TextIO,
    *,
    name: str,
    labels: Sequence[str],
    start_utc: str | None,
) -> None:
    """Write a document with a folder for each algorithm, one for the truth and one for the stations.

    `labels` give the colours; tracks of one label must come together.
    """
    known = "" if start_utc else " The start of the recording is not known: times count from 1970-01-01."
    stream.write(
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">\n<Document>\n'
        f"<name>{_text(name)}</name>\n<description>Heights are over the WGS-84 ellipsoid.{known}</description>\n"
    )
    styles = {"": ("truth", _TRUTH_COLOUR)}
    styles |= {label: (f"s{i}", _COLOURS[i % len(_COLOURS)]) for i, label in enumerate(labels)}
    for style, colour in styles.values():
        stream.write(
            f'<Style id="{style}"><LineStyle><color>{colour}</color><width>2</width></LineStyle>'
            f"<IconStyle><color>{colour}</color><scale>0.5</scale></IconStyle>"
            "<LabelStyle><scale>0.7</scale></LabelStyle></Style>\n"
        )
    if places:
        stream.write("<Folder><name>Stations</name>\n")
        for place in places:
            longitude, latitude, height = place.position
            stream.write(
                f"<Placemark><name>{_text(place.name)}</name><Point><altitudeMode>absolute</altitudeMode>"
                f"<coordinates>{longitude:.8f},{latitude:.8f},{height:.3f}</coordinates></Point></Placemark>\n"
            )
        stream.write("</Folder>\n")
    for label, group in groupby(tracks, key=lambda track: track.label):
        stream.write(f"<Folder><name>{_text(label) or 'Truth'}</name>\n")
        for track in group:
            _write_track(track, styles[label][0], stream, start_utc or _UNKNOWN_START)
        stream.write("</Folder>\n")
    stream.write("</Document>\n</kml>\n")


def _write_track(track: GeoTrack, style: str, stream: TextIO, start_utc: str) -> None:
    stream.write(
        f"<Placemark><name>{_text(track.target or track.name)}</name><description>{_text(track.name)}</description>"
        f"<styleUrl>#{style}</styleUrl><gx:Track><altitudeMode>absolute</altitudeMode>\n"
    )
    stream.writelines(f"<when>{when}</when>\n" for when in utc_texts(track.time_s, start_utc))
    stream.writelines(f"<gx:coord>{x:.8f} {y:.8f} {z:.3f}</gx:coord>\n" for x, y, z in track.position.tolist())
    stream.write("</gx:Track></Placemark>\n")


def _text(words: str) -> str:
    return escape(words.translate(_CONTROL))
