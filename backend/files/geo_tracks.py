"""Tracks of a run in WGS-84: what a map or a globe draws, before it is written in any form."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pymap3d
from numpy.typing import NDArray

from algorithms.recording import Floats, Ints, Recording
from algorithms.result import Column, Table
from algorithms.site import Origin, Site
from algorithms.texts import Texts

Role = Literal["estimate", "truth"]


@dataclass(frozen=True)
class GeoTrack:
    """One track in order of time.

    Attributes
    ----------
    label : of the algorithm; empty for the truth
    target, track : as the run names them; empty where it does not
    time_s : (N,) float, s from the recording's start
    position : (N, 3) float, longitude and latitude in degrees, height over the ellipsoid in m
    """

    role: Role
    label: str
    target: str
    track: str
    time_s: Floats
    position: Floats

    @property
    def name(self) -> str:
        """Words for it."""
        words = [self.label or "truth", self.target, f"track {self.track}" if self.track else ""]
        return " ".join(w for w in words if w)


@dataclass(frozen=True)
class GeoPlace:
    """A station, a radar or a terminal: longitude and latitude in degrees, height in m."""

    name: str
    position: tuple[float, float, float]


def estimated_tracks(states: Table, origin: Origin) -> Iterator[GeoTrack]:
    """Cut the table `states` of a run into tracks; rows without an estimate are no part of them."""
    n = len(states)
    local = np.stack([_numbers(states, f"{axis}_m", n) for axis in ("east", "north", "up")], axis=1)
    # A flat estimate lies in the plane of the frame.
    local[np.isfinite(local[:, :2]).all(axis=1) & np.isnan(local[:, 2]), 2] = 0.0
    rows = np.flatnonzero(np.isfinite(local).all(axis=1))
    labels, label = _codes(states.columns["label"])
    targets, target = _codes(states.columns.get("target", Texts.repeated(None, n)))
    track, trial = (np.nan_to_num(_numbers(states, name, n), nan=-1.0) for name in ("track", "trial"))
    time_s = _numbers(states, "time_s", n)
    order = rows[np.lexsort((time_s[rows], trial[rows], track[rows], target[rows], label[rows]))]
    keys = np.stack([label, target, track, trial], axis=1)[order]
    position = to_geodetic(local[order], origin)
    for start, stop in _groups(keys):
        first = order[start]
        words = [f"{track[first]:.0f}" if track[first] >= 0 else ""]
        words += [f"trial {trial[first]:.0f}"] if trial[first] >= 0 else []
        yield GeoTrack(
            "estimate",
            labels[label[first]],
            targets[target[first]],
            ", ".join(w for w in words if w),
            time_s[order[start:stop]],
            position[start:stop],
        )


# A place without a name that lies further than this from where the one before was heading is another target's.
_SAME_TARGET_M = 20.0
_SAME_TARGET_SHARE = 0.2


def true_tracks(recording: Recording, origin: Origin) -> Iterator[GeoTrack]:
    """Give the true paths: whole ones where the recording has them, else the truth of its rows.

    Targets that nobody named come one after another under one name: each is a path of its own.
    """
    whole = recording.truth_tracks
    if whole is not None:
        time_s, target, local, names = whole.time_s, whole.target, whole.position_m, whole.targets
        velocity = whole.velocity_mps
    else:
        known = np.flatnonzero(np.isfinite(recording.truth_m).all(axis=1))
        order = known[np.lexsort((recording.time_s[known], recording.target[known]))]
        time_s, target, local = recording.time_s[order], recording.target[order], recording.truth_m[order]
        names, velocity = recording.targets, recording.truth_velocity_mps[order]
    position = to_geodetic(local, origin)
    unnamed = np.array([not name for name in names])[target]
    begins = np.cumsum(_leaps(time_s, local, velocity) & unnamed)
    for start, stop in _groups(np.stack([target, begins], axis=1)):
        yield GeoTrack("truth", "", names[target[start]], "", time_s[start:stop], position[start:stop])


def _leaps(time_s: Floats, local_m: Floats, velocity_mps: Floats) -> NDArray[np.bool_]:
    """Whether a place is none that the one before leads to: by the velocities, or by the steps before and after."""
    if len(time_s) < 2:
        return np.zeros(len(time_s), np.bool_)
    step = np.diff(time_s)[:, None]
    moved = np.diff(local_m, axis=0)
    nothing = np.full((1, 3), np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        speed = moved / step
        told = 0.5 * (velocity_mps[1:] + velocity_mps[:-1])
        fits = np.zeros(len(moved), np.bool_)
        unknown = np.ones(len(moved), np.bool_)
        for one in (told, np.vstack([nothing, speed[:-1]]), np.vstack([speed[1:], nothing])):
            expected = one * step
            known = np.isfinite(expected).all(axis=1)
            if one is not told:
                # Steps speak only where no velocity does.
                known &= ~np.isfinite(told).all(axis=1)
            allowed = _SAME_TARGET_M + _SAME_TARGET_SHARE * np.linalg.norm(expected, axis=1)
            fits |= known & (np.linalg.norm(moved - expected, axis=1) <= allowed)
            unknown &= ~known
    return np.append(False, ~fits & ~unknown)


def places_of(site: Site | None, origin: Origin) -> list[GeoPlace]:
    """Give stations, radars and terminals of a site."""
    if site is None:
        return []
    names = [p.name for p in (*site.stations, *site.radars, *site.transmitters, *site.receivers)]
    local = np.concatenate([site.station_positions(), site.radar_positions(), site.terminal_positions()])
    return [GeoPlace(n, tuple(p)) for n, p in zip(names, to_geodetic(local, origin).tolist(), strict=True)]


def to_geodetic(local: Floats, origin: Origin) -> Floats:
    """(N, 3) east, north, up in m -> longitude, latitude in degrees (-180 to 180), height in m."""
    latitude, longitude, height = pymap3d.enu2geodetic(
        *local.T, origin.latitude_deg, origin.longitude_deg, origin.height_m
    )
    longitude = (np.asarray(longitude) + 180.0) % 360.0 - 180.0
    return np.stack([longitude, latitude, height], axis=1)


def utc_texts(time_s: Floats, start_utc: str) -> Sequence[str]:
    """Instants as ISO 8601 with milliseconds and Z."""
    start = np.datetime64(start_utc.removesuffix("Z"), "ms")
    moments = start + np.round(time_s * 1000).astype("timedelta64[ms]")
    return [f"{text}Z" for text in np.datetime_as_string(moments, unit="ms").tolist()]


def _groups(keys: NDArray[Any]) -> Iterator[tuple[int, int]]:
    """Ranges of equal keys."""
    if not len(keys):
        return
    cuts = np.flatnonzero((np.diff(keys, axis=0) != 0).any(axis=1)) + 1
    edges = [0, *cuts.tolist(), len(keys)]
    yield from pairwise(edges)


def _numbers(table: Table, name: str, n: int) -> Floats:
    column = table.columns.get(name)
    return np.full(n, np.nan) if column is None else np.array(column, np.float64)


def _codes(column: Column) -> tuple[list[str], Ints]:
    texts = Texts.of(column)
    return [text or "" for text in texts.categories], texts.codes.astype(np.int64)
