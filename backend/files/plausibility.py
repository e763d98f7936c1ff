"""Signs that a file means other units or another site than it says."""

from __future__ import annotations

import numpy as np

from algorithms.errors import InputError
from algorithms.recording import PolarPlots, Recording, ToaMarks
from algorithms.site import Site
from backend.files.report import Findings, some

_LIGHT_MPS = 299_792_458.0
_LONG_STEP_S = 50.0
_HIGH_M = 15_000.0
# Altitudes are sent in steps of 25 or 100 ft; in metres such a grid is an accident.
_FEET_STEP = 25.0
_ENOUGH = 5
_ENOUGH_AZIMUTHS = 50
# How near azimuths come to both ends of a turn of radians that is filled.
_NEAR_END = 0.3
_CHECKED_MARKS = 2_000
_ASSUMED_SIGMA_NS = 100.0


def look_at_times(recording: Recording, findings: Findings) -> None:
    """Warn where times look like milliseconds."""
    times = np.unique(recording.time_s)
    if len(times) < _ENOUGH:
        return
    step_s = float(np.median(np.diff(times)))
    if step_s > _LONG_STEP_S and (times == np.floor(times)).all():
        findings.warn(
            "time_unit_suspect",
            f"Half of the times are {step_s:.6g} s and more apart, and all are whole numbers. If they are "
            "milliseconds, read the recording again with the unit ms in the mapping of time_s.",
        )


def look_at_altitudes(recording: Recording, findings: Findings) -> None:
    """Warn where altitudes look like feet."""
    altitude = getattr(recording, "altitude_m", None)
    if altitude is None:
        return
    known = altitude[np.isfinite(altitude)]
    high = known > _HIGH_M
    if len(known) < _ENOUGH or high.sum() < 0.1 * len(known):
        return
    if (np.mod(known, _FEET_STEP) == 0).mean() > 0.95:
        findings.warn(
            "altitude_unit_suspect",
            f"Altitudes up to {known.max():.0f} m in steps of 25: if they are feet, read the recording again with "
            "the unit ft in the mapping of altitude_m.",
            int(high.sum()),
        )


def look_at_azimuths(recording: Recording, findings: Findings) -> None:
    """Warn where azimuths in degrees fill one turn of radians and nothing else.

    A sector of 6.28 degrees that begins at north, or lies evenly about it, and is filled to both ends is an accident.
    """
    if not isinstance(recording, PolarPlots):
        return
    known = (np.degrees(recording.azimuth_rad[np.isfinite(recording.azimuth_rad)]) + 180.0) % 360.0 - 180.0
    if len(known) < _ENOUGH_AZIMUTHS:
        return
    low, high = float(known.min()), float(known.max())
    turns = ((0.0, 2 * np.pi), (-np.pi, np.pi))
    if any(0 <= low - first < _NEAR_END and 0 <= last - high < _NEAR_END for first, last in turns):
        findings.warn(
            "azimuth_unit_suspect",
            f"All azimuths lie between {low:.2f} and {high:.2f} degrees: if they are radians, read the recording again "
            "with the unit rad in the mapping of azimuth_deg.",
            len(known),
        )


def check_time_differences(marks: ToaMarks, site: Site) -> None:
    """Refuse a recording most of whose marks no emitter could have made.

    Two stations cannot receive one pulse further apart in time than light needs from one to the other. Where more
    than half of the marks break this, the unit of the times or the site is wrong; fewer are left to the algorithms.

    Raises InputError `check_units`.
    """
    step = max(1, len(marks) // _CHECKED_MARKS)
    clock_s = np.array([s.clock_offset_ns for s in site.stations]) * 1e-9
    toa_s = marks.toa_s[::step, :, 0] - clock_s
    position = site.station_positions()
    sigma_ns = [s.sigma_toa_ns or site.sigma_toa_ns or _ASSUMED_SIGMA_NS for s in site.stations]
    slack_m = 5.0 * _LIGHT_MPS * max(sigma_ns) * 1e-9
    several = np.isfinite(toa_s).sum(axis=1) >= 2
    broken = np.zeros(len(toa_s), bool)
    worst_ratio, worst = 0.0, (0, 1)
    for i in range(1, len(position)):
        apart_m = np.linalg.norm(position[:i] - position[i], axis=1)
        with np.errstate(invalid="ignore"):
            path_m = _LIGHT_MPS * np.abs(toa_s[:, :i] - toa_s[:, i : i + 1])
            wrong = path_m > apart_m + slack_m
        broken |= wrong.any(axis=1)
        if wrong.any():
            ratio = np.where(wrong, path_m / np.maximum(apart_m, 1.0), 0.0)
            j = int(ratio.max(axis=0).argmax())
            if ratio[:, j].max() > worst_ratio:
                worst_ratio, worst = float(ratio[:, j].max()), (j, i)
    if several.any() and broken[several].mean() > 0.5:
        names = some(site.stations[k].name for k in worst)
        raise InputError(
            f"In {broken[several].mean():.0%} of the marks two stations received the pulse further apart in time "
            f"than light needs between them (worst: {names}, {worst_ratio:.3g} times).",
            pointer="/site/stations",
            remedy="Check that the times of arrival are in the unit that their column says (ns), and that the site "
            "belongs to this recording.",
            code="check_units",
        )
