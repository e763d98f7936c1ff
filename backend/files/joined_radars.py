"""Radars of several recordings in one site: names of their own, places in one frame, azimuths from one north."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pymap3d

from algorithms.errors import InputError
from algorithms.recording import PolarPlots
from algorithms.result import Note
from algorithms.site import Origin, Radar, Site
from algorithms.toolbox.frames.between import FrameChange, frame_change


@dataclass(frozen=True)
class NamedRadars:
    """What the radars of all recordings are called from now on.

    Attributes
    ----------
    names : for each recording the names of its `radars`
    radars : all that the sites place, in one frame
    notes : which got another name
    """

    names: tuple[tuple[str, ...], ...]
    radars: tuple[Radar, ...]
    notes: tuple[Note, ...]


def named_apart(recordings: Sequence[str], parts: Sequence[PolarPlots], origin: Origin | None) -> NamedRadars:
    """Give radars of different sites different names; those of equal sites are the same radars.

    Raises
    ------
    InputError
        A radar of the plots stands neither in the site nor in the plots themselves.
    """
    books: list[dict[str, str]] = []
    names: list[tuple[str, ...]] = []
    radars: dict[str, Radar] = {}
    taken: set[str] = set()
    notes: list[Note] = []
    for i, part in enumerate(parts):
        site = _site(part)
        same = next((k for k in range(i) if parts[k].site == site), None)
        book = {} if same is None else dict(books[same])
        in_site = [_name_in_site(part, name) for name in part.radars]
        _require_places(i, recordings[i], part, in_site)
        wanted = [*(r.name for r in site.radars), *(a for a, b in zip(part.radars, in_site, strict=True) if b is None)]
        for name in dict.fromkeys(wanted):
            if name not in book:
                book[name] = _free(name, i + 1, taken)
                if book[name] != name:
                    text = f"Radar {name!r} of {recordings[i]!r} is called {book[name]!r}."
                    notes.append(Note("radar_renamed", text))
        taken |= set(book.values())
        for radar in site.radars:
            called = book[radar.name]
            radars.setdefault(called, _in_frame(radar, site, origin).model_copy(update={"name": called}))
        books.append(book)
        names.append(tuple(book[b or a] for a, b in zip(part.radars, in_site, strict=True)))
    return NamedRadars(tuple(names), tuple(radars.values()), tuple(notes))


def turned_azimuths(part: PolarPlots, own: Origin, change: FrameChange) -> PolarPlots:
    """Count azimuths, and plots given as east and north, from the north that holds in the new frame.

    A moving radar keeps to the north of the frame, so it takes that of the new one; one that gets a place in WGS-84
    takes its own north; one that has it keeps it.
    """
    by_radar = np.zeros(len(part.radars))
    site = _site(part)
    for i, name in enumerate(part.radars):
        radar = next((r for r in site.radars if r.name == _name_in_site(part, name)), None)
        if radar is not None and not radar.is_geodetic:
            by_radar[i] = frame_change(own, _place(radar, own)).turn_rad
    moving = np.isfinite(part.radar_east_m) & np.isfinite(part.radar_north_m)
    turn = np.where(moving, change.turn_rad, by_radar[part.radar])[:, None]
    cos, sin = np.cos(turn), np.sin(turn)
    return replace(
        part,
        azimuth_rad=np.mod(part.azimuth_rad + turn, 2 * np.pi),
        east_m=part.east_m * cos + part.north_m * sin,
        north_m=part.north_m * cos - part.east_m * sin,
    )


def _site(part: PolarPlots) -> Site:
    assert part.site is not None, "recordings without a site are refused before"
    return part.site


def _name_in_site(part: PolarPlots, name: str) -> str | None:
    """Name under which the site places a radar of the plots; a single radar needs no name in the file."""
    placed = [radar.name for radar in _site(part).radars]
    if len(placed) == 1 and len(part.radars) == 1:
        return placed[0]
    return name if name in placed else None


def _require_places(i: int, recording: str, part: PolarPlots, in_site: Sequence[str | None]) -> None:
    moving = np.isfinite(part.radar_east_m) & np.isfinite(part.radar_north_m)
    for k, (name, found) in enumerate(zip(part.radars, in_site, strict=True)):
        if found is None and not moving[part.radar == k].all():
            placed = ", ".join(radar.name for radar in _site(part).radars) or "none"
            raise InputError(
                f"The site of {recording!r} does not place its radar {name!r}; it places {placed}.",
                pointer=f"/{i}/site/radars",
                remedy="Read it again with a site that names every radar.",
                code="radar_without_place",
            )


def _free(name: str, number: int, taken: Collection[str]) -> str:
    free = name
    while free in taken or not free:
        free = f"{name or 'radar'} ({number})"
        number += 1
    return free


def _in_frame(radar: Radar, site: Site, origin: Origin | None) -> Radar:
    """Return the radar, placed in WGS-84 where its local frame is not that of `origin`."""
    own = site.frame_origin()
    if radar.is_geodetic or own is None or own == origin:
        return radar
    place = _place(radar, own)
    local = {"east_m": None, "north_m": None, "up_m": None}
    return radar.model_copy(update={**local, **place.model_dump()})


def _place(radar: Radar, own: Origin) -> Origin:
    """Return the place of a radar of the frame at `own` in WGS-84."""
    local = (radar.east_m, radar.north_m, radar.up_m or 0.0)
    place = pymap3d.enu2geodetic(*local, own.latitude_deg, own.longitude_deg, own.height_m)
    names = ("latitude_deg", "longitude_deg", "height_m")
    return Origin(**dict(zip(names, (float(v) for v in place), strict=True)))
