"""Two radars under one name are told by their rotations, their cadences or targets that jump; one radar is not."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from algorithms.recording import PolarPlots
from backend.files.mixed_radars import look_at_radars
from backend.files.report import Findings

PERIODS = [(5.0, 5.0), (5.0, 6.3), (4.0, 11.0)]


def plots(periods: tuple[float, ...], *, turning: bool, named: bool = False, scans: int = 40) -> PolarPlots:
    """Ten aircraft, seen by radars 60 km apart of which the second is two seconds late; all of one name."""
    rng = np.random.default_rng(4)
    start = rng.uniform(-80e3, 80e3, (10, 2))
    velocity = rng.uniform(-200, 200, (10, 2))
    rows = []
    for radar, period in enumerate(periods):
        for scan in range(scans):
            for k in range(10):
                time = 2.0 * radar + scan * period
                place = start[k] + velocity[k] * time - [60e3 * radar, 0]
                azimuth = np.mod(np.arctan2(*place), 2 * np.pi)
                time += azimuth / (2 * np.pi) * period if turning else 0.0
                if rng.random() < 0.9:
                    rows.append((time, np.hypot(*place), azimuth, k))
    time, rho, theta, target = np.array(sorted(rows)).T
    n = time.size
    none, unknown = np.full((n, 1), np.nan), np.full(n, -1)
    return PolarPlots(
        time_s=time, row=np.arange(1, n + 1), target=target.astype(int) if named else np.zeros(n, np.int64),
        range_m=rho[:, None], azimuth_rad=theta[:, None], elevation_rad=none, altitude_m=none, east_m=none,
        north_m=none, radar=np.zeros(n, np.int64), radar_east_m=np.full(n, np.nan), radar_north_m=np.full(n, np.nan),
        scan=unknown, address=unknown, callsign=unknown,
        targets=tuple(f"T{k}" for k in range(10)) if named else ("",),
    )  # fmt: skip


def said(recording: PolarPlots) -> str:
    findings = Findings()
    look_at_radars(recording, findings)
    assert len(findings.warnings) <= 1
    assert {w.code for w in findings.warnings} <= {"radars_mixed"}
    return findings.warnings[0].detail if findings.warnings else ""


@pytest.mark.parametrize("periods", PERIODS)
def test_two_antennas_that_turn(periods: tuple[float, float]) -> None:
    told = said(plots(periods, turning=True))
    assert "Two antennas seem to turn" in told
    assert "column radar" in told


@pytest.mark.parametrize("periods", PERIODS)
def test_two_cadences_of_scans(periods: tuple[float, float]) -> None:
    told = said(plots(periods, turning=False))
    assert "two cadences" in told
    found = sorted(float(word) for word in re.findall(r"every ([0-9.]+) s", told))
    assert found == pytest.approx(periods, rel=2e-3)


def test_named_targets_jump_between_two_places() -> None:
    recording = plots((5.0, 5.0), turning=False, named=True)
    rng = np.random.default_rng(1)
    # Neither a rotation nor a cadence.
    recording = replace(recording, time_s=np.sort(recording.time_s + rng.uniform(0, 0.5, recording.time_s.size)))
    assert "10 named targets 10 jump" in said(recording)
    one = plots((5.0,), turning=False, named=True)
    clutter = replace(one, targets=("clutter", *one.targets[1:]), range_m=np.where(
        one.target[:, None] == 0, rng.uniform(1e3, 150e3, one.range_m.shape), one.range_m))  # fmt: skip
    assert said(clutter) == ""


@pytest.mark.parametrize("turning", [True, False])
def test_one_radar_is_one_also_with_gaps_and_a_clock_that_jumps(turning: bool) -> None:
    one = plots((5.0,), turning=turning)
    rng = np.random.default_rng(2)
    assert said(one) == ""
    gaps = one.take(np.flatnonzero((rng.random(len(one)) < 0.7) & ~((one.time_s > 60) & (one.time_s < 90))))
    assert said(gaps) == ""
    assert said(replace(one, time_s=one.time_s + np.where(one.time_s > 100, 2.3, 0.0))) == ""


def test_two_radars_that_are_named_are_left_alone() -> None:
    first, second = plots((5.0,), turning=True), plots((6.3,), turning=True)
    time = np.concatenate([first.time_s, second.time_s])
    order = np.argsort(time, kind="stable")
    named = replace(
        first, **{f: np.concatenate([getattr(first, f), getattr(second, f)])[order] for f in (
            "time_s", "row", "target", "range_m", "azimuth_rad", "elevation_rad", "altitude_m", "east_m", "north_m",
            "radar_east_m", "radar_north_m", "scan", "address", "callsign")},
        radar=np.repeat([0, 1], [len(first), len(second)])[order], radars=("A", "B"),
    )  # fmt: skip
    assert said(named) == ""
    assert said(replace(named, radar=np.zeros(len(named), np.int64), radars=("",)))
