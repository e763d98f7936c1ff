"""True paths of several recordings become one set: a target's path is whole where its names are equal."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from algorithms.recording import TruthTracks
from algorithms.result import Note


def joined_tracks(tracks: Sequence[TruthTracks | None]) -> tuple[TruthTracks | None, tuple[Note, ...]]:
    """Join paths whose times and places are counted alike already.

    Where several recordings tell the path of one target, the first one's is taken, and that of the others only before
    its beginning and after its end: two descriptions of one path, a little apart, would make it jump to and fro.
    """
    known = [t for t in tracks if t is not None]
    if not known:
        return None, ()
    targets = tuple(dict.fromkeys(name for t in known for name in t.targets))
    span: dict[str, tuple[float, float]] = {}
    parts, left_out = [], 0
    for t in known:
        for k, name in enumerate(t.targets):
            mine = t.points_of(k)
            if not mine.size:
                continue
            time = t.time_s[mine]
            if name in span:
                first, last = span[name]
                outside = (time < first) | (time > last)
                left_out += int((~outside).sum())
                mine, time = mine[outside], time[outside]
                if not mine.size:
                    continue
                span[name] = (min(first, float(time[0])), max(last, float(time[-1])))
            else:
                span[name] = (float(time[0]), float(time[-1]))
            target = np.full(len(mine), targets.index(name), np.int64)
            parts.append((time, target, t.position_m[mine], t.velocity_mps[mine]))
    time, target, position, velocity = (np.concatenate(column) for column in zip(*parts, strict=True))
    text = "Points of true paths that another recording tells for the same target and time were left out."
    notes = (Note("truth_told_twice", text, left_out),) if left_out else ()
    return TruthTracks.of(time, target, position, velocity, targets), notes
