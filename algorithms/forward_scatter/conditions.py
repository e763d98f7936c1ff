"""From a site and parameters to the numbers the methods work with, and a record of where each came from.

Every likelihood takes the true places. The closed forms assume the transmitter on the perpendicular bisector of the
receivers: up to one degree beside it the base is taken as its projection and a note says so; beyond they refuse.

References
----------
specification 2, 4 (real sites), 7, 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import RecordingError
from algorithms.forward_scatter.parameters import SIGMA_DOPPLER_HZ, ScatterParameters
from algorithms.recording import DopplerPairs
from algorithms.result import Note, Setting
from algorithms.site import Site
from algorithms.spec import Parameters
from algorithms.toolbox.frames.forward_scatter import ScatterFrame, scatter_frame

Floats = NDArray[np.float64]

LARGEST_ASKEW_DEG = 1.0
TOLD_ASKEW_DEG = 0.01
LEAST_SPACING_M = 0.1


@dataclass(frozen=True)
class Conditions:
    """Places in the frame of the base line, and noise."""

    frame: ScatterFrame
    feet: Floats
    """(C, 2, 3) m: transmitter and receiver of each channel."""
    transmitters: Floats
    receivers: Floats
    a: float
    wavelength: float
    sigma: float
    altitude: float
    settings: dict[str, Setting]
    notes: tuple[Note, ...]


@dataclass(frozen=True)
class Pair:
    """Two Dopplers for the closed form: rows of weights over the channels, lower and upper, and their base.

    `mirrored`: the base is that of the transmitters, so the distance counts from them.
    """

    lower: tuple[int, ...]
    upper: tuple[int, ...]
    b: float
    mirrored: bool


def site_of(recording: DopplerPairs) -> Site:
    """Return the recording's site, whose terminals fit the channels, or say what is missing."""
    site = recording.site
    if site is None or not site.transmitters or not site.receivers:
        raise RecordingError(
            "the recording has no site, so transmitters and receivers have no positions",
            pointer="/site",
            remedy="read the recording again with a site that has transmitters, receivers and wavelength_m",
            code="site_missing",
        )
    count = len(site.transmitters), len(site.receivers)
    fits = {
        ("1",): [(1, 1)],
        ("1", "2"): [(1, 2), (2, 1)],
        ("11", "12", "21", "22"): [(2, 2)],
    }[recording.channels]
    if count not in fits:
        raise RecordingError(
            f"the Dopplers {', '.join(recording.channels)} do not fit a site with {count[0]} transmitters and "
            f"{count[1]} receivers",
            pointer="/site/receivers",
            remedy="give one transmitter and a receiver for each column, two transmitters and one receiver, or two and "
            "two with the columns doppler_11_hz to doppler_22_hz",
            code="site_mismatch",
        )
    return site


def conditions_of(recording: DopplerPairs, parameters: ScatterParameters) -> Conditions:
    """Resolve every default: the run's parameter wins, then the site's, then the program's.

    Raises
    ------
    RecordingError
        No site, one that does not fit the channels, or no wavelength.
    """
    site = site_of(recording)
    places = site.terminal_positions()
    count = len(site.transmitters)
    frame = scatter_frame(places[:count], places[count:])
    tx, rx = frame.from_enu(places[:count]), frame.from_enu(places[count:])
    settings: dict[str, Setting] = {}
    wavelength = parameters.wavelength_m or site.wavelength_m
    if wavelength is None:
        raise RecordingError(
            "the site has no wavelength",
            pointer="/site/wavelength_m",
            remedy="add wavelength_m to the site, or set it in the run",
            code="wavelength_missing",
        )
    settings["wavelength_m"] = Setting(wavelength, "run" if parameters.wavelength_m else "site")
    sigma = parameters.sigma_doppler_hz or site.sigma_doppler_hz or SIGMA_DOPPLER_HZ
    source = "run" if parameters.sigma_doppler_hz else "site" if site.sigma_doppler_hz else "default"
    settings["sigma_doppler_hz"] = Setting(sigma, source)
    return Conditions(
        frame=frame,
        feet=_feet(recording.channels, tx, rx),
        transmitters=tx,
        receivers=rx,
        a=float(tx[:, 0].mean()),
        wavelength=float(wavelength),
        sigma=float(sigma),
        altitude=float(parameters.altitude_m),
        settings=settings | others_of(parameters),
        notes=(),
    )


