"""A late station of a simulated site is named: five stations, or four with altitude."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration.parameters import AltitudeParameters
from algorithms.multilateration.receivers import assess_receivers
from algorithms.multilateration.scenario import CircuitParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.site import Site

C = 299_792_458.0


def four() -> ToaMarks:
    return simulate(CircuitParameters(sigma_altitude_m=30.0), (0,), 3).take(np.arange(0, 1900, 4))


def five() -> ToaMarks:
    """The same flight heard by a fifth station, without altitude."""
    recording = four()
    assert recording.site is not None
    fifth = {"name": "5", "east_m": 9_000.0, "north_m": 14_000.0, "up_m": 60.0}
    site = recording.site.to_json()
    site["stations"] = [*site["stations"], fifth]
    distance = np.linalg.norm(recording.truth_m - [9_000.0, 14_000.0, 60.0], axis=1)
    noise = np.random.default_rng(5).standard_normal(distance.size) * 10e-9
    toa = np.concatenate([recording.toa_s, (distance / C + noise)[:, None, None]], axis=1)
    return replace(
        recording, site=Site.model_validate(site), stations=("1", "2", "3", "4", "5"), toa_s=toa,
        altitude_m=np.full_like(recording.altitude_m, np.nan),
    )  # fmt: skip


@pytest.mark.parametrize("make", [four, five])
def test_nobody_is_accused_of_nothing(make) -> None:
    assert not any(v.suspect for v in assess_receivers(make(), AltitudeParameters()))


@pytest.mark.parametrize("make", [four, five])
@pytest.mark.parametrize("delay_ns", [300.0, -1000.0])
def test_the_late_station_is_named(make, delay_ns: float) -> None:
    recording = make()
    for j in range(len(recording.stations)):
        toa = recording.toa_s.copy()
        toa[:, j] += delay_ns * 1e-9
        verdicts = assess_receivers(replace(recording, toa_s=toa), AltitudeParameters())
        assert [k for k, v in enumerate(verdicts) if v.suspect] == [j], recording.stations[j]
        assert ("late" if delay_ns > 0 else "early") in str(verdicts[j].reason) or "stood" in str(verdicts[j].reason)


def test_late_receptions_and_a_biased_altitude_accuse_nobody() -> None:
    parameters = CircuitParameters(sigma_altitude_m=30.0, outlier_share=0.01, altitude_bias_sd_m=150.0)
    for seed in range(4):
        recording = simulate(parameters, (0,), seed).take(np.arange(0, 1900, 4))
        verdicts = assess_receivers(recording, AltitudeParameters())
        assert not any(v.suspect for v in verdicts), (seed, verdicts)
