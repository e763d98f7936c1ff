"""The Cramer-Rao bound of a position fused from the plots of two radars, over what a run varies."""

from __future__ import annotations

import numpy as np

from algorithms.recording import PolarPlots
from backend.charts.columns import Floats
from backend.charts.view import RunView

# What the bound can be followed over.
SWEPT = ("base_m", "base_azimuth_deg", "sigma_range_m", "sigma_azimuth_deg", "target_range_m", "target_azimuth_deg")


def fused_bound(sites: Floats, target: Floats, sigma_range: Floats, sigma_angle: Floats) -> Floats:
    """(2,) standard deviations (m) along the minor and the major axis, of radars (K, 2) that see a target (2,)."""
    information = np.zeros((2, 2))
    for site, sr, sb in zip(sites, sigma_range, sigma_angle, strict=True):
        offset = target - site
        distance = float(np.hypot(*offset))
        along = offset / distance
        across = np.array([-along[1], along[0]])
        information += np.outer(along, along) / sr**2 + np.outer(across, across) / (distance * sb) ** 2
    axes: Floats = 1 / np.sqrt(np.linalg.eigvalsh(information)[::-1])
    return axes


def bound_over(view: RunView, name: str, values: Floats) -> Floats | None:
    """Rms error (m) of the bound of the first target at each value of a swept name; None where it is not known."""
    short = name.rpartition(".")[2]
    recording = view.recording
    if short not in SWEPT or not isinstance(recording, PolarPlots) or recording.site is None or not len(recording):
        return None
    radars = recording.site.radars
    if len(radars) != 2 or not np.isfinite(recording.truth_m[0, :2]).all():
        return None
    if any(r.sigma_range_m is None or r.sigma_azimuth_deg is None for r in radars):
        return None
    sites = np.asarray(recording.site.radar_positions())[:, :2]
    base = sites[1] - sites[0]
    offset = recording.truth_m[0, :2] - sites[0]
    known = {
        "base_m": float(np.hypot(*base)),
        "base_azimuth_deg": float(np.degrees(np.arctan2(*base))),
        "target_range_m": float(np.hypot(*offset)),
        "target_azimuth_deg": float(np.degrees(np.arctan2(*offset))),
    }
    ranges = np.array([r.sigma_range_m for r in radars], float)
    angles = np.radians(np.array([r.sigma_azimuth_deg for r in radars], float))
    out = np.empty(values.size)
    for i, value in enumerate(values.tolist()):
        now = known | {short: value}
        second = _polar(now["base_m"], now["base_azimuth_deg"])
        target = _polar(now["target_range_m"], now["target_azimuth_deg"])
        sr = np.full(2, value) if short == "sigma_range_m" else ranges
        sb = np.full(2, np.radians(value)) if short == "sigma_azimuth_deg" else angles
        out[i] = float(np.hypot(*fused_bound(np.stack([np.zeros(2), second]), target, sr, sb)))
    return out


def _polar(distance: float, azimuth_deg: float) -> Floats:
    a = np.radians(azimuth_deg)
    place: Floats = distance * np.array([np.sin(a), np.cos(a)])
    return place
