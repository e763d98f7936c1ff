"""Emitters without addresses are told apart, and every decision is listed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration import mlat_imm, rdfv
from algorithms.multilateration.emitters import DECISIONS
from algorithms.multilateration.scenario import CrossingParameters, simulate
from algorithms.multilateration.separated import LIFE_WORDS
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext
from algorithms.toolbox.scenario.mark_parameters import ReceptionInterval
from algorithms.toolbox.scenario.targets import Segment, Target


def nameless(recording: ToaMarks) -> ToaMarks:
    return replace(recording, target=np.zeros(len(recording), np.int64), targets=("",))


def separated(recording: ToaMarks, module: object = rdfv, **chosen: object) -> Result:
    parameters = module.ALGORITHM.parameters(emitters="separate", **chosen)  # type: ignore[attr-defined]
    result: Result = module.run(recording, parameters, LocalContext())  # type: ignore[attr-defined]
    return result


def shares(recording: ToaMarks, result: Result) -> dict[int, list[int]]:
    """Marks of each true target that each emitter got."""
    emitter = result.arrays["emitter"]
    return {
        e: [int(((emitter == e) & (recording.target == t)).sum()) for t in range(len(recording.targets))]
        for e in range(-1, int(emitter.max()) + 1)
    }


@pytest.fixture(scope="module")
def crossing() -> ToaMarks:
    return simulate(CrossingParameters(), (0,), 21)


def test_two_crossing_aircraft_are_told_apart(crossing: ToaMarks) -> None:
    part = crossing.take(np.flatnonzero((crossing.time_s > 230) & (crossing.time_s < 380)))
    result = separated(nameless(part))
    found = shares(part, result)
    assert set(found) == {-1, 0, 1}
    assert sum(found[-1]) < 0.08 * len(part)
    for e in (0, 1):
        assert min(found[e]) <= 2, "an emitter has the marks of one aircraft"
        assert max(found[e]) > 80
    assert np.argmax(found[0]) != np.argmax(found[1])
    error = np.hypot(*(result.arrays["state"][:, [0, 3], 0] - part.truth_m[:, :2]).T)
    assert np.nanmedian(error) < 40


def test_lives_of_tracks_are_told_as_those_of_plots_are(crossing: ToaMarks) -> None:
    """Two emitters begin, are confirmed, and end a minute after their last marks; what is too short never was one."""
    times = crossing.time_s
    part = nameless(crossing.take(np.flatnonzero((times < 100) | ((times > 290) & (times < 292)) | (times > 400))))
    result = separated(part)
    lives = rdfv.ALGORITHM.tabulate(part, result)["track_events"].columns
    steps: dict[str | None, list[tuple[str, str]]] = {}
    for emitter, status, reason in zip(lives["emitter"], lives["status"], lives["reason"], strict=True):
        steps.setdefault(emitter, []).append((status, reason))
    begun, sure = ("tentative", "enough marks to follow it"), ("confirmed", "enough marks to confirm it")
    for emitter in ("emitter 1", "emitter 2"):
        assert steps[emitter] == [begun, sure, ("dropped", "silent for a minute")]
    assert set(steps[None]) <= {begun, ("dropped", "silent before it was confirmed"), ("dropped", LIFE_WORDS[-1])}
    assert all(np.diff(np.asarray(lives["time_s"])) >= 0)


def test_every_decision_is_listed_with_its_words(crossing: ToaMarks) -> None:
    part = nameless(crossing.take(np.arange(200)))
    toa = part.toa_s.copy()
    toa[50, 1:] = np.nan
    part = replace(part, toa_s=toa)
    result = separated(part)
    tables = rdfv.ALGORITHM.tabulate(part, result)
    listed = tables["emitters"].columns
    assert len(tables["emitters"]) == len(part)
    assert listed["decision"][50] == "too_few"
    assert listed["reason"][50] == "fewer than two receptions say nothing of the emitter"
    assert listed["emitter"][50] is None
    assigned = np.array([d == "assigned" for d in listed["decision"]])
    distance, threshold = np.asarray(listed["distance"]), np.asarray(listed["threshold"])
    assert (distance[assigned] <= threshold[assigned]).all()
    decisions = tables["decisions"].columns
    (at,) = (i for i, row in enumerate(decisions["row"]) if row == part.row[50])
    assert (decisions["code"][at], decisions["reason"][at]) == ("too_few", listed["reason"][50])
    assert set(tables["tracks"].columns["target"]) == {"emitter 1", "emitter 2"}
    assert not np.isfinite(result.arrays["state"][50, 0, 0])
    (note,) = (n for n in result.notes if n.code == "emitters")
    assert note.count == 2


def test_addresses_are_kept_and_one_emitter_is_the_default(crossing: ToaMarks) -> None:
    part = crossing.take(np.arange(120))
    named = separated(part)
    assert (named.arrays["emitter"] == -1).all()
    np.testing.assert_array_equal(
        named.arrays["state"], rdfv.run(part, rdfv.RdfvParameters(), LocalContext()).arrays["state"]
    )
    # Where only some marks have an address, the others are told apart.
    target = np.where(part.target == 0, 0, 1)
    some = replace(part, target=target, targets=("A", ""))
    result = separated(some)
    assert set(result.arrays["emitter"][part.target == 0]) == {-1}
    assert result.arrays["emitter"][part.target == 1].max() == 0
    one = rdfv.run(nameless(part), rdfv.RdfvParameters(), LocalContext())
    assert not one.arrays["emitter_decision"].any()
    assert "emitters" not in rdfv.ALGORITHM.tabulate(nameless(part), one)


def test_a_single_emitter_stays_one() -> None:
    recording = simulate(CrossingParameters(), (0,), 22)
    alone = recording.take(recording.rows_of(1))
    result = separated(nameless(alone), mlat_imm)
    assert result.arrays["emitter"].max() == 0
    assert (result.arrays["emitter"] == 0).mean() > 0.97


@pytest.mark.slow
def test_three_aircraft_heard_by_three_stations_without_altitude() -> None:
    """No mark can start a track: the piles do, from several marks together."""

    def target(name: str, east: float, north: float, height: float, heading: float, speed: float) -> Target:
        return Target(
            name=name, east_m=east, north_m=north, altitude_m=height, heading_deg=heading, speed_mps=speed,
            segments=(Segment(duration_s=300),),
        )  # fmt: skip

    parameters = CrossingParameters(
        targets=(
            target("A", 30_000.0, 12_000.0, 6_000.0, 250.0, 150.0),
            target("B", -25_000.0, 20_000.0, 9_000.0, 120.0, 220.0),
            target("C", 5_000.0, -28_000.0, 3_000.0, 10.0, 100.0),
        ),
        timing="irregular",
        receptions=(ReceptionInterval(start_s=0, probabilities=(0.95, 0.95, 0.95, 0.0)),),
        reception_probability=1.0, gaps=(), outlier_share=0.0, legs=(),
    )  # fmt: skip
    recording = simulate(parameters, (0,), 3)
    deaf = replace(recording, altitude_m=np.full_like(recording.altitude_m, np.nan))
    result = separated(nameless(deaf))
    found = shares(deaf, result)
    assert set(found) == {-1, 0, 1, 2}
    assert sum(found[-1]) < 30
    assert all(sorted(found[e])[:2] == [0, 0] for e in range(3))
    decisions = {DECISIONS[d] for d in result.arrays["emitter_decision"]}
    assert "started" in decisions
