"""True positions: WGS-84 ones brought into the local frame, and those of a truth file matched to the measurements.

A measurement whose very time (within a microsecond) and target a truth file has gets that position unchanged; at
another time it gets the path between the neighbouring positions (`truth_tracks`), or none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pymap3d

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints, Kind, PolarPlots, Recording, TruthTracks
from algorithms.site import Origin
from backend.files.columns import Mask, read_timed_columns
from backend.files.containers import open_rows
from backend.files.content import NamedFile, inspect
from backend.files.options import ColumnSource, ReadLimits, ReadOptions, columns_of
from backend.files.packing import with_members
from backend.files.report import Findings, some
from backend.files.selection import NameColumn, Selection
from backend.files.truth_columns import TRUTH_QUANTITIES, truth_layout
from backend.files.truth_shift import Paths, estimate_time_shift
from backend.files.truth_tracks import TruthTrack

_TARGET = NameColumn("target", unnamed=True)


@dataclass(frozen=True)
class TruthPoints:
    """Rows of a truth file."""

    row: Ints
    time_s: Floats
    epoch_s: int | None
    target: Ints
    targets: tuple[str, ...]
    names_targets: bool
    truth_m: Floats
    truth_velocity_mps: Floats
    truth_geodetic: Floats | None


def to_local(geodetic: Floats, origin: Origin) -> Floats:
    """(M, 3) latitude and longitude in rad, height in m -> east, north, up in m."""
    enu = pymap3d.geodetic2enu(
        *geodetic.T, np.radians(origin.latitude_deg), np.radians(origin.longitude_deg), origin.height_m, deg=False
    )
    return np.stack(enu, axis=1)


def in_local_frame(local: Floats, geodetic: Floats | None, origin: Origin | None, findings: Findings) -> Floats:
    """Positions in the local frame; WGS-84 ones without an origin stay unknown, with a warning."""
    if geodetic is None:
        return local
    given = np.isfinite(geodetic).all(axis=1)
    if not given.any():
        return local
    if origin is None:
        findings.warn(
            "truth_without_origin",
            "The truth is in WGS-84, and neither the site nor the options give an origin; read the recording again "
            "with one of them to use it.",
            int(given.sum()),
        )
        return local
    out = local.copy()
    out[given] = to_local(geodetic[given], origin)
    return out


def _plain(names: Sequence[str], mapping: Mapping[str, ColumnSource]) -> dict[str, ColumnSource]:
    """In a file of truth alone `east_m` is `true_east_m`: names without `true_`, where none has it or is mapped."""
    known = [q.name for q in TRUTH_QUANTITIES]
    if any(name in names or name in mapping for name in known):
        return {}
    plain = {name: name.removeprefix("true_") for name in known}
    return {name: ColumnSource(column=column) for name, column in plain.items() if column in names}


def read_truth_file(
    file: NamedFile, options: ReadOptions, limits: ReadLimits, kind: Kind, findings: Findings
) -> TruthPoints:
    """Read a truth file; rows that cannot serve are counted in a warning.

    Raises InputError with a pointer at `/truth` where nothing of it can serve.
    """
    own = Findings(file.label)
    members = with_members([file], limits, pointer="/truth")
    if len(members) > 1:
        raise InputError(
            f"{file.label} holds {len(members)} files.",
            pointer="/truth",
            remedy="Give the truth as one file.",
            code="archive_members",
        )
    content = inspect(members[0], limits, own, pointer="/truth")
    rows = open_rows(content, limits, pointer="/truth", wanted=columns_of(options.truth_mapping, options.where))
    where = {n: v for n, v in options.where.items() if n in rows.names}
    mapping = _plain(rows.names, options.truth_mapping) | options.truth_mapping
    selection = Selection(rows, mapping, where, "/options/truth_mapping")
    known = ("time_s", "target", *(q.name for q in TRUTH_QUANTITIES))
    selection.check_mapping(known, "truth")
    names = selection.names
    truth = truth_layout(names, kind, own, pointer="/truth")
    lacking = [n for n, there in (("time_s", "time_s" in names), ("true_east_m", bool(truth.form))) if not there]
    if lacking:
        raise InputError(
            f"The truth file lacks the column {some(lacking)}; it has {some(names)}.",
            pointer="/truth",
            remedy="Rename a column, or map one by truth_mapping.",
            code="missing_column",
        )
    has_target = "target" in names
    timed = read_timed_columns(selection, truth.quantities, (_TARGET,) if has_target else (), own, limits.max_rows)
    enu, velocity, geodetic = truth.read(timed.columns, own)
    if own.rejections:
        findings.warn(
            "truth_rows_unusable",
            f"Rows of the truth file that cannot be read: {some(f'row {r.row}, {r.detail}' for r in own.rejections)}.",
            len(own.rejections),
        )
    findings.warnings += [w for w in own.warnings if w.code != "rows_filtered"]
    if not len(timed.columns):
        raise InputError(
            "The truth file has no usable row.",
            pointer="/truth",
            remedy="Give time_s and the true_ columns in each row.",
            code="no_usable_rows",
        )
    return TruthPoints(
        timed.columns.row,
        timed.time_s,
        timed.epoch_s,
        timed.columns.code("target", 0),
        timed.columns.names.get("target") or ("",),
        has_target,
        enu,
        velocity,
        geodetic,
    )


def attach_truth(
    recording: Recording,
    epoch_s: int | None,
    points: TruthPoints,
    origin: Origin | None,
    shift_s: float,
    findings: Findings,
) -> Recording:
    """Give each row the truth of its time and target; count what finds no partner on either side.

    The paths themselves become the recording's `truth_tracks`.

    `shift_s` is added to the times of the truth. A shift that the data themselves suggest is only reported.
    """
    if (epoch_s is None) != (points.epoch_s is None):
        raise InputError(
            "One of recording and truth has times of the epoch, the other times from an unknown start.",
            pointer="/truth",
            remedy="Give both the same times.",
            code="mixed_time_bases",
        )
    local = in_local_frame(points.truth_m, points.truth_geodetic, origin, findings)
    base_s = 0 if epoch_s is None or points.epoch_s is None else points.epoch_s - epoch_s
    time_s = points.time_s + base_s + shift_s
    if shift_s:
        findings.warn(
            "truth_shifted", f"{shift_s:+.6g} s were added to the times of the truth, as the options say.", len(time_s)
        )
    whole = TruthTracks.of(time_s, points.target, local, points.truth_velocity_mps, points.targets)
    recording = replace(recording, truth_tracks=whole)
    named = _identified(recording, points)
    partner = _target_partners(named, points, findings)
    chosen = np.unique(points.target).tolist() if partner is None else list(partner.values())
    tracks = [_track(points, time_s, local, target) for target in chosen]
    if partner is None:
        _report_shift(recording, Paths(tracks, None), shift_s, findings)
        return recording
    track_of = np.full(len(recording), -1, np.int64)
    for i, target in enumerate(partner):
        track_of[named.target == target] = i
    paths = Paths(tracks, track_of)
    found = paths.at(np.arange(len(recording)), recording.time_s)
    known = np.asarray(np.isfinite(found.position_m).all(axis=1))
    truth = np.where(known[:, None], found.position_m, recording.truth_m)
    velocity = np.where(known[:, None], found.velocity_mps, recording.truth_velocity_mps)
    with_truth = np.asarray(np.isfinite(truth).all(axis=1))
    _report_rows(recording, paths, known, found.exact, with_truth, findings)
    used = np.zeros(len(points.row), bool)
    used[found.between[known].ravel()] = True
    if not used.all():
        findings.warn(
            "truth_unmatched",
            f"Rows of the truth file that serve no measurement, at their time or beside it, rows "
            f"{some(points.row[~used])}.",
            int((~used).sum()),
        )
    _report_shift(recording, paths, shift_s, findings)
    return replace(recording, truth_m=truth, truth_velocity_mps=velocity)


def _track(points: TruthPoints, time_s: Floats, local_m: Floats, target: int) -> TruthTrack:
    mine = np.flatnonzero(points.target == target)
    return TruthTrack.of(time_s[mine], local_m[mine], points.truth_velocity_mps[mine], mine)


def _report_rows(
    recording: Recording, paths: Paths, known: Mask, exact: Mask, with_truth: Mask, findings: Findings
) -> None:
    between = known & ~exact
    if between.any():
        periods = [t.period_s for t in paths.tracks if np.isfinite(t.period_s)]
        findings.warn(
            "truth_interpolated",
            f"Rows whose truth was interpolated (cubic) between rows of the truth file, which are "
            f"{float(np.median(periods)):.6g} s apart at the median.",
            int(between.sum()),
        )
    if with_truth.all():
        return
    assert paths.track_of is not None
    first = np.array([t.time_s[0] if len(t.time_s) else np.inf for t in paths.tracks] + [-np.inf])
    last = np.array([t.time_s[-1] if len(t.time_s) else -np.inf for t in paths.tracks] + [np.inf])
    outside = (recording.time_s < first[paths.track_of]) | (recording.time_s > last[paths.track_of])
    nobody = paths.track_of < 0
    counts = {
        "of a target that the truth file does not have": nobody,
        "before the first or after the last truth of their target": outside,
        "in a gap of more than two periods": ~nobody & ~outside,
    }
    parts = [f"{int((m & ~with_truth).sum())} {words}" for words, m in counts.items() if (m & ~with_truth).any()]
    findings.warn("rows_without_truth", f"Rows without truth: {', '.join(parts)}.", int((~with_truth).sum()))


def _report_shift(recording: Recording, paths: Paths, applied_s: float, findings: Findings) -> None:
    shift = estimate_time_shift(recording, paths)
    if shift is None or not shift.is_significant:
        return
    total_s = applied_s + shift.shift_s
    digits = int(np.clip(2 - np.floor(np.log10(shift.standard_error_s)), 0, 9))
    findings.warn(
        "truth_time_shift",
        f"The truth fits the measurements best with {shift.shift_s:+.{digits}f} s added to its times (standard error "
        f"{shift.standard_error_s:.2g} s). This was not done; the option truth_shift_s = {total_s:.{digits}f} does it.",
        shift.rows,
    )


def _identified(recording: Recording, points: TruthPoints) -> Recording:
    """Return the recording with targets by address where it names none and the truth knows addresses."""
    if not isinstance(recording, PolarPlots) or set(recording.targets) != {""}:
        return recording
    if not set(recording.addresses) & set(points.targets):
        return recording
    return replace(recording, target=recording.address, targets=recording.addresses)


def _target_partners(recording: Recording, points: TruthPoints, findings: Findings) -> Mapping[int, int] | None:
    """Target of the recording -> target of the truth; None where nothing tells them apart."""
    # A plot without an address has no target.
    present = np.unique(recording.target[recording.target >= 0]).tolist()
    names = {i: recording.targets[i] for i in present}
    point_targets = np.unique(points.target).tolist()
    if list(names.values()) == [""]:
        if len(point_targets) == 1:
            return {present[0]: point_targets[0]}
        findings.warn(
            "truth_not_assigned",
            f"The truth describes {len(point_targets)} targets, and the measurements name none: a measurement "
            "cannot be told its true position. The paths are kept as they are.",
            len(points.row),
        )
        return None
    if not points.names_targets:
        if len(present) == 1:
            return {present[0]: point_targets[0]}
        raise InputError(
            f"The recording has {len(present)} targets, and the truth file has no column target.",
            pointer="/truth",
            remedy="Add the column, with the names of the recording.",
            code="missing_column",
        )
    return {i: points.targets.index(n) for i, n in names.items() if n in points.targets}
