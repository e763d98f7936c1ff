"""Presets from which multilateration recordings are simulated (specification 7)."""

from __future__ import annotations

import numpy as np

from algorithms.recording import ToaMarks
from algorithms.site import Site
from algorithms.spec import Parameters, Reference, Scenario, parameter
from algorithms.toolbox.frames import earth as earths
from algorithms.toolbox.scenario.marks import MarkNoise, simulate_marks
from algorithms.toolbox.scenario.trajectory import Segment, fly

MODE_C_STEP_M = 30.48

# Specification 7.0: one central station and three at 10 km, azimuths 30, 150 and 270 degrees.
_NORTH_M = float(10_000 * np.sqrt(0.75))
FOUR_STATIONS = (
    ("1", 5_000.0, _NORTH_M, 15.0),
    ("2", 5_000.0, -_NORTH_M, 15.0),
    ("3", -10_000.0, 0.0, 15.0),
    ("4", 0.0, 0.0, 15.0),
)


def four_stations(**extra: object) -> Site:
    """Return the site of the paper."""
    stations = [{"name": n, "east_m": x, "north_m": y, "up_m": z} for n, x, y, z in FOUR_STATIONS]
    return Site.model_validate({"stations": stations, **extra})


class CircuitParameters(Parameters):
    """Noise of the simulated circuit."""

    sigma_toa_ns: float = parameter(10.0, title="Time-of-arrival error", unit="ns", symbol="σ_n", gt=0, le=1e5)
    """Standard deviation of one time of arrival."""
    sigma_altitude_m: float = parameter(100.0, title="Altitude error", unit="m", symbol="σ_h", gt=0, le=1e5)
    """Standard deviation of the decoded altitude, white; also the filters' default."""


_CIRCUIT_TURNS = (
    (400, 0.0), (30, 1.0), (60, -1.0), (30, 1.0), (40, 0.0), (120, 1.0), (40, 0.0), (240, -1.5), (939, 0.0),
)  # fmt: skip
CIRCUIT = tuple(Segment(duration_s=d, turn_rate_deg_s=w) for d, w in _CIRCUIT_TURNS)
CIRCUIT_SPEED_MPS = 200.0
CIRCUIT_START_EAST_M = 200 * 440 + 200 / np.radians(1.0) * (2 + np.sqrt(3))
CIRCUIT_ALTITUDE_M = 10_000.0
CIRCUIT_MARKS = 1_900


def simulate_circuit(parameters: CircuitParameters, trials: tuple[int, ...], seed: int) -> ToaMarks:
    """Simulate specification 7.1: inbound on a low-GDOP azimuth, manoeuvres, outbound on a high-GDOP azimuth."""
    site = four_stations(sigma_toa_ns=parameters.sigma_toa_ns, sigma_altitude_m=parameters.sigma_altitude_m)
    earth = earths.sphere()
    time = np.arange(CIRCUIT_MARKS, dtype=float)
    path = fly(
        time, CIRCUIT, east_m=float(CIRCUIT_START_EAST_M), north_m=0.0, altitude_m=CIRCUIT_ALTITUDE_M,
        heading_deg=270.0, speed_mps=CIRCUIT_SPEED_MPS, earth=earth,
    )  # fmt: skip
    noise = MarkNoise(
        sigma_toa_s=parameters.sigma_toa_ns * 1e-9,
        reception_probability=np.ones((time.size, 4)),
        sigma_altitude_m=parameters.sigma_altitude_m,
    )
    toa, altitude, _ = simulate_marks(path, site.station_positions(), earth, noise, trials, seed)
    return _recording(site, time, path.position_m, path.velocity_mps, toa, altitude)


