"""What several files bring along with their rows becomes one: sites, true paths, marks of antennas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from algorithms.recording import Ints
from algorithms.site import Radar, Site
from backend.files.truth_file import TruthPoints
from backend.files.turns import TurnMarks


def joined_sites(sites: Sequence[Site | None]) -> Site | None:
    """Radars of all sites, a radar that is told twice where it was first; None unless every file tells its own."""
    known = [s for s in sites if s is not None]
    if not known or len(known) < len(sites) or any(s.origin != known[0].origin for s in known):
        return None
    radars: dict[str, Radar] = {}
    for site in known:
        for radar in site.radars:
            radars.setdefault(radar.name, radar)
    return known[0].model_copy(update={"radars": tuple(radars.values())})


def joined_truth(truths: Sequence[TruthPoints | None], epoch_s: int | None) -> TruthPoints | None:
    """Points of all files, their times counted from `epoch_s`."""
    known = [t for t in truths if t is not None]
    if not known:
        return None
    moved = [
        replace(t, epoch_s=epoch_s, time_s=t.time_s + t.epoch_s - epoch_s)
        if t.epoch_s is not None and epoch_s is not None
        else t
        for t in known
    ]
    if len(moved) == 1:
        return moved[0]
    targets, target = _joined_codes([(t.targets, t.target) for t in moved])
    geodetic = [
        t.truth_geodetic if t.truth_geodetic is not None else np.full((len(t.time_s), 3), np.nan) for t in moved
    ]
    return TruthPoints(
        row=np.concatenate([t.row for t in moved]),
        time_s=np.concatenate([t.time_s for t in moved]),
        epoch_s=moved[0].epoch_s,
        target=target,
        targets=targets,
        names_targets=all(t.names_targets for t in moved),
        truth_m=np.concatenate([t.truth_m for t in moved]),
        truth_velocity_mps=np.concatenate([t.truth_velocity_mps for t in moved]),
        truth_geodetic=np.concatenate(geodetic),
    )


def joined_marks(marks: Sequence[tuple[TurnMarks | None, float]]) -> TurnMarks | None:
    """Marks of all files, each moved by the seconds that its plots were moved by."""
    known = [replace(m, time_s=m.time_s + shift_s) for m, shift_s in marks if m is not None]
    if len(known) < 2:
        return known[0] if known else None
    radars, radar = _joined_codes([(m.radars, m.radar) for m in known])
    return TurnMarks(
        radars=radars,
        radar=radar,
        time_s=np.concatenate([m.time_s for m in known]),
        azimuth_rad=np.concatenate([m.azimuth_rad for m in known]),
        period_s={name: period for m in known for name, period in m.period_s.items()},
    )


def _joined_codes(parts: Sequence[tuple[tuple[str, ...], Ints]]) -> tuple[tuple[str, ...], Ints]:
    book = list(dict.fromkeys(name for names, _ in parts for name in names))
    place = {name: i for i, name in enumerate(book)}
    codes = [np.array([place[n] for n in names], np.int64)[code] for names, code in parts if len(code)]
    return tuple(book), np.concatenate([np.empty(0, np.int64), *codes])
