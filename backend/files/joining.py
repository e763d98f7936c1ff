"""Recordings of several radars become one: a common frame and start, radars with names of their own, rows numbered on.

Unlike the files of one recording (`merging`), recordings have been read apart, each with its own site. The frame of the
first one becomes that of all. A radar in another frame gets its place in WGS-84, and its azimuths are turned by the
angle between its frame's north and its own; elevations stay as the radar measured them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from algorithms.errors import InputError
from algorithms.recording import PolarPlots, Recording
from algorithms.result import Note
from algorithms.site import SAME_PLACE_M, Origin, Site
from algorithms.toolbox.frames.between import frame_change
from backend.files.joined_radars import named_apart, turned_azimuths
from backend.files.joined_tracks import joined_tracks
from backend.files.merging import joined_rows
from backend.files.times import utc_seconds

_ORIGIN_REMEDY = "Give each site its `origin` in WGS-84, or places of all radars in one local frame."


@dataclass(frozen=True)
class Joined:
    """One recording made of several.

    Attributes
    ----------
    first_rows : how the rows of each recording are numbered on: its row 1 is this one
    notes : what was assumed, and what was named anew
    """

    recording: PolarPlots
    first_rows: tuple[int, ...]
    notes: tuple[Note, ...]


def join_recordings(named: Sequence[tuple[str, Recording]]) -> Joined:
    """Join recordings of polar plots, each given with its name, into the frame of the first one.

    Raises
    ------
    InputError
        They cannot be joined; the pointer names the recording and its field: `/1/site/origin`.
    """
    parts: list[PolarPlots] = []
    names = [name for name, _ in named]
    for i, (name, recording) in enumerate(named):
        if not isinstance(recording, PolarPlots):
            raise InputError(
                f"Only plots of radars can be joined, and {name!r} holds {recording.kind}.",
                pointer=f"/{i}",
                remedy="Give its files together as one recording.",
                code="mixed_kinds",
            )
        parts.append(recording)
    origin, notes = _common_frame(names, [p.site for p in parts])
    shifts_s, start_utc, of_times = _common_start(names, [p.start_utc for p in parts])
    radars = named_apart(names, parts, origin)
    first_rows = _first_rows(parts)
    moved = [
        _moved(part, origin, shift_s, first_row - 1, own)
        for part, shift_s, first_row, own in zip(parts, shifts_s, first_rows, radars.names, strict=True)
    ]
    tracks, of_tracks = joined_tracks([p.truth_tracks for p in moved])
    one = joined_rows(moved)
    one = replace(one, site=Site(origin=origin, radars=radars.radars), start_utc=start_utc, truth_tracks=tracks)
    one = one.take(np.argsort(one.time_s, kind="stable"))
    told = [
        Note("rows_numbered_on", f"Row 1 of {name!r} is row {row}.")
        for name, row in zip(names[1:], first_rows[1:], strict=True)
    ]
    return Joined(one, first_rows, (*notes, *of_times, *radars.notes, *of_tracks, *told))


def _common_frame(names: Sequence[str], sites: Sequence[Site | None]) -> tuple[Origin | None, list[Note]]:
    """Origin of the frame of all, None where they share a local one, with what had to be assumed."""
    known: list[Site] = []
    for i, (name, site) in enumerate(zip(names, sites, strict=True)):
        if site is None:
            raise InputError(
                f"The recording {name!r} has no site, so its radar stands nowhere.",
                pointer=f"/{i}/site",
                remedy="Read it again with a `site` (POST /api/v1/recordings, from_recording_id).",
                code="site_missing",
            )
        known.append(site)
    if all(site == known[0] for site in known):
        note = Note("same_site", "The recordings have the same site: radars of one name are one radar.")
        return known[0].frame_origin(), [note]
    origins = [site.frame_origin() for site in known]
    if all(origin is not None for origin in origins):
        return origins[0], []
    if all(origin is None for origin in origins):
        _stand_apart(names, known)
        note = Note(
            "one_local_frame",
            "No site has an origin in WGS-84: the places of all radars are taken as being in one local frame.",
        )
        return None, [note]
    i = origins.index(None)
    raise InputError(
        f"The site of {names[i]!r} has no origin and those of other recordings have one, so it is unknown where they "
        "stand to each other.",
        pointer=f"/{i}/site/origin",
        remedy=_ORIGIN_REMEDY,
        code="origin_missing",
    )


def _stand_apart(names: Sequence[str], sites: Sequence[Site]) -> None:
    """Refuse radars of different recordings at one place: their frames are then hardly the same."""
    for (i, one), (k, other) in combinations(enumerate(sites), 2):
        apart = np.linalg.norm(one.radar_positions()[:, None] - other.radar_positions()[None], axis=2)
        if apart.size and apart.min() < SAME_PLACE_M:
            a, b = np.unravel_index(int(apart.argmin()), apart.shape)
            raise InputError(
                f"Radar {one.radars[a].name!r} of {names[i]!r} and {other.radars[b].name!r} of {names[k]!r} stand at "
                "the same place, each in a local frame without an origin, so it is unknown where they stand to each "
                "other.",
                pointer=f"/{k}/site/origin",
                remedy=_ORIGIN_REMEDY,
                code="origin_missing",
            )


def _common_start(names: Sequence[str], starts: Sequence[str | None]) -> tuple[list[float], str | None, list[Note]]:
    """Seconds to add to the times of each, and the instant from which all count then."""
    known = [utc_seconds(s) for s in starts if s is not None]
    if not known:
        note = Note("one_clock", "No recording has a date: the times of all are taken as counting from one instant.")
        return [0.0] * len(starts), None, [note]
    if len(known) < len(starts):
        i = starts.index(None)
        raise InputError(
            f"It is not known when {names[i]!r} began, and of other recordings it is.",
            pointer=f"/{i}/start_utc",
            remedy="Read it again with the option `start_utc`.",
            code="mixed_time_bases",
        )
    earliest = min(known)
    return [s - earliest for s in known], starts[known.index(earliest)], []


def _first_rows(parts: Sequence[PolarPlots]) -> tuple[int, ...]:
    rows = [int(part.row.max()) if len(part) else 0 for part in parts]
    return tuple(1 + sum(rows[:i]) for i in range(len(rows)))


def _moved(
    part: PolarPlots, origin: Origin | None, shift_s: float, row_offset: int, names: tuple[str, ...]
) -> PolarPlots:
    """Count times, rows and places of a recording as the joined one does."""
    tracks = part.truth_tracks
    if tracks is not None:
        tracks = replace(tracks, time_s=tracks.time_s + shift_s)
    own = None if part.site is None else part.site.frame_origin()
    if own is not None and origin is not None and own != origin:
        change = frame_change(own, origin)
        if tracks is not None:
            position, velocity = change.points(tracks.position_m), change.vectors(tracks.velocity_mps)
            tracks = replace(tracks, position_m=position, velocity_mps=velocity)
        # Before the radar's own place moves: azimuths turn by what lies between the old place and the new frame.
        part = turned_azimuths(part, own, change)
        radar = np.column_stack([part.radar_east_m, part.radar_north_m, np.zeros(len(part))])
        radar = change.points(radar)
        part = replace(
            part,
            radar_east_m=radar[:, 0],
            radar_north_m=radar[:, 1],
            truth_m=change.points(part.truth_m),
            truth_velocity_mps=change.vectors(part.truth_velocity_mps),
        )
    return replace(part, time_s=part.time_s + shift_s, row=part.row + row_offset, radars=names, truth_tracks=tracks)
