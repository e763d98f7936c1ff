"""What calibration errors cost: metres of the crossing distance per step of clock, frequency, places or wavelength.

Residuals do not show such errors, so they are computed: the pass as it was estimated is simulated without noise, once
as it is and once with the error, and the method that ran answers to both.

References
----------
specification 8.7.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import FilterRoomError
from algorithms.forward_scatter.bound import bounds_along_base
from algorithms.forward_scatter.conditions import Conditions, conditions_of
from algorithms.forward_scatter.motion import doppler_rows
from algorithms.forward_scatter.outputs import ANSWERED
from algorithms.forward_scatter.parameters import CALIBRATION, ScatterParameters
from algorithms.recording import DopplerPairs
from algorithms.result import Result, Table
from algorithms.site import Site, Terminal
from algorithms.spec import LocalContext

Floats = NDArray[np.float64]
Run = Callable[[DopplerPairs, Any, Any], Result]

# So many instants of a pass are enough, and cost little.
MOST_INSTANTS = 60
# (what, step, unit): the second channel's clock late, its frequency up, all frequencies up, and what the site tells.
STEPS = (
    ("clock", 1.0, "ms"),
    ("frequency_offset", 0.1, "Hz"),
    ("common_offset", 0.1, "Hz"),
    ("spacing", 1.0, "%"),
    ("base", 1.0, "%"),
    ("wavelength", 1.0, "%"),
)


def calibration_tables(
    run: Run, parameters: type[ScatterParameters], recording: DopplerPairs, result: Result
) -> dict[str, Table]:
    """Tables `sensitivities` and `base_bounds` of the first trial's last answered pass; empty where there is none."""
    rows: list[tuple[Any, ...]] = []
    places, limits = np.empty(0), np.empty((0, 4))
    found = _last_pass(result)
    if found is not None and recording.site is not None:
        track, positions, theta = found
        names = parameters.model_fields
        given = parameters(**{n: s.value for n, s in result.settings.items() if n in names})
        if positions.size > MOST_INSTANTS:
            positions = positions[np.linspace(0, positions.size - 1, MOST_INSTANTS).round().astype(np.int64)]
        try:
            conditions = conditions_of(recording, given)
            rows = [(track, *row) for row in _sensitivities(run, given, recording, conditions, positions, theta)]
            places, limits = bounds_along_base(conditions, recording.time_s[positions], theta)
        except FilterRoomError:
            rows = []
    return {
        "sensitivities": Table(
            {
                "track": np.array([r[0] for r in rows], float),
                "quantity": [r[1] for r in rows],
                "step": np.array([r[2] for r in rows], float),
                "step_unit": [r[3] for r in rows],
                "error_m": np.array([r[4] for r in rows], float),
            }
        ),
        "base_bounds": Table(
            {
                "distance_m": places,
                "crossing_known_m": limits[:, 0],
                "end_known_m": limits[:, 1],
                "crossing_unknown_m": limits[:, 2],
                "end_unknown_m": limits[:, 3],
            }
        ),
    }


def _last_pass(result: Result) -> tuple[int, NDArray[np.int64], Floats] | None:
    track, status = result.arrays["track"], result.arrays["status"]
    if not track.size:
        return None
    answered = np.flatnonzero(np.isin(status[:, 0], ANSWERED))
    if not answered.size:
        return None
    last = answered[-1]
    theta = np.nan_to_num(np.asarray(result.arrays["theta"], float)[last, :, 0])
    return int(track[last, 0]), np.flatnonzero(track[:, 0] == track[last, 0]), theta


def _sensitivities(
    run: Run,
    parameters: ScatterParameters,
    recording: DopplerPairs,
    conditions: Conditions,
    positions: NDArray[np.int64],
    theta: Floats,
) -> list[tuple[Any, ...]]:
    """What each error costs at the end of the pass, m."""
    time = recording.time_s[positions]
    channels = len(recording.channels)
    own = len(conditions.feet)

    def dopplers(late_s: float) -> Floats:
        value = np.full((channels, time.size), np.nan)
        exact, _ = doppler_rows(time, theta, conditions.feet, conditions.wavelength, conditions.altitude)
        value[:own] = exact
        if late_s and own > 1:
            later, _ = doppler_rows(time - late_s, theta, conditions.feet, conditions.wavelength, conditions.altitude)
            value[1:own:2] = later[1::2]
        return value

    d = time - theta[0]
    phi = np.arctan2(theta[2] * d + 0.5 * theta[4] * d * d, theta[1] + theta[3] * d)
    bearing = np.arctan2(conditions.frame.sine, conditions.frame.cosine)
    plain = replace(
        recording.take(positions),
        target=np.zeros(time.size, np.int64),
        targets=("",),
        doppler_hz=dopplers(0.0).T[:, :, None],
        doppler_rate_hz_s=np.full((time.size, 2, 1), np.nan),
        azimuth_rad=(np.pi / 2 - bearing - phi)[:, None],
        elevation_rad=np.full((time.size, 1), np.nan),
    )
    known = dict.fromkeys(CALIBRATION, 0.0)
    told = parameters.model_copy(update={"passes": "one", "unsigned": False, **known})

    def distance(of: DopplerPairs, with_wavelength: float | None = None) -> float:
        asked = told if with_wavelength is None else told.model_copy(update={"wavelength_m": with_wavelength})
        answer = run(of, asked, LocalContext())
        good = np.flatnonzero(np.isin(answer.arrays["status"][:, 0], ANSWERED))
        return float(answer.arrays["theta"][good[-1], 1, 0]) if good.size else np.nan

    true = distance(plain)
    out: list[tuple[Any, ...]] = []
    for quantity, step, unit in STEPS:
        if quantity in ("clock", "frequency_offset", "spacing") and own < 2:
            continue
        wavelength: float | None = None
        changed = plain
        if quantity == "clock":
            changed = replace(plain, doppler_hz=dopplers(-step / 1000).T[:, :, None])
        elif quantity.endswith("offset"):
            more = np.zeros(channels)
            more[1::2] = step
            if quantity == "common_offset":
                more[:] = step
            changed = replace(plain, doppler_hz=plain.doppler_hz + more[:, None])
        elif quantity == "wavelength":
            wavelength = conditions.wavelength * (1 + step / 100)
        else:
            changed = replace(plain, site=_stretched(recording.site, conditions, quantity, 1 + step / 100))
        out.append((quantity, step, unit, distance(changed, wavelength) - true))
    return out


def _stretched(site: Site | None, conditions: Conditions, quantity: str, factor: float) -> Site | None:
    """The site as it would be told with a larger spacing or a longer base line."""
    if site is None:
        return None
    across, along = (factor, 1.0) if quantity == "spacing" else (1.0, factor)

    def terminals(places: Floats, old: tuple[Terminal, ...]) -> tuple[Terminal, ...]:
        enu = conditions.frame.to_enu(places * np.array([along, across, 1.0]))
        return tuple(
            Terminal(name=one.name, east_m=float(e), north_m=float(n), up_m=float(u))
            for one, (e, n, u) in zip(old, enu, strict=False)
        )

    return site.model_copy(
        update={
            "origin": None,
            "transmitters": terminals(conditions.transmitters, site.transmitters),
            "receivers": terminals(conditions.receivers, site.receivers),
        }
    )
