"""One row for each pass: when it was, its last answer with standard deviations, and what is doubtful about it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import FrameError, RecordingError
from algorithms.forward_scatter import outputs
from algorithms.forward_scatter.conditions import site_of
from algorithms.forward_scatter.doubts import PassAnswer, doubts_of
from algorithms.forward_scatter.passes import signs
from algorithms.recording import DopplerPairs
from algorithms.result import Result, Table
from algorithms.toolbox.frames.forward_scatter import scatter_frame

Floats = NDArray[np.float64]

_NAMES = (
    "track", "target", "state", "start_s", "end_s", "distance_m", "sigma_distance_m", "distance_low_m",
    "distance_high_m", "crossing_s", "sigma_crossing_s", "across_mps", "sigma_across_mps", "along_mps", "course_deg",
    "doubts", "used_share", "updates", "misses", "reason",
)  # fmt: skip
_TEXTS = {"target", "state", "reason", "doubts"}


def track_table(recording: DopplerPairs, result: Result) -> Table:
    """Return the table `tracks`; doubts are codes with a space between, as the notes have them."""
    track = result.arrays["track"]
    base_m = _base_m(recording)
    rows: list[tuple[Any, ...]] = []
    for trial in range(track.shape[1]):
        number = track[:, trial]
        rows += [
            _row(recording, result, np.flatnonzero(number == one), trial, base_m)
            for one in np.unique(number[number > 0])
        ]
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(_NAMES)
    return Table({n: list(c) if n in _TEXTS else np.array(c, float) for n, c in zip(_NAMES, columns, strict=True)})


def _row(recording: DopplerPairs, result: Result, where: Any, trial: int, base_m: float) -> tuple[Any, ...]:
    a = result.arrays
    answered = np.isin(a["status"][where, trial], outputs.ANSWERED)
    last = where[np.flatnonzero(answered)[-1]] if answered.any() else None
    theta, variance = np.full(5, np.nan), np.full(5, np.nan)
    if last is not None:
        theta = np.asarray(a["theta"][last, :, trial], float)
        variance = np.diagonal(a["theta_covariance"][last, :, :, trial])
    tau, s, across, along, _ = theta.tolist()
    ends = [np.nan, np.nan] if last is None else np.asarray(a["distance_interval_m"][last, :, trial], float).tolist()
    with np.errstate(invalid="ignore"):
        sd_tau, sd_s, sd_across = np.sqrt(variance[:3]).tolist()
    doppler = signed_dopplers(recording, where, trial, unsigned=is_unsigned(result))
    # Columns that a method does not look at have no residuals, and are no Dopplers that it left out.
    looked_at = np.isfinite(a["residual_hz"][where, :, trial]).any(axis=0)
    measured = np.where(looked_at, doppler, np.nan)
    one = PassAnswer(
        time=recording.time_s[where],
        doppler=measured if looked_at.any() else doppler,
        answered=answered,
        theta=np.asarray(a["theta"], float)[where, :, trial],
        chi2=np.asarray(a["chi2"], float)[where, trial],
        dof=np.asarray(a["dof"], np.int64)[where, trial],
        used=np.asarray(a["used"], np.bool_)[where, :, trial],
        residual=np.asarray(a["residual_hz"], float)[where, :, trial] / _sigma_hz(result),
        a=base_m,
    )
    there = np.isfinite(measured)
    share = float((one.used & there).sum() / there.sum()) if there.any() else np.nan
    later = where[-1] + 1 < len(a["track"])
    return (
        int(a["track"][where[0], trial]),
        recording.targets[recording.target[where[0]]] or None,
        "ended" if later else "open",
        recording.time_s[where[0]],
        recording.time_s[where[-1]],
        s,
        sd_s,
        *ends,
        tau,
        sd_tau,
        across,
        sd_across,
        along,
        float(np.degrees(np.arctan2(across, along))),
        " ".join(doubts_of(one)) or None,
        share,
        int(answered.sum()),
        int((~answered).sum()),
        "next pass or silence" if later else "end of the recording",
    )


def is_unsigned(result: Result) -> bool:
    """Whether the method was told that the Dopplers are magnitudes."""
    return "unsigned" in result.settings and bool(result.settings["unsigned"].value)


def signed_dopplers(recording: DopplerPairs, where: NDArray[np.int64], trial: int, *, unsigned: bool) -> Floats:
    """(K, C) Hz: Dopplers of the rows of a pass as the methods see them."""
    doppler = np.ascontiguousarray(recording.doppler_hz[where][:, :, [trial]])
    if unsigned:
        signs(doppler, np.ascontiguousarray(recording.time_s[where]), 0, where.size)
    return doppler[:, :, 0]


def _sigma_hz(result: Result) -> float:
    """Error of one Doppler as the method took it; NaN where it does not tell."""
    return float(result.settings["sigma_doppler_hz"].value) if "sigma_doppler_hz" in result.settings else float("nan")


def _base_m(recording: DopplerPairs) -> float:
    """Length of the base line, m; NaN where the site has none, and then nothing lies far from it."""
    try:
        site = site_of(recording)
        places = site.terminal_positions()
        count = len(site.transmitters)
        frame = scatter_frame(places[:count], places[count:])
    except (RecordingError, FrameError):
        return float("nan")
    return float(frame.from_enu(places[:count])[:, 0].mean())
