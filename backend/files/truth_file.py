"""True positions: WGS-84 ones brought into the local frame, and those of a truth file matched to the measurements.

A truth file serves where it has the very time of a measurement (within a microsecond, which is what the text of an
epoch time resolves) and, where it names targets, the very target.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import pymap3d

from algorithms.errors import InputError
from algorithms.recording import Floats, Ints, Kind, Recording
from algorithms.site import Origin
from backend.files.columns import read_timed_columns
from backend.files.content import NamedFile, inspect
from backend.files.delimited_text import read_header
from backend.files.options import ReadLimits, ReadOptions
from backend.files.report import Findings, some
from backend.files.selection import NameColumn, Selection
from backend.files.truth_columns import TRUTH_QUANTITIES, truth_layout

_SAME_TIME_S = 1e-6
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


def read_truth_file(
    file: NamedFile, options: ReadOptions, limits: ReadLimits, kind: Kind, findings: Findings
) -> TruthPoints:
    """Read a truth file; rows that cannot serve are counted in a warning.

    Raises InputError with a pointer at `/truth` where nothing of it can serve.
    """
    own = Findings(file.label)
    content = inspect(file, limits, own, pointer="/truth")
    header = read_header(content, pointer="/truth")
    where = {n: v for n, v in options.where.items() if n in header.names}
    selection = Selection(header, options.truth_mapping, where, "/options/truth_mapping")
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
    timed = read_timed_columns(
        content, selection, truth.quantities, (_TARGET,) if has_target else (), own, limits.max_rows
    )
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
    recording: Recording, epoch_s: int | None, points: TruthPoints, origin: Origin | None, findings: Findings
) -> Recording:
    """Give each row the truth of its time and target; count what finds no partner on either side."""
    if (epoch_s is None) != (points.epoch_s is None):
        raise InputError(
            "One of recording and truth has times of the epoch, the other times from an unknown start.",
            pointer="/truth",
            remedy="Give both the same times.",
            code="mixed_time_bases",
        )
    local = in_local_frame(points.truth_m, points.truth_geodetic, origin, findings)
    shift = 0 if epoch_s is None or points.epoch_s is None else points.epoch_s - epoch_s
    partner = _target_partners(recording, points, findings)
    if partner is None:
        return recording
    truth, velocity = recording.truth_m.copy(), recording.truth_velocity_mps.copy()
    used = np.zeros(len(points.row), bool)
    for target, point_target in partner.items():
        rows = recording.rows_of(target)
        candidates = np.flatnonzero(points.target == point_target)
        found = _same_time(recording.time_s[rows], points.time_s[candidates] + shift)
        rows, chosen = rows[found >= 0], candidates[found[found >= 0]]
        truth[rows], velocity[rows] = local[chosen], points.truth_velocity_mps[chosen]
        used[chosen] = True
    without = int((~np.isfinite(truth).all(axis=1)).sum())
    if without:
        findings.warn("rows_without_truth", "Rows for whose time and target the truth file has no position.", without)
    if not used.all():
        findings.warn(
            "truth_unmatched",
            f"Rows of the truth file whose time and target no measurement has, rows {some(points.row[~used])}.",
            int((~used).sum()),
        )
    return replace(recording, truth_m=truth, truth_velocity_mps=velocity)


def _target_partners(recording: Recording, points: TruthPoints, findings: Findings) -> Mapping[int, int] | None:
    """Target of the recording -> target of the truth; None where nothing tells them apart."""
    present = np.unique(recording.target).tolist()
    names = {i: recording.targets[i] for i in present}
    point_targets = np.unique(points.target).tolist()
    if list(names.values()) == [""]:
        if len(point_targets) == 1:
            return {present[0]: point_targets[0]}
        findings.warn(
            "truth_not_assigned",
            f"The truth describes {len(point_targets)} targets, and the measurements name none: a measurement "
            "cannot be told its true position.",
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


def _same_time(wanted_s: Floats, given_s: Floats) -> Ints:
    """Position in `given_s` of the same time, or -1."""
    if not given_s.size:
        return np.full(len(wanted_s), -1, np.int64)
    order = np.argsort(given_s, kind="stable")
    sorted_s = given_s[order]
    after = np.clip(np.searchsorted(sorted_s, wanted_s), 0, len(sorted_s) - 1)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(sorted_s[before] - wanted_s) <= np.abs(sorted_s[after] - wanted_s), before, after)
    fits = np.abs(sorted_s[nearest] - wanted_s) <= _SAME_TIME_S
    return np.where(fits, order[nearest], -1)
