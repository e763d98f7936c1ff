"""Presets from which multilateration recordings are simulated (specification 7)."""

from __future__ import annotations

import numpy as np

from algorithms.site import Site
from algorithms.spec import Reference, Scenario
from algorithms.toolbox.scenario.mark_parameters import (
    FOUR_STATIONS,
    MarkScenario,
    NamedInterval,
    ReceptionInterval,
)
from algorithms.toolbox.scenario.preset import preset
from algorithms.toolbox.scenario.recording import legs_of, simulate
from algorithms.toolbox.scenario.targets import PathPoint, Target
from algorithms.toolbox.scenario.timing import Gap, Interrogator
from algorithms.toolbox.scenario.trajectory import Segment

MODE_C_STEP_M = 30.48


def four_stations(**extra: object) -> Site:
    """Return the site of the paper (specification 7.0)."""
    places = [s.model_dump(include={"name", "east_m", "north_m", "up_m"}) for s in FOUR_STATIONS]
    return Site.model_validate({"stations": places, **extra})


def _legs(*legs: tuple[str, float, float]) -> tuple[NamedInterval, ...]:
    return tuple(NamedInterval(name=name, start_s=start, stop_s=stop) for name, start, stop in legs)


# Specification 7.1: inbound on a low-GDOP azimuth, manoeuvres, outbound on a high-GDOP azimuth.
_CIRCUIT_TURNS = (
    (400, 0.0), (30, 1.0), (60, -1.0), (30, 1.0), (40, 0.0), (120, 1.0), (40, 0.0), (240, -1.5), (939, 0.0),
)  # fmt: skip
CircuitParameters = preset(
    MarkScenario,
    "CircuitParameters",
    targets=(
        Target(
            east_m=float(200 * 440 + 200 / np.radians(1.0) * (2 + np.sqrt(3))),
            north_m=0.0,
            altitude_m=10_000.0,
            heading_deg=270.0,
            speed_mps=200.0,
            segments=tuple(Segment(duration_s=d, turn_rate_deg_s=w) for d, w in _CIRCUIT_TURNS),
        ),
    ),
    legs=_legs(
        ("inbound", 50, 400),
        ("weave", 400, 520),
        ("turn", 560, 680),
        ("orbit", 720, 960),
        ("out_near", 960, 1200),
        ("out_far", 1200, 1900),
    ),
)

# Specification 7.2: the mark times are its own draw, numpy's default stream of the seed 777.
IncompleteParameters = preset(
    MarkScenario,
    "IncompleteParameters",
    targets=(
        Target(
            east_m=40_000.0,
            north_m=-5_000.0,
            altitude_m=3_000.0,
            heading_deg=280.0,
            speed_mps=120.0,
            segments=(
                Segment(duration_s=150),
                Segment(duration_s=100, climb_rate_mps=5),
                Segment(duration_s=90, turn_rate_deg_s=1, climb_rate_mps=5),
                Segment(duration_s=10, climb_rate_mps=5),
                Segment(duration_s=190),
                Segment(duration_s=60, turn_rate_deg_s=-1),
                Segment(duration_s=400),
            ),
        ),
    ),
    timing="irregular",
    timing_seed=777,
    gate_length_ms=12.0,
    receptions=(
        ReceptionInterval(start_s=0, stop_s=400, probabilities=(0.90, 0.45, 0.85, 0.90)),
        ReceptionInterval(start_s=400, stop_s=700, probabilities=(0.90, 0.01, 0.80, 0.90)),
        ReceptionInterval(start_s=700, probabilities=(0.85, 0.01, 0.50, 0.85)),
    ),
    sigma_altitude_m=0.0,
    claimed_sigma_altitude_m=100.0,
    altitude_bias_sd_m=60.0,
    altitude_step_m=MODE_C_STEP_M,
    decoding_probability=0.9,
    legs=_legs(("0-400", 0, 400), ("400-700", 400, 700), ("700-1000", 700, 1000)),
)

# Ours: what else can be described. Two aircraft cross at 300 s, 600 m apart in altitude.
CrossingParameters = preset(
    MarkScenario,
    "CrossingParameters",
    targets=(
        Target(
            name="A",
            east_m=42_000.0,
            north_m=14_000.0,
            altitude_m=6_000.0,
            heading_deg=270.0,
            speed_mps=140.0,
            segments=(
                Segment(duration_s=330),
                Segment(duration_s=45, turn_rate_deg_s=-2.0, climb_rate_mps=-6.0),
                Segment(duration_s=225, climb_rate_mps=-6.0, acceleration_mps2=-0.1),
            ),
        ),
        Target(
            name="B",
            points=tuple(
                PathPoint(time_s=t, east_m=x, north_m=y, altitude_m=h)
                for t, x, y, h in (
                    (0, -30_000, -12_000, 4_500), (120, -16_000, -4_000, 5_000), (240, -4_500, 8_500, 5_400),
                    (300, 0, 14_000, 5_400), (420, 11_000, 24_000, 5_400), (600, 33_000, 33_000, 6_500),
                )
            ),
        ),
    ),
    timing="interrogators",
    interrogators=(
        Interrogator(period_s=5.0, replies=4, interval_s=0.005, reply_probability=0.8),
        Interrogator(period_s=12.0, phase_s=3.0, replies=6, interval_s=0.004, reply_probability=0.6),
    ),
    gaps=(Gap(start_s=450, stop_s=490),),
    gate_length_ms=12.0,
    reception_probability=0.9,
    receptions=(ReceptionInterval(start_s=200, stop_s=260, probabilities=(1.0, 0.2, 1.0, 1.0)),),
    outlier_share=0.005,
    sigma_altitude_m=0.0,
    claimed_sigma_altitude_m=50.0,
    altitude_bias_sd_m=30.0,
    altitude_step_m=7.62,
    decoding_probability=0.9,
    legs=_legs(("apart", 0, 270), ("crossing", 270, 330), ("after", 330, 600)),
)  # fmt: skip

SCENARIOS = (
    Scenario(
        name="four_station_circuit",
        title="Circuit around four stations",
        summary="Straight in on a low-GDOP azimuth, weave, turn, orbit, straight out on a high-GDOP azimuth; "
        "1,900 complete marks, one a second.",
        family="multilateration",
        kind="toa_marks",
        parameters=CircuitParameters,
        simulate=simulate,
        legs=legs_of,
        references=(Reference("chugunov2023", "figs. 2, 3"),),
    ),
    Scenario(
        name="four_station_incomplete",
        title="Incomplete marks",
        summary="1,022 irregular marks, at most 40 % complete, almost none after 400 s; altitude in 100 ft steps.",
        family="multilateration",
        kind="toa_marks",
        parameters=IncompleteParameters,
        simulate=simulate,
        legs=legs_of,
        references=(Reference("chugunov2023", "figs. 4-7"),),
    ),
    Scenario(
        name="two_aircraft_crossing",
        title="Two aircraft cross",
        summary="Marks come in bursts from two interrogators, with a gap, late receptions and missing ones; "
        "one aircraft flies segments, the other a table of points.",
        family="multilateration",
        kind="toa_marks",
        parameters=CrossingParameters,
        simulate=simulate,
        legs=legs_of,
    ),
)
