"""The columns that hold true positions, in a file of measurements or in a truth file of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from algorithms.errors import InputError
from algorithms.recording import Floats, Kind
from backend.files.columns import Columns
from backend.files.report import Findings, some
from backend.files.selection import Quantity

_ENU = ("true_east_m", "true_north_m", "true_up_m")
_GEODETIC = ("true_latitude_deg", "true_longitude_deg", "true_height_m")
_VELOCITY = ("true_velocity_east_mps", "true_velocity_north_mps", "true_velocity_up_mps")
# What is measured in the plane says nothing of the height, and its truth often does not either.
_FLAT_KINDS: tuple[Kind, ...] = ("polar_plots", "doppler_pairs")

TRUTH_QUANTITIES = (
    *(Quantity(n) for n in _ENU),
    Quantity("true_latitude_deg", -90, 90),
    Quantity("true_longitude_deg", -180, 360),
    Quantity("true_height_m"),
    *(Quantity(n, -1e6, 1e6) for n in _VELOCITY),
)


@dataclass(frozen=True)
class TruthColumns:
    """Which truth columns a file has. `form` is empty, `enu` or `geodetic`."""

    form: str
    quantities: tuple[Quantity, ...]

    def read(self, columns: Columns, findings: Findings) -> tuple[Floats, Floats, Floats | None]:
        """Positions in the local frame, velocities, and positions that still need an origin; each (M, 3)."""
        unknown = np.full((len(columns), 3), np.nan)
        if not self.form:
            return unknown, unknown.copy(), None
        names = _ENU if self.form == "enu" else _GEODETIC
        position = np.stack([columns.number(n) for n in names], axis=1)
        if names[2] not in columns.numbers:
            position[:, 2] = 0.0
        complete = np.isfinite(position).all(axis=1)
        # A height alone claims no position: it stands in every row of some recorders.
        partial = np.isfinite(position[:, :2]).any(axis=1) & ~complete
        if partial.any():
            findings.warn(
                "truth_incomplete",
                f"Rows whose truth lacks a coordinate count as rows without truth: {some(columns.row[partial])}.",
                int(partial.sum()),
            )
        position[~complete] = np.nan
        velocity = np.stack([columns.number(n) for n in _VELOCITY], axis=1)
        if self.form == "enu":
            return position, velocity, None
        return unknown, velocity, position


def truth_layout(names: Sequence[str], kind: Kind, findings: Findings, *, pointer: str = "/file") -> TruthColumns:
    """Find the truth columns among the native names.

    Raises InputError where a position is incomplete.
    """
    offered = set(names)
    enu, geodetic = offered & set(_ENU), offered & set(_GEODETIC)
    if enu and geodetic:
        raise InputError(
            f"The truth is given twice, in the local frame ({some(sorted(enu))}) and in WGS-84 "
            f"({some(sorted(geodetic))}).",
            pointer=pointer,
            remedy="Keep one of the two.",
            code="truth_twice",
        )
    if not (enu or geodetic):
        return TruthColumns("", ())
    wanted = _ENU if enu else _GEODETIC
    lacking = [n for n in wanted if n not in offered]
    if lacking == [wanted[2]] and kind in _FLAT_KINDS:
        findings.warn("truth_up_zero", f"The truth has no column {wanted[2]}; 0 was used.")
    elif lacking:
        raise InputError(
            f"The truth lacks the column {some(lacking)}.",
            pointer=pointer,
            remedy="Add it, or remove the other true_ columns.",
            code="missing_column",
        )
    fitting = tuple(q for q in TRUTH_QUANTITIES if q.name in offered and q.name in (*wanted, *_VELOCITY))
    return TruthColumns("enu" if enu else "geodetic", fitting)
