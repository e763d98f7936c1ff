"""From a site and parameters to the numbers a kernel works with, and a record of where each came from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError, RecordingError
from algorithms.multilateration.parameters import (
    RESIDUAL_GATE_IN_SIGMA,
    SIGMA_ALTITUDE_M,
    SIGMA_TOA_NS,
    MarkParameters,
)
from algorithms.recording import ToaMarks
from algorithms.result import Note, Setting
from algorithms.site import Site
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS

Floats = NDArray[np.float64]

# |c (TOA_i - TOA_j)| may exceed the stations' distance by this many c sigma (specification 11).
SPREAD_SIGMA = 5.0


@dataclass(frozen=True)
class Conditions:
    """Stations, noise and Earth in metres; the settings used and notes about them."""

    stations: Floats
    variance: Floats
    spread_limit: Floats
    sigma_altitude_m: float
    residual_gate_m: float
    earth: Floats
    earth_centre: Floats
    earth_radius: float
    clock_offset_s: Floats
    settings: dict[str, Setting]
    notes: tuple[Note, ...]

    @property
    def middle(self) -> Floats:
        """(3,) m: centre of the stations."""
        middle: Floats = self.stations.mean(axis=0)
        return middle


def site_of(recording: ToaMarks) -> Site:
    """Return the recording's site, whose stations are the recording's columns, or say what is missing."""
    site = recording.site
    if site is None or not site.stations:
        raise RecordingError(
            "the recording has no site, so its stations have no positions",
            pointer="/site",
            remedy="read the recording again with a site (JSON, or a sensor table in CSV)",
            code="site_missing",
        )
    names = tuple(s.name for s in site.stations)
    if names != recording.stations:
        raise RecordingError(
            f"the site's stations {', '.join(names)} are not the recording's {', '.join(recording.stations)}",
            pointer="/site/stations",
            remedy="give the stations the names of the recording's columns",
            code="site_mismatch",
        )
    return site


def conditions_of(
    recording: ToaMarks, parameters: MarkParameters, *, profile: str = "robust", with_altitude: bool
) -> Conditions:
    """Resolve every default: the run's parameter wins, then the station's, the site's, the program's.

    Raises
    ------
    RecordingError
        No site, or one whose stations are not the recording's columns.
    ParameterError
        WGS-84 asked for without an origin.
    """
    site = site_of(recording)
    settings: dict[str, Setting] = {}
    notes: list[Note] = []
    positions = site.station_positions()

    given = parameters.sigma_toa_ns
    if given is not None:
        sigma_ns = np.full(len(positions), given)
        settings["sigma_toa_ns"] = Setting(given, "run")
    else:
        base = site.sigma_toa_ns or SIGMA_TOA_NS
        sigma_ns = np.array([s.sigma_toa_ns or base for s in site.stations])
        own = any(s.sigma_toa_ns for s in site.stations)
        settings["sigma_toa_ns"] = Setting(
            sigma_ns.tolist() if own else base, "site" if own or site.sigma_toa_ns else "default"
        )
    sigma_m = SPEED_OF_LIGHT_MPS * 1e-9 * sigma_ns

    sigma_altitude = SIGMA_ALTITUDE_M
    if with_altitude:
        own_altitude = getattr(parameters, "sigma_altitude_m", None)
        sigma_altitude = own_altitude or site.sigma_altitude_m or SIGMA_ALTITUDE_M
        source = "run" if own_altitude else "site" if site.sigma_altitude_m else "default"
        settings["sigma_altitude_m"] = Setting(sigma_altitude, source)

    gate = parameters.residual_gate_m
    settings["residual_gate_m"] = Setting(
        gate if gate is not None else round(RESIDUAL_GATE_IN_SIGMA * float(sigma_m.max()), 3),
        "run" if gate is not None else "default",
    )

    earth, source = _earth(site, parameters, profile, notes)
    settings["earth"] = Setting("sphere" if earth[0] == earths.SPHERE else "wgs84", source)

    if _in_line(positions, sigma_m):
        text = "the stations stand in one line: a place and its mirror image cannot be told apart"
        notes.append(Note("stations_in_line", text))
    distance = np.linalg.norm(positions[:, None] - positions[None], axis=-1)
    return Conditions(
        stations=positions,
        variance=sigma_m**2,
        spread_limit=distance + SPREAD_SIGMA * np.maximum(sigma_m[:, None], sigma_m[None]),
        sigma_altitude_m=float(sigma_altitude),
        residual_gate_m=float(settings["residual_gate_m"].value),
        earth=earth,
        earth_centre=np.array([0.0, 0.0, -earth[1]]),
        earth_radius=float(earth[1] - earth[2]),
        clock_offset_s=np.array([s.clock_offset_ns for s in site.stations]) * 1e-9,
        settings=settings,
        notes=tuple(notes),
    )


def _in_line(positions: Floats, sigma_m: Floats) -> bool:
    """Whether three stations or more leave their common line by no more than the timing sees."""
    if len(positions) < 3:
        return False
    across = np.linalg.svd(positions - positions.mean(axis=0), compute_uv=False)[1]
    return bool(across < SPREAD_SIGMA * sigma_m.max())


def _earth(site: Site, parameters: MarkParameters, profile: str, notes: list[Note]) -> tuple[Floats, str]:
    origin = site.frame_origin()
    height = origin.height_m if origin is not None else 0.0
    if profile == "article" and parameters.earth is None:
        return earths.sphere(earths.R_PAPER_M, height), "profile"
    if parameters.earth == "sphere":
        if profile == "article" or origin is None:
            return earths.sphere(earths.R_PAPER_M, height), "run"
        return earths.sphere(earths.local_radius_m(origin.latitude_deg), height), "run"
    if origin is not None:
        return earths.wgs84(origin), "run" if parameters.earth else "profile"
    if parameters.earth == "wgs84":
        raise ParameterError(
            "WGS-84 needs to know where on Earth the site is, and the site has no origin",
            pointer="/earth",
            remedy="give the site an origin (latitude, longitude, height), or choose the sphere",
            code="origin_missing",
        )
    notes.append(Note("sphere_used", "the site has no origin, so the altitude is taken above a sphere of 6 371 km"))
    return earths.sphere(earths.R_PAPER_M), "default"


def given_or_default(parameters: MarkParameters, name: str) -> Setting:
    """Return the setting of a parameter that needs no resolving: the run's where the run gave it."""
    return Setting(getattr(parameters, name), "run" if name in parameters.model_fields_set else "default")


def toa_of(recording: ToaMarks, conditions: Conditions) -> Floats:
    """(M, S, L) s: times of arrival less the stations' known clock offsets."""
    if not conditions.clock_offset_s.any():
        return recording.toa_s
    corrected: Floats = recording.toa_s - conditions.clock_offset_s[None, :, None]
    return corrected
