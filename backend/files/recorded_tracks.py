"""Recorded tracks, thinned to points that a simulated target can follow: true paths are read, nothing measured.

Reports of a tracker are noisy and come every few seconds; a curve through all of them would shake. So points are taken
at least `spacing_s` apart, each a report as it was given, and what cannot be a path is left out and counted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints
from backend.files.content import NamedFile
from backend.files.options import ReadLimits, ReadOptions
from backend.files.reading import read_truth
from backend.files.report import Findings
from backend.files.times import utc_text
from backend.files.truth_file import TruthPoints

# What a scenario takes.
MOST_POINTS = 2000
MOST_TARGETS = 100
# Nothing that a radar follows is faster between two reports; such a report is an error of the tracker.
_FASTEST_MPS = 1_000.0
_DEGREE_M = 111_195.0


class TrackChoice(BaseModel):
    """Which tracks of a file become targets, and how closely they are followed."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    targets: Annotated[list[Annotated[str, Field(max_length=200)]], Field(max_length=100)] = []
    """Names of the tracks; without them the longest ones are taken."""
    most_targets: Annotated[int, Field(ge=1, le=100)] = 10
    """How many of the longest tracks."""
    first_s: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Reports before it are left out; counted from the first report of the file."""
    last_s: Annotated[float, Field(gt=0, le=1e6)] | None = None
    """Reports after it are left out."""
    spacing_s: Annotated[float, Field(ge=0, le=3600)] = 15.0
    """Least time between two points; 0 takes every report."""
    gap_s: Annotated[float, Field(gt=0, le=1e6)] = 120.0
    """A longer pause ends a track; what follows under the same name is another one."""

    @model_validator(mode="after")
    def _forwards(self) -> Self:
        if self.last_s is not None and self.last_s <= self.first_s:
            raise ValueError("last_s must be later than first_s")
        return self


@dataclass(frozen=True)
class RecordedTrack:
    """A track as points.

    Attributes
    ----------
    time_s : (K,) float, s from the whole second in which the first chosen track begins
    place : (K, 3) float, latitude and longitude in degrees and height in m where `is_geodetic`, else ENU in m
    reports : how many reports it had
    left_out : how many of them could not be used, by reason
    """

    name: str
    time_s: Floats
    place: Floats
    is_geodetic: bool
    reports: int
    left_out: Mapping[str, int]

    def to_json(self) -> dict[str, Any]:
        """As plain lists."""
        return {
            "name": self.name,
            "time_s": self.time_s.tolist(),
            "place": self.place.tolist(),
            "is_geodetic": self.is_geodetic,
            "reports": self.reports,
            "left_out": dict(self.left_out),
        }


@dataclass(frozen=True)
class RecordedTracks:
    """The tracks that were chosen, how many there were, and the instant from which their times count."""

    tracks: Sequence[RecordedTrack]
    found: int
    start_utc: str | None


def read_tracks(
    file: NamedFile, options: ReadOptions, limits: ReadLimits, choice: TrackChoice, findings: Findings
) -> RecordedTracks:
    """Read a file of true paths, of any format that is read as the truth of a recording.

    Raises
    ------
    InputError
        Nothing of the file can serve, or a track that was named is not in it; `pointer` names the field.
    """
    try:
        points = read_truth(file, options, limits, "polar_plots", findings)
    except InputError as error:
        # Here the file is what a truth is elsewhere.
        pointer = error.pointer.replace("/truth", "/file", 1) if error.pointer.startswith("/truth") else error.pointer
        raise InputError(error.message, pointer=pointer, remedy=error.remedy, code=error.code) from error
    start_s = float(points.time_s.min())
    found = _parted(points, choice, start_s)
    named = {name.partition(" (")[0] for name, _ in found} | {name for name, _ in found}
    missing = [name for name in choice.targets if name not in named]
    if missing:
        raise InputError(
            f"The file has no track {missing[0]!r} with two reports or more in that time.",
            pointer=f"/options/tracks/targets/{choice.targets.index(missing[0])}",
            remedy="Leave the names out to get the longest tracks with theirs.",
            code="track_unknown",
        )
    if not found:
        raise InputError(
            "No track of the file has two reports or more in that time.",
            pointer="/file",
            remedy="Widen the time, or the longest pause `gap_s`.",
            code="no_tracks",
        )
    if choice.targets:
        chosen = [(n, rows) for n, rows in found if n in choice.targets or n.partition(" (")[0] in choice.targets]
    else:
        by_length = sorted(found, key=lambda track: -float(np.ptp(points.time_s[track[1]])))
        kept = {name for name, _ in by_length[: choice.most_targets]}
        chosen = [track for track in found if track[0] in kept]
    chosen = chosen[:MOST_TARGETS]
    # The simulated day begins with its first target, at a whole second.
    begin_s = float(np.floor(min(points.time_s[rows[0]] for _, rows in chosen)))
    return RecordedTracks(
        tracks=[_thinned(name, points, rows, begin_s, choice.spacing_s) for name, rows in chosen],
        found=len(found),
        start_utc=None if points.epoch_s is None else utc_text(points.epoch_s + int(begin_s)),
    )


def _parted(points: TruthPoints, choice: TrackChoice, start_s: float) -> list[tuple[str, Ints]]:
    """Name and rows of each track in order of time, parted where it pauses."""
    time = points.time_s - start_s
    inside = (time >= choice.first_s) & (time <= (np.inf if choice.last_s is None else choice.last_s))
    out: list[tuple[str, Ints]] = []
    order = np.lexsort((time, points.target))
    order = order[inside[order]]
    breaks = np.flatnonzero((np.diff(points.target[order]) != 0) | (np.diff(time[order]) > choice.gap_s)) + 1
    count: dict[str, int] = {}
    for rows in np.split(order, breaks):
        if len(rows) < 2:
            continue
        name = points.targets[points.target[rows[0]]] or "1"
        count[name] = count.get(name, 0) + 1
        out.append((name if count[name] == 1 else f"{name} ({count[name]})", rows))
    return out


def _thinned(name: str, points: TruthPoints, rows: Ints, begin_s: float, spacing_s: float) -> RecordedTrack:
    geodetic = points.truth_geodetic
    is_geodetic = geodetic is not None and bool(np.isfinite(geodetic[rows]).all())
    place = (geodetic if is_geodetic and geodetic is not None else points.truth_m)[rows].copy()
    metres = place.copy()
    if is_geodetic:
        place[:, :2] = np.degrees(place[:, :2])
        east = np.cos(np.radians(place[:, 0])) * place[:, 1]
        metres = np.column_stack([east * _DEGREE_M, place[:, 0] * _DEGREE_M, place[:, 2]])
    time = points.time_s[rows] - begin_s
    left_out = {"unknown_place": 0, "same_time": 0, "jump": 0}
    # A track that is longer than a target may be is followed less closely.
    spacing_s = max(spacing_s, float(np.ptp(time)) / (MOST_POINTS - 2))
    kept: list[int] = []
    for i in range(len(rows)):
        if not np.isfinite(metres[i]).all():
            left_out["unknown_place"] += 1
            continue
        if kept:
            step = time[i] - time[kept[-1]]
            if step <= 0:
                left_out["same_time"] += 1
                continue
            if np.linalg.norm(metres[i] - metres[kept[-1]]) > _FASTEST_MPS * step:
                left_out["jump"] += 1
                continue
            if step < spacing_s and i < len(rows) - 1:
                continue
        kept.append(i)
    return RecordedTrack(
        name, time[kept], place[kept], is_geodetic, len(rows), {k: v for k, v in left_out.items() if v}
    )
