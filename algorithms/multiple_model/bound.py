"""Posterior Cramer-Rao bound along the truth, for a filter that is told when the object manoeuvres.

The covariance recursion of one constant-acceleration filter with the true measurement covariances: sigma 0.05 m/s^2 a
step while the true acceleration keeps, 30 over intervals in which it jumps. The prior is that of the start. A fixed
trajectory may beat it: the bound is of the model, not of the one path, and in the first seconds the truth is one point
and not a draw from the prior.

References
----------
tichavsky1998; specification of the multiple-model paper, section 11 ("mode-known").
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from algorithms.multiple_model import states
from algorithms.multiple_model.filter_kernel import filter_groups
from algorithms.multiple_model.measurements import Plots, prepare
from algorithms.multiple_model.parameters import MotionParameters
from algorithms.multiple_model.states import Setup
from algorithms.recording import AntennaPlots
from algorithms.toolbox.filters.multiple_model import Bank, new_track, new_work
from algorithms.toolbox.filters.transition import chains_of
from algorithms.toolbox.frames.bicone import antenna_axes, bicone_from_position
from algorithms.toolbox.motion.models import CA
from algorithms.toolbox.sensors.position_rows import CONVERTED, new_rows

Floats = NDArray[np.float64]

QUIET_MPS2 = 0.05
NOISY_MPS2 = 30.0
JUMP_MPS2 = 3.0
TURN_MPS3 = 10.0
"""So fast an acceleration that is commanded across the velocity turns with it."""
BASE_S = 0.05


def jump_bound(recording: Plots, parameters: MotionParameters) -> Floats | None:
    """(M, 9): variances of the bound at each row, NaN where it is unknown; None where there is no complete truth."""
    if not isinstance(recording, AntennaPlots) or len(recording) < 3 or len(recording.targets) != 1:
        return None
    if not np.isfinite(recording.truth_velocity_mps).all():
        return None
    prepared = prepare(recording, parameters)
    antenna = np.concatenate([prepared.axes[0].ravel(), prepared.origin[0]])
    sd = prepared.sd[0]
    key = (
        recording.time_s.tobytes(), recording.truth_m.tobytes(), recording.truth_velocity_mps.tobytes(), sd.tobytes(),
        antenna.tobytes(), parameters.start_velocity_sd_mps, parameters.start_acceleration_sd_mps2,
        parameters.track_timeout_s,
    )  # fmt: skip
    return _bound(*key)


@lru_cache(maxsize=8)
def _bound(
    time: bytes, truth: bytes, velocity: bytes, sd: bytes, antenna: bytes, sv: float, sa: float, timeout: float
) -> Floats:
    t, p, v = (np.frombuffer(a) for a in (time, truth, velocity))
    p, v = p.reshape(-1, 3), v.reshape(-1, 3)
    frame = np.frombuffer(antenna)
    recording = _exact(t, p, v, frame, np.frombuffer(sd))
    prepared = prepare(recording, MotionParameters())
    jump = _jumps(t, v)
    bank = Bank(np.array([CA]), np.array([QUIET_MPS2]), 1, 0, 0, 0, 5.0, chains_of([np.ones((1, 1))], BASE_S))
    setup = Setup(
        CONVERTED, sv**2, sa**2, timeout, np.inf, np.inf, 1.0, np.inf, 0.0, np.inf, 0.0, 1.0, np.empty((0, 2)),
        np.zeros(1, np.int64), np.empty((0, 2)),
    )  # fmt: skip
    noise = np.where(jump, NOISY_MPS2 / QUIET_MPS2, 1.0)[:, None]
    marks = prepared.marks(recording, np.arange(t.size), slice(0, 1), np.arange(t.size + 1), noise)
    report = states.new_report(t.size, 1, 1)
    track, work, lanes, rows, now = new_track(1), new_work(1, 1), states.new_lanes(), new_rows(), states.new_now(1)
    filter_groups(marks, setup, bank, track, lanes, work, rows, now, report, 0, t.size)
    diagonal = [i * (i + 1) // 2 + i for i in range(9)]
    return report.covariance[:, diagonal, 0]


def _jumps(t: Floats, v: Floats) -> NDArray[np.bool_]:
    """(M,): whether the acceleration changes inside the interval that ends at a row.

    Where it does, the interval's mean acceleration differs from those of both its neighbours; an interval beside it
    differs from one.
    """
    out = np.zeros(t.size, bool)
    step = np.diff(t)
    if t.size < 4 or (step <= 0).any():
        return out
    away = np.linalg.norm(np.diff(np.diff(v, axis=0) / step[:, None], axis=0), axis=1)
    out[2:-1] = np.minimum(away[:-1], away[1:]) > JUMP_MPS2 + TURN_MPS3 * step[1:-1]
    return out


def _exact(time: Floats, truth: Floats, velocity: Floats, frame: Floats, sd: Floats) -> AntennaPlots:
    """The recording that an errorless antenna would have made."""
    from algorithms.site import Site

    axes, centre = frame[:9].reshape(3, 3), frame[9:]
    azimuth = float(np.degrees(np.arctan2(axes[0, 0], axes[0, 1])))
    elevation = float(np.degrees(np.arcsin(axes[0, 2])))
    antenna = {
        "name": "antenna", "east_m": centre[0], "north_m": centre[1], "up_m": centre[2], "azimuth_deg": azimuth,
        "elevation_deg": elevation, "sigma_range_m": sd[0], "sigma_bicone_elevation_deg": float(np.degrees(sd[1])),
        "sigma_bicone_azimuth_deg": float(np.degrees(sd[2])),
    }  # fmt: skip
    seen = bicone_from_position(truth, antenna_axes(np.radians(azimuth), np.radians(elevation)), centre)
    return AntennaPlots(
        time_s=time, row=np.arange(1, time.size + 1), target=np.zeros(time.size, np.int64), truth_m=truth,
        truth_velocity_mps=velocity, site=Site.model_validate({"radars": [antenna]}), range_m=seen[0][:, None],
        bicone_elevation_rad=seen[1][:, None], bicone_azimuth_rad=seen[2][:, None],
    )  # fmt: skip


def horizontal_bound(recording: Plots, parameters: MotionParameters) -> Floats | None:
    """(M,) m, bound of the rms horizontal error."""
    variances = jump_bound(recording, parameters)
    return None if variances is None else np.sqrt(variances[:, 0] + variances[:, 3])
