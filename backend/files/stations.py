"""Bring a recording and its site together: order of the stations, stations without a position, accuracies, origin."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from difflib import get_close_matches

import numpy as np
import pymap3d

from algorithms.errors import InputError
from algorithms.recording import PolarPlots, ToaMarks
from algorithms.site import SAME_PLACE_M, Origin, Site
from backend.files.merging import spread_stations
from backend.files.reader import Part
from backend.files.report import Findings, some
from backend.files.site_source import SensorTable, SiteSource, validated_site


def fit_site(part: Part, source: SiteSource | None, origin: Origin | None, findings: Findings) -> Part:
    """Give the recording its site.

    A mark that keeps neither a reception nor an altitude is left for the caller to reject.

    Raises InputError where the names or the origins contradict each other.
    """
    recording = part.recording
    if source is None and part.site is not None:
        source = part.site
        names = [r.name for r in source.radars]
        findings.warn("site_from_file", f"No site was given; the file itself places {some(names)}.", len(names))
    if source is None:
        return part
    if isinstance(source, SensorTable):
        if not isinstance(recording, ToaMarks):
            raise InputError(
                f"A sensor table describes receivers, and this recording holds {recording.kind}.",
                pointer="/site",
                remedy="Give Site JSON with radars, or with transmitters and receivers.",
                code="site_kind",
            )
        recording, site = _from_table(recording, part.station_columns, source, origin, findings)
    else:
        site = _with_origin(source, origin)
        if isinstance(recording, ToaMarks):
            recording = _fit_stations(recording, part.station_columns, site, findings)
        elif isinstance(recording, PolarPlots):
            recording = _fit_radars(recording, site)
    missing = {n: v for n, v in part.site_defaults.items() if getattr(site, n) is None}
    site = site.model_copy(update=missing)
    return replace(part, recording=replace(recording, site=site))


def _with_origin(site: Site, origin: Origin | None) -> Site:
    if origin is not None and site.origin is not None and origin != site.origin:
        raise InputError(
            "The options and the site give different origins.",
            pointer="/options/origin",
            remedy="Give the origin in one of the two.",
            code="origin_twice",
        )
    return site.model_copy(update={"origin": origin or site.frame_origin()})


def _from_table(
    marks: ToaMarks,
    station_columns: Mapping[str, str],
    table: SensorTable,
    origin: Origin | None,
    findings: Findings,
) -> tuple[ToaMarks, Site]:
    """Keep the stations that have receptions and a position of their own."""
    received = np.isfinite(marks.toa_s).any(axis=2).sum(axis=0)
    unknown = [s for s in marks.stations if s not in table.positions]
    if station_columns and unknown:
        _raise_unknown(unknown[0], station_columns, list(table.positions))
    placed: list[str] = []
    without: list[str] = []
    for name, count in zip(marks.stations, received.tolist(), strict=True):
        if count and table.positions.get(name) is not None:
            placed.append(name)
        elif count:
            without.append(name)
    if without:
        lost = int(received[[marks.stations.index(n) for n in without]].sum())
        findings.warn(
            "station_without_position",
            f"Receptions of stations without a position in the sensor table were left out: {some(without)}.",
            lost,
        )
    geodetic = np.array([table.positions[n] for n in placed], float).reshape(-1, 3)
    ecef = np.stack(pymap3d.geodetic2ecef(*geodetic.T), axis=1)
    used: list[int] = []
    for i in range(len(placed)):
        near = [j for j in used if np.linalg.norm(ecef[i] - ecef[j]) < SAME_PLACE_M]
        if not near:
            used.append(i)
            continue
        findings.warn(
            "station_same_place",
            f"Station {placed[i]} stands at the same place as station {placed[near[0]]} in the sensor table, which "
            f"cannot be; the receptions of {placed[i]} were left out.",
            int(received[marks.stations.index(placed[i])]),
        )
    if len(used) < 2:
        raise InputError(
            f"Only {len(used)} station with receptions has a position of its own in the sensor table.",
            pointer="/site",
            remedy="Give the table that belongs to this recording.",
            code="too_few_stations",
        )
    stations = [
        {"name": placed[i], "latitude_deg": lat, "longitude_deg": lon, "height_m": height}
        for i, (lat, lon, height) in ((i, geodetic[i].tolist()) for i in used)
    ]
    site = _with_origin(validated_site({"stations": stations}), origin)
    names = tuple(s.name for s in site.stations)
    return replace(marks, toa_s=spread_stations(marks, names), stations=names), site


def _fit_stations(marks: ToaMarks, station_columns: Mapping[str, str], site: Site, findings: Findings) -> ToaMarks:
    """Order the columns as the site orders its stations."""
    names = tuple(s.name for s in site.stations)
    if not names:
        raise InputError(
            "The site has no stations, and the recording holds times of arrival.",
            pointer="/site/stations",
            remedy="Give the stations with their positions.",
            code="site_kind",
        )
    unknown = [s for s in marks.stations if s not in names]
    if unknown and station_columns:
        _raise_unknown(unknown[0], station_columns, names)
    if unknown:
        columns = [marks.stations.index(s) for s in unknown]
        lost = int(np.isfinite(marks.toa_s[:, columns]).any(axis=2).sum())
        findings.warn(
            "station_without_position",
            f"Receptions of stations that the site does not name were left out: {some(unknown)}.",
            lost,
        )
    if len(unknown) == len(marks.stations):
        raise InputError(
            f"No station of the recording is in the site. The recording has {some(marks.stations)}, the site "
            f"{some(names)}.",
            pointer="/site/stations",
            remedy="Give the site that belongs to this recording.",
            code="station_unknown",
        )
    silent = [n for n in names if n not in marks.stations]
    if silent:
        findings.warn(
            "station_without_receptions", f"Stations of the site that the recording lacks: {some(silent)}.", len(silent)
        )
    return replace(marks, toa_s=spread_stations(marks, names), stations=names)


def _raise_unknown(station: str, station_columns: Mapping[str, str], known: list[str] | tuple[str, ...]) -> None:
    near = get_close_matches(station, known, 1)
    raise InputError(
        f"Column {station_columns[station]!r} belongs to a station {station!r} that the site does not have; its "
        f"stations are {some(known)}.",
        pointer="/site/stations",
        remedy=f"Did you mean {near[0]!r}?" if near else "Name the station in the site, or rename the column.",
        code="station_unknown",
    )


def _fit_radars(plots: PolarPlots, site: Site) -> PolarPlots:
    names = tuple(r.name for r in site.radars)
    if not names:
        raise InputError(
            "The site has no radars, and the recording holds plots.",
            pointer="/site/radars",
            remedy="Give the radar with its position.",
            code="site_kind",
        )
    used = [plots.radars[i] for i in np.unique(plots.radar)]
    if used == [""] and len(names) == 1:
        return replace(plots, radar=np.zeros(len(plots), np.int64), radars=names)
    unknown = [r for r in used if r not in names]
    if unknown:
        what = f"the radar {unknown[0]!r}" if unknown[0] else "no radar"
        raise InputError(
            f"Plots name {what}; the radars of the site are {some(names)}.",
            pointer="/site/radars",
            remedy="Use the same names in the site and in the column radar.",
            code="radar_unknown",
        )
    table = np.array([names.index(r) if r in names else -1 for r in plots.radars], np.int64)
    return replace(plots, radar=table[plots.radar], radars=names)
