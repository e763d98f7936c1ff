"""From a scenario of passes to Dopplers with their truth and site, the exact model under independent noise.

Every kind of draw of a trial has a stream of its own, so that switching one effect on leaves the others' draws as they
were; everything is elementwise, so no bit depends on how trials are cut.

References
----------
specification 3, 8.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.forward_scatter.scenario_parameters import PassParameters
from algorithms.recording import DopplerPairs
from algorithms.site import Site, Terminal
from algorithms.spec import Leg, trial_stream
from algorithms.toolbox.frames.forward_scatter import ScatterFrame
from algorithms.toolbox.scenario.timing import timing_stream
from algorithms.toolbox.sensors.doppler import doppler_hz

Floats = NDArray[np.float64]

# Purposes of the random streams; 0 belongs to the algorithm.
NOISE, AZIMUTH, ELEVATION, RATE, IS_FALSE, FALSE_VALUE, MISSING = range(1, 8)
BESIDE_M = 3_000.0
LEAST_ACROSS = 0.05
MOST_ROWS = 200_000
# The crossing of the tables is the first instant so long after it.
AFTER_CROSSING_S = 0.75


def flight(p: PassParameters) -> tuple[float, float, float]:
    """Velocity along and across, m/s, and the crossing time of the first target, s.

    Raises
    ------
    ParameterError
        A course along the base line, a distance beyond it, an acceleration that turns the target round before it.
    """
    psi = np.radians(p.course_deg)
    along, across = float(p.speed_mps * np.cos(psi)), float(p.speed_mps * np.sin(psi))
    if abs(np.sin(psi)) < LEAST_ACROSS:
        raise ParameterError(
            f"A course of {p.course_deg:g} degrees runs along the base line, and does not cross it.",
            pointer="/course_deg",
            remedy="Give one further from 0 and 180 degrees.",
        )
    furthest = p.crossing_distance_m + (p.targets - 1) * p.distance_step_m
    if not (0 < p.crossing_distance_m < p.base_m and 0 < furthest < p.base_m):
        raise ParameterError(
            f"The crossing lies at {p.crossing_distance_m:g} to {furthest:g} m, not on a base line of {p.base_m:g} m.",
            pointer="/crossing_distance_m",
            remedy="Choose a distance between the receivers and the transmitter.",
        )
    if p.crossing_time_s is not None:
        return along, across, p.crossing_time_s
    # 3 km = |v_y| d - a_y d^2 / 2 on the way in, with the velocity of the crossing.
    pull = p.acceleration_mps2 * np.sign(across)
    root = across * across + 2 * -pull * BESIDE_M
    if root <= 0:
        raise ParameterError(
            f"With {p.acceleration_mps2:g} m/s2 the target never was 3 km beside the base line.",
            pointer="/acceleration_mps2",
            remedy="Make it smaller, or give the crossing time.",
        )
    return along, across, float(2 * BESIDE_M / (abs(across) + np.sqrt(root)))


def simulate(p: PassParameters, trials: tuple[int, ...], seed: int) -> DopplerPairs:
    """Simulate the passes of a scenario; with no trials at all only instants and truth, which checks it completely."""
    along, across, tau = flight(p)
    time, which = _instants(p, tau)
    frame, tx, rx = _places(p, 0.0, 0.0)
    position, velocity = _truth(p, along, across, tau, time, which)
    told = _site(p)
    channels, pairs = _channels(p)
    lanes = len(trials)
    exact = np.empty((time.size, len(pairs)))
    rates = np.empty((time.size, len(pairs)))
    for c, (i, j) in enumerate(pairs):
        # A clock that is late stamps what happens too early.
        late = -p.clock_error_ms / 1000 if c % 2 else 0.0
        where, speed = _truth(p, along, across, tau, time - late, which)
        offset = p.common_offset_hz + (p.frequency_offset_hz if c % 2 else 0.0)
        exact[:, c] = doppler_hz(where, speed, tx[i], rx[j], p.wavelength_m) + offset
        rates[:, c] = _rate(p, along, across, tau, time - late, which, tx[i], rx[j])
    doppler, rate, azimuth, elevation = _measured(p, exact, rates, position - rx[0], trials, seed)
    return DopplerPairs(
        time_s=time,
        row=np.arange(1, time.size + 1),
        target=np.zeros(time.size, np.int64),
        truth_m=frame.to_enu(position),
        truth_velocity_mps=frame.turned_to_enu(velocity),
        site=told,
        doppler_hz=doppler.reshape(time.size, len(pairs), lanes),
        doppler_rate_hz_s=rate,
        azimuth_rad=azimuth,
        elevation_rad=elevation,
        channels=channels,
    )


def legs_of(p: PassParameters) -> tuple[Leg, ...]:
    """Instants of the tables, the crossing and the end, as far as there are measurements."""
    _, _, tau = flight(p)
    time, _ = _instants(p, tau)
    half = 0.49 * p.period_s
    out = [Leg(f"t={t:g}", t - half, t + half) for t in p.instants_s if (abs(time - t) < half).any()]
    after = time[time >= tau + AFTER_CROSSING_S]
    if after.size:
        out.append(Leg("crossing", float(after[0]) - half, float(after[0]) + half))
    if time.size:
        out.append(Leg("end", float(time[-1]) - half, float(time[-1]) + half))
    return tuple(out)


def _instants(p: PassParameters, tau: float) -> tuple[Floats, NDArray[np.int64]]:
    """Instants of all targets and whose pass each belongs to."""
    length = 2 * tau if p.observed_s is None else p.observed_s
    count = int(max(length, 0.0) / p.period_s + 1e-9) + 1
    if count * p.targets > MOST_ROWS:
        raise ParameterError(
            f"This would make {count * p.targets:,} rows; a recording of this scenario takes at most {MOST_ROWS:,}.",
            pointer="/period_s",
            remedy="Make the observation shorter or the measurements rarer.",
        )
    if p.targets > 1 and p.target_interval_s <= (count - 1 + 2 * p.jitter_share) * p.period_s:
        raise ParameterError(
            f"A pass lasts {(count - 1) * p.period_s:g} s, so the next target cannot come after "
            f"{p.target_interval_s:g} s.",
            pointer="/target_interval_s",
            remedy="Make it longer, or observe each target for a shorter time.",
        )
    # Up to a quarter of an interval: then neighbours stay in order, and no leg holds two of them.
    moved = p.jitter_share * (2 * timing_stream(p.timing_seed, 0).random((p.targets, count)) - 1)
    each = np.maximum(p.period_s * (np.arange(count) + moved), 0.0)
    return (each + p.target_interval_s * np.arange(p.targets)[:, None]).ravel(), np.repeat(np.arange(p.targets), count)


def _truth(
    p: PassParameters, along: float, across: float, tau: float, time: Floats, which: NDArray[np.int64]
) -> tuple[Floats, Floats]:
    d = time - tau - which * p.target_interval_s
    x = p.crossing_distance_m + which * p.distance_step_m + along * d
    y = across * d + 0.5 * p.acceleration_mps2 * d * d
    position = np.stack([x, y, np.full_like(d, p.altitude_m)], axis=1)
    velocity = np.stack([np.full_like(d, along), across + p.acceleration_mps2 * d, np.zeros_like(d)], axis=1)
    return position, velocity


def _rate(
    p: PassParameters, along: float, across: float, tau: float, time: Floats, which: NDArray[np.int64],
    tx: Floats, rx: Floats,
) -> Floats:  # fmt: skip
    """Frequency rate by central differences of 10 ms, exact to 1e-6 Hz/s here."""
    step = 0.01
    ends = [
        doppler_hz(*_truth(p, along, across, tau, time + side * step, which), tx, rx, p.wavelength_m)
        for side in (1, -1)
    ]
    return np.asarray((ends[0] - ends[1]) / (2 * step))


def _places(p: PassParameters, base_percent: float, spacing_percent: float) -> tuple[ScatterFrame, Floats, Floats]:
    """Frame, transmitters and receivers in x, y, z."""
    a = p.base_m * (1 + base_percent / 100)
    b = p.spacing_m * (1 + spacing_percent / 100)
    d = p.transmitter_spacing_m
    bearing = np.radians(90.0 - p.bearing_deg)
    frame = ScatterFrame(np.zeros(3), float(np.cos(bearing)), float(np.sin(bearing)))
    tx = np.array([[a, 0.0, 0.0]] if d == 0 else [[a, -d / 2, 0.0], [a, d / 2, 0.0]])
    turn = np.radians(p.askew_deg)
    upper = b / 2 * np.array([-np.sin(turn), np.cos(turn), 0.0])
    # Plus zero: no place is at minus zero.
    rx = np.array([[0.0, 0.0, 0.0]] if p.one_receiver else [-upper, upper]) + 0.0
    return frame, tx, rx


def _site(p: PassParameters) -> Site:
    """Return the site as the algorithms are told it."""
    frame, tx, rx = _places(p, p.base_error_percent, p.spacing_error_percent)

    def terminals(prefix: str, places: Floats) -> tuple[Terminal, ...]:
        enu = frame.to_enu(places)
        names = [prefix] if len(places) == 1 else [f"{prefix}{i + 1}" for i in range(len(places))]
        return tuple(
            Terminal(name=n, east_m=float(e), north_m=float(m), up_m=float(u))
            for n, (e, m, u) in zip(names, enu, strict=True)
        )

    return Site(
        transmitters=terminals("TX", tx),
        receivers=terminals("RX", rx),
        wavelength_m=p.wavelength_m * (1 + p.wavelength_error_percent / 100),
        sigma_doppler_hz=p.sigma_doppler_hz,
    )


def _channels(p: PassParameters) -> tuple[tuple[str, ...], list[tuple[int, int]]]:
    """Names of the columns, and transmitter and receiver of each."""
    two_tx, two_rx = p.transmitter_spacing_m > 0, not p.one_receiver
    if two_tx and two_rx:
        return ("11", "12", "21", "22"), [(0, 0), (0, 1), (1, 0), (1, 1)]
    if two_tx or two_rx:
        return ("1", "2"), [(0, 0), (1, 0) if two_tx else (0, 1)]
    return ("1",), [(0, 0)]


def _measured(
    p: PassParameters, exact: Floats, rates: Floats, position: Floats, trials: tuple[int, ...], seed: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """Dopplers (M, C, L), rates (M, 2, L), azimuths and elevations (M, L); `position` from the first receiver."""
    m, c = exact.shape
    lanes = len(trials)

    def draw(purpose: int, shape: tuple[int, ...], fill: Callable[[np.random.Generator], Floats]) -> Floats:
        if not trials:
            return np.empty((*shape, 0))
        return np.stack([fill(trial_stream(seed, trial, purpose)).reshape(shape) for trial in trials], axis=-1)

    def normal(purpose: int, *shape: int) -> Floats:
        return draw(purpose, shape, lambda rng: rng.standard_normal(shape))

    def uniform(purpose: int, *shape: int) -> Floats:
        return draw(purpose, shape, lambda rng: rng.random(shape))

    doppler = exact[:, :, None] + p.sigma_doppler_hz * normal(NOISE, m, c)
    if p.blind_zone_hz > 0:
        doppler = np.where(np.abs(doppler) < p.blind_zone_hz, np.nan, doppler)
    if p.false_share > 0:
        is_false = uniform(IS_FALSE, m, c) < p.false_share
        doppler = np.where(is_false, p.false_band_hz * (2 * uniform(FALSE_VALUE, m, c) - 1), doppler)
    if p.missing_share > 0:
        doppler = np.where(uniform(MISSING, m, c) < p.missing_share, np.nan, doppler)
    if p.unsigned:
        doppler = np.abs(doppler)
    rate = np.full((m, 2, lanes), np.nan)
    if p.sigma_doppler_rate_hz_s is not None and c <= 2:
        rate[:, :c] = rates[:, :, None] + p.sigma_doppler_rate_hz_s * normal(RATE, m, c)
    azimuth = np.full((m, lanes), np.nan)
    if p.sigma_azimuth_deg is not None:
        # Clockwise from north; the base line's own bearing is where phi = 0.
        phi = np.degrees(np.arctan2(position[:, 1], position[:, 0]))
        azimuth = np.radians((p.bearing_deg - phi)[:, None] + p.sigma_azimuth_deg * normal(AZIMUTH, m))
    elevation = np.full((m, lanes), np.nan)
    if p.sigma_elevation_deg is not None:
        height = np.arctan2(position[:, 2], np.hypot(position[:, 0], position[:, 1]))
        elevation = height[:, None] + np.radians(p.sigma_elevation_deg) * normal(ELEVATION, m)
    return doppler, rate, azimuth, elevation