def others_of(parameters: Parameters) -> dict[str, Setting]:
    """Every other parameter, with whether the run gave it."""
    apart = {"wavelength_m", "sigma_doppler_hz"}
    given = parameters.model_fields_set
    return {
        name: Setting(value, "run" if name in given else "default")
        for name, value in parameters.model_dump(mode="json").items()
        if name not in apart and value is not None
    }


def _feet(channels: tuple[str, ...], tx: Floats, rx: Floats) -> Floats:
    if len(channels) == 4:
        pairs = [(int(c[0]) - 1, int(c[1]) - 1) for c in channels]
    elif len(tx) == 2:
        pairs = [(i, 0) for i in range(2)]
    else:
        pairs = [(0, i) for i in range(len(channels))]
    return np.array([[tx[i], rx[j]] for i, j in pairs])


def pairs_of(conditions: Conditions) -> tuple[list[Pair], tuple[Note, ...]]:
    """Return the pairs of Dopplers that a closed form can work on, and notes about a site that is not symmetrical.

    Raises
    ------
    RecordingError
        One Doppler only, terminals at one place, or a site askew by more than a degree.
    """
    c = conditions
    out: list[Pair] = []
    notes: list[Note] = []
    for terminals, foot, what in ((c.receivers, 1, "receivers"), (c.transmitters, 0, "transmitters")):
        if len(terminals) != 2:
            continue
        dx, dy, _ = np.abs(terminals[1] - terminals[0])
        if dy < LEAST_SPACING_M:
            raise RecordingError(
                f"the two {what} stand at the same place, seen from the base line",
                pointer=f"/site/{what}",
                remedy="give their true places",
                code="site_geometry",
            )
        askew = float(np.degrees(np.arctan2(dx, dy)))
        if askew > LARGEST_ASKEW_DEG:
            raise RecordingError(
                f"the base line is {askew:.2f} degrees beside the perpendicular bisector of the {what}; the closed "
                "form allows one",
                pointer=f"/site/{what}",
                remedy="use forward_scatter_ml, which takes the true places",
                code="site_geometry",
            )
        if askew > TOLD_ASKEW_DEG:
            notes.append(
                Note(
                    "site_not_symmetrical",
                    f"The base line is {askew:.2f} degrees beside the perpendicular bisector of the {what}: the closed "
                    "form takes their spacing across the base line.",
                )
            )
        low = int(np.argmin(terminals[:, 1]))
        lower_y = terminals[low, 1]
        side = [bool(c.feet[i, foot, 1] == lower_y) for i in range(len(c.feet))]
        lower = tuple(i for i, at in enumerate(side) if at)
        upper = tuple(i for i, at in enumerate(side) if not at)
        out.append(Pair(lower, upper, float(dy), foot == 0))
    if not out:
        raise RecordingError(
            "one Doppler alone cannot tell the distance from one end of the base line from that to the other",
            pointer="/recording_id",
            remedy="use forward_scatter_angle with an azimuth, or give the Doppler of a second receiver",
            code="one_doppler",
        )
    return out, tuple(notes)


def dopplers_of(pair: Pair, doppler: Floats) -> Floats:
    """(K, 2, L) lower and upper Doppler of a pair; the mean over the other side's terminals where there are two.

    A mean needs both: the two differ by more than the noise.
    """
    halves = []
    for channels in (pair.lower, pair.upper):
        total = doppler[:, channels[0]]
        for channel in channels[1:]:
            total = total + doppler[:, channel]
        halves.append(total / len(channels))
    return np.ascontiguousarray(np.stack(halves, axis=1))


def median_interval(time_s: Floats) -> float:
    """Median of the intervals between instants that differ, s; 1 where there are none."""
    steps = np.diff(time_s)
    steps = steps[steps > 0]
    return float(np.median(steps)) if steps.size else 1.0
