"""What stands in for an altitude that is not decoded: where it comes from, how far it is trusted, what it brings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from algorithms.multilateration import mlat_imm, rdfv
from algorithms.multilateration.altitudes import SOURCES, altitudes_of
from algorithms.multilateration.parameters import EmitterAltitude, FilterWithAltitudeParameters
from algorithms.multilateration.scenario import CircuitParameters, IncompleteParameters, simulate
from algorithms.recording import ToaMarks
from algorithms.result import Result
from algorithms.spec import LocalContext

SHIP = EmitterAltitude(emitter_type="ship", altitude_m=20.0, sigma_m=15.0)


@pytest.fixture(scope="module")
def marks() -> ToaMarks:
    recording = simulate(CircuitParameters(sigma_altitude_m=30.0, legs=()), (0,), 4).take(np.arange(300, 420))
    altitude = recording.altitude_m.copy()
    altitude[40:] = np.nan
    return replace(recording, altitude_m=altitude)


def sources(result: Result) -> list[str]:
    return [SOURCES[i] for i in result.arrays["altitude_source"][:, 0]]


def given(recording: ToaMarks, **chosen: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    found = altitudes_of(recording, recording.toa_s, FilterWithAltitudeParameters(**chosen), 30.0)
    return found.altitude_m[:, 0], found.extra_m2[:, 0], found.sigma_m[:, 0], found.source[:, 0]


def test_unused_by_default(marks: ToaMarks) -> None:
    altitude, extra, sigma, source = given(marks)
    np.testing.assert_array_equal(altitude, marks.altitude_m[:, 0])
    assert not extra.any()
    assert np.isnan(sigma[40:]).all()
    assert (source[40:] == 0).all()


def test_the_last_one_is_held_with_growing_noise(marks: ToaMarks) -> None:
    altitude, extra, sigma, _ = given(marks, missing_altitude="held", held_altitude_growth_mps=4.0)
    age = marks.time_s[40:] - marks.time_s[39]
    assert (altitude[40:] == altitude[39]).all()
    np.testing.assert_allclose(sigma[40:], np.hypot(30.0, 4.0 * age))
    # Marks 1 s apart within 30 s weigh together as one.
    np.testing.assert_allclose(extra[40:] + 30.0**2, sigma[40:] ** 2 * 30.0)
    assert (extra[:40] == 0).all()
    _, extra, _, _ = given(marks, missing_altitude="held", missing_altitude_time_s=0.0)
    np.testing.assert_allclose(extra[40:], (3.0 * age) ** 2)


def test_the_most_certain_source_is_taken(marks: ToaMarks) -> None:
    of_type = replace(marks, emitter_type=np.zeros(len(marks), np.int64), emitter_types=("ship",))
    chosen = {"missing_altitude": "class", "start_altitude_sd_m": 200.0, "emitter_altitudes": (SHIP,)}
    assert [SOURCES[i] for i in given(of_type, **chosen)[3][38:42]] == ["decoded", "decoded", "type", "type"]
    assert given(of_type, **chosen)[0][40] == 20.0
    # Without a type the altitude is held until the class of all emitters is known better.
    source = given(marks, **chosen)[3][40:]
    age = marks.time_s[40:] - marks.time_s[39]
    np.testing.assert_array_equal(source == SOURCES.index("held"), np.hypot(30.0, 3.0 * age) <= 200.0)
    assert set(source) == {SOURCES.index("held"), SOURCES.index("class")}


def test_a_mark_without_two_receptions_gets_none(marks: ToaMarks) -> None:
    toa = marks.toa_s.copy()
    toa[60:, 1:] = np.nan
    lonely = replace(marks, toa_s=toa)
    result = rdfv.run(lonely, rdfv.RdfvParameters(missing_altitude="class"), LocalContext())
    assert set(sources(result)[60:]) == {"none"}
    assert not result.arrays["altitude_used"][60:].any(), "a lost track must be able to end"


def test_the_result_shows_what_each_altitude_is(marks: ToaMarks) -> None:
    for module in (rdfv, mlat_imm):
        parameters = module.ALGORITHM.parameters(missing_altitude="held")
        result = module.run(marks, parameters, LocalContext())
        states = module.ALGORITHM.tabulate(marks, result)["states"].columns
        assert list(states["altitude_source"][39:41]) == ["decoded", "held"]
        assert states["altitude_sigma_m"][60] > states["altitude_sigma_m"][41]
        (note,) = (n for n in result.notes if n.code == "altitude_held")
        assert note.count == 80
        assert result.settings["missing_altitude"].value == "held"


def test_a_held_altitude_keeps_the_height(marks: ToaMarks) -> None:
    """Triples far from the stations tell no height."""
    toa = marks.toa_s.copy()
    toa[40:, 0] = np.nan
    fewer = replace(marks, toa_s=toa)

    def claimed(**chosen: object) -> tuple[float, float]:
        arrays = rdfv.run(fewer, rdfv.RdfvParameters(**chosen), LocalContext()).arrays
        off = arrays["state"][-1, 6, 0] - fewer.truth_m[-1, 2]
        return float(np.sqrt(arrays["covariance"][-1, 27, 0])), abs(float(off))

    without, _ = claimed()
    held, off = claimed(missing_altitude="held")
    assert held < 0.85 * without
    assert off < 3 * held, "and the claim is honest"


def test_a_known_type_makes_a_start_possible_from_three_receptions(marks: ToaMarks) -> None:
    toa = marks.toa_s.copy()
    toa[:, 2] = np.nan
    bare = replace(marks, toa_s=toa, altitude_m=np.full_like(marks.altitude_m, np.nan))
    typed = replace(bare, emitter_type=np.zeros(len(bare), np.int64), emitter_types=("airliner",))
    table = (EmitterAltitude(emitter_type="airliner", altitude_m=10_000.0, sigma_m=300.0),)
    chosen = {"missing_altitude": "type", "emitter_altitudes": table}
    started = rdfv.run(typed, rdfv.RdfvParameters(**chosen), LocalContext()).arrays
    assert started["track"][0, 0] == 1
    assert rdfv.run(bare, rdfv.RdfvParameters(), LocalContext()).arrays["track"][0, 0] == 0
    # The class of all emitters is too vague for that.
    vague = rdfv.run(bare, rdfv.RdfvParameters(missing_altitude="class"), LocalContext()).arrays
    assert vague["track"][0, 0] == 0


@pytest.mark.slow
def test_numbers_of_the_specification_where_nothing_is_decoded() -> None:
    """Section 8.2: class prior 5000 m with 3000 m at each mark: none beyond 5 km, median 480 m after 700 s; the last
    altitude held after 400 s with 300 m: 120 m.
    """
    recording = simulate(IncompleteParameters(), tuple(range(64)), 7)
    start = {"mode": "truth", "sd": (500, 50, 1)}
    altitude = recording.altitude_m.copy()
    altitude[recording.time_s > 400] = np.nan
    after = recording.time_s > 700

    def errors(marks: ToaMarks, module: object, **chosen: object) -> np.ndarray:
        p = module.ALGORITHM.parameters(start=start, **chosen)  # type: ignore[attr-defined]
        state = module.run(marks, p, LocalContext(3)).arrays["state"]  # type: ignore[attr-defined]
        return np.hypot(*(state[:, [0, 3]] - recording.truth_m[:, :2, None]).transpose(1, 0, 2))

    each = {
        "profile": "article",
        "missing_altitude_time_s": 0.0,
        "start_altitude_m": 5000.0,
        "start_altitude_sd_m": 3e3,
    }
    nothing = replace(recording, altitude_m=np.full_like(altitude, np.nan))
    prior = errors(nothing, rdfv, missing_altitude="class", **each)
    assert prior.max() < 5000
    assert 380 < np.median(prior[after]) < 600
    held = errors(replace(recording, altitude_m=altitude), rdfv, missing_altitude="held", **each)
    assert held.max() < 5000
    assert np.median(held[after]) < 150
    print("each", np.median(prior[after]), np.median(held[after]))
    # The recommended filter, with its own weights.
    for marks, wanted, most in ((replace(recording, altitude_m=altitude), "held", 150), (nothing, "class", 400)):
        plain = errors(marks, mlat_imm)
        helped = errors(marks, mlat_imm, missing_altitude=wanted)
        print(
            wanted,
            np.median(plain[after]),
            np.median(helped[after]),
            (plain > 5000).any(0).mean(),
            (helped > 5000).any(0).mean(),
        )
        assert np.median(helped[after]) < most