class IncompleteParameters(Parameters):
    """Noise of the experiment-like scenario."""

    sigma_toa_ns: float = parameter(10.0, title="Time-of-arrival error", unit="ns", symbol="σ_n", gt=0, le=1e5)
    """Standard deviation of one time of arrival."""
    altitude_bias_sd_m: float = parameter(60.0, title="Altitude bias", unit="m", ge=0, le=1e5)
    """Standard deviation of the bias, constant in a trial."""
    decoding_probability: float = parameter(0.9, title="Decoding probability", unit="1", ge=0, le=1)
    """Share of marks with a decoded altitude."""
    sigma_altitude_m: float = parameter(100.0, title="Altitude error of the filters", unit="m", gt=0, le=1e5)
    """Default of the filters' altitude error; the scenario's altitude is quantised and biased, not noisy."""


INCOMPLETE = (
    Segment(duration_s=150),
    Segment(duration_s=100, climb_rate_mps=5),
    Segment(duration_s=90, turn_rate_deg_s=1, climb_rate_mps=5),
    Segment(duration_s=10, climb_rate_mps=5),
    Segment(duration_s=190),
    Segment(duration_s=60, turn_rate_deg_s=-1),
    Segment(duration_s=400),
)
INCOMPLETE_GATE_S = 0.012


def simulate_incomplete(parameters: IncompleteParameters, trials: tuple[int, ...], seed: int) -> ToaMarks:
    """Simulate specification 7.2: irregular marks, at most 40 % complete, almost none after 400 s."""
    site = four_stations(
        sigma_toa_ns=parameters.sigma_toa_ns,
        sigma_altitude_m=parameters.sigma_altitude_m,
        gate_length_s=INCOMPLETE_GATE_S,
    )
    earth = earths.sphere()
    # The mark times are part of the scenario, not of a trial: they are the specification's own draw.
    time = np.cumsum(0.4 + np.random.default_rng(777).exponential(0.6, 2000))
    time = time[time < 1000]
    path = fly(
        time, INCOMPLETE, east_m=40_000.0, north_m=-5_000.0, altitude_m=3_000.0, heading_deg=280.0, speed_mps=120.0,
        earth=earth,
    )  # fmt: skip
    probability = np.where(
        time[:, None] < 400,
        [[0.90, 0.45, 0.85, 0.90]],
        np.where(time[:, None] < 700, [[0.90, 0.01, 0.80, 0.90]], [[0.85, 0.01, 0.50, 0.85]]),
    )
    noise = MarkNoise(
        sigma_toa_s=parameters.sigma_toa_ns * 1e-9,
        reception_probability=probability,
        altitude_bias_sd_m=parameters.altitude_bias_sd_m,
        altitude_step_m=MODE_C_STEP_M,
        decoding_probability=parameters.decoding_probability,
        gate_length_s=INCOMPLETE_GATE_S,
    )
    toa, altitude, _ = simulate_marks(path, site.station_positions(), earth, noise, trials, seed)
    return _recording(site, time, path.position_m, path.velocity_mps, toa, altitude)


def _recording(
    site: Site, time: np.ndarray, position: np.ndarray, velocity: np.ndarray, toa: np.ndarray, altitude: np.ndarray
) -> ToaMarks:
    return ToaMarks(
        time_s=time,
        row=np.arange(1, time.size + 1),
        target=np.zeros(time.size, np.int64),
        truth_m=position,
        truth_velocity_mps=velocity,
        site=site,
        toa_s=toa,
        altitude_m=altitude,
        stations=tuple(s.name for s in site.stations),
    )


SCENARIOS = (
    Scenario(
        name="four_station_circuit",
        title="Circuit around four stations",
        summary="Straight in on a low-GDOP azimuth, weave, turn, orbit, straight out on a high-GDOP azimuth; "
        "1,900 complete marks, one a second.",
        family="multilateration",
        kind="toa_marks",
        parameters=CircuitParameters,
        simulate=simulate_circuit,
        references=(Reference("chugunov2023", "figs. 2, 3"),),
    ),
    Scenario(
        name="four_station_incomplete",
        title="Incomplete marks",
        summary="1,022 irregular marks, at most 40 % complete, almost none after 400 s; altitude in 100 ft steps.",
        family="multilateration",
        kind="toa_marks",
        parameters=IncompleteParameters,
        simulate=simulate_incomplete,
        references=(Reference("chugunov2023", "figs. 4-7"),),
    ),
)
