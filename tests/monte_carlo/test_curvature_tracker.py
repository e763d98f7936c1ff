"""The paper's tracker on one manoeuvring aircraft against table 9.1 of the specification.

As there: a track already started from the first three plots, no false plots, every plot detected; a plot outside the
outer gate is a miss, five misses delete the track, which then starts anew from the last three plots. Errors are those
of the estimate at every instant, of a coasting track too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from algorithms.plot_tracking.curvature_scan import MANOEUVRE, Rules, advance
from algorithms.plot_tracking.plots import Scan
from algorithms.plot_tracking.track_table import TrackTable
from algorithms.toolbox.motion.curvature import shifted, wrapped

SIGMA_R, SIGMA_TH, PERIOD_S = 200.0, np.radians(8 / 60), 5.0
TIMES = np.arange(0.0, 301.0, PERIOD_S)
RUNS = 200
WIDE_TURN = np.tan(np.radians(25)) * 9.80665 / 200.0
TIGHT_TURN = np.radians(3.0)

# Start (north, east) m, course rad, speed m/s; then instants with acceleration and turn rate.
MOTIONS = {
    "S1": ((40e3, -30e3, np.pi / 2, 200.0), ()),
    "S2": ((40e3, -30e3, np.pi / 2, 200.0), ((100.0, 0.0, WIDE_TURN), (168.70, 0.0, 0.0))),
    "S3": ((45e3, -6e3, np.pi / 2, 120.0), ((100.0, 0.0, TIGHT_TURN), (160.0, 0.0, 0.0))),
    "S4": ((40e3, -30e3, np.pi / 2, 100.0), ((100.0, 2.0, 0.0), (160.0, 0.0, 0.0))),
}


def truth(name: str, t: np.ndarray) -> np.ndarray:
    """(4, n) north, east, course, speed."""
    start, events = MOTIONS[name]
    p, since = np.array([*start, 0.0, 0.0]), 0.0
    out = shifted(p[:, None], t)
    for at, a, turn in events:
        p, since = shifted(p, np.array(at - since)), at
        p[4], p[5] = a, turn / p[3]
        later = t >= at
        out[:, later] = shifted(p[:, None], t[later] - at)
    return out[:4]


@dataclass
class Outcome:
    """(n, RUNS) errors, whether a manoeuvre was called; losses per run."""

    place: np.ndarray
    speed: np.ndarray
    course: np.ndarray
    called: np.ndarray
    lost: float

    def rms(self, low: float, high: float) -> np.ndarray:
        inside = (low < TIMES) & (high >= TIMES)
        return np.array([np.sqrt(np.mean(e[inside] ** 2)) for e in (self.place, self.speed, self.course)])


def scan_of(t: float, rho: np.ndarray, theta: np.ndarray, lanes: np.ndarray) -> Scan:
    return Scan(t, lanes, lanes, np.full(lanes.size, t), rho, theta)


def tracked(name: str, rules: Rules, seed: int = 3) -> Outcome:
    rng = np.random.default_rng(seed)
    true = truth(name, TIMES)
    lanes = np.arange(RUNS)
    rho = np.hypot(true[0], true[1])[:, None] + rules.sigma_r * rng.standard_normal((TIMES.size, RUNS))
    theta = np.arctan2(true[1], true[0])[:, None] + rules.sigma_th * rng.standard_normal((TIMES.size, RUNS))
    scans = [scan_of(t, rho[k], theta[k], lanes) for k, t in enumerate(TIMES)]
    numbers = np.ones(RUNS, int)
    tracks = started(scans[:3], rules, numbers, lanes)
    errors = np.zeros((3, TIMES.size, RUNS))
    called = np.zeros((TIMES.size, RUNS), bool)
    lost = 0
    for k in range(3, TIMES.size):
        tracks, taken, ending = advance(tracks, scans[k], rules, numbers)
        called[k] = taken.role == MANOEUVRE
        tracks = tracks.take(tracks.plots >= 3)
        gone = np.setdiff1d(lanes, tracks.lane)
        lost += gone.size
        if gone.size:
            assert set(ending.lane[ending.number > 0]) == set(gone)
            part = [scan_of(s.time_s, s.rho[gone], s.theta[gone], gone) for s in scans[k - 2 : k + 1]]
            tracks = tracks.joined(started(part, rules, numbers, gone))
        tracks = tracks.take(np.argsort(tracks.lane))
        assert tracks.lane.tolist() == lanes.tolist()
        now = shifted(tracks.p, TIMES[k] - tracks.last_s)
        errors[0, k] = np.hypot(now[0] - true[0, k], now[1] - true[1, k])
        errors[1, k] = now[3] - true[3, k]
        errors[2, k] = np.degrees(wrapped(now[2] - true[2, k]))
    return Outcome(*errors, called, lost / RUNS)


def started(scans: list[Scan], rules: Rules, numbers: np.ndarray, lanes: np.ndarray) -> TrackTable:
    """A track of each lane through three plots, whatever the gates say."""
    tracks = TrackTable.starting_from(scans[0], np.arange(lanes.size), rules.history_plots)
    for scan in scans[1:]:
        tracks.append(np.arange(lanes.size), scan, np.arange(lanes.size))
    from algorithms.plot_tracking.curvature_scan import _refit

    tracks.number[:] = numbers[lanes]
    numbers[lanes] += 1
    _refit(tracks, np.arange(lanes.size), rules)
    return tracks


# The table was made without a floor for the error across the ray.
PAPER = Rules(SIGMA_R, SIGMA_TH, PERIOD_S, least_across_m=0.0)
LINE = replace(PAPER, predictor="line", gate_law="sqrt", kept_plots=3)
RARE = replace(PAPER, confidences=(0.65, 0.99, 0.9998))
KEEP = replace(PAPER, reset_on_miss=False)
HELD = replace(PAPER, predictor="map6", gate_law="exact")


def test_the_check_point_of_the_second_scenario() -> None:
    at = truth("S2", np.array([150.0, 300.0]))
    np.testing.assert_allclose(at[:2, 0], [34879.93, -2040.29], atol=0.2)
    assert np.degrees(at[2, 0]) == pytest.approx(155.502, abs=2e-3)
    np.testing.assert_allclose(at[:2, 1], [4992.84, -1252.85], atol=1.0)


# Position m, speed m/s and course deg in the segments pre, man, rec, end; tracks lost per run.
TABLE = {
    "S1 paper": ("S1", PAPER, ((171, 13.2, 5.6), None, None, (178, 13.7, 6.0)), 0),
    "S1 rarer manoeuvres": ("S1", RARE, ((161, 8.9, 3.5), None, None, (167, 9.4, 4.1)), 0),
    "S1 line": ("S1", LINE, ((142, 6.9, 2.7), None, None, (146, 7.3, 3.0)), 0),
    "S2 paper": ("S2", PAPER, ((171, 13.2, 5.6), (215, 17.8, 8.9), (284, 27.2, 8.2), (157, 20.8, 1.5)), 0.003),
    "S2 keep": ("S2", KEEP, ((172, 13.2, 5.6), (389, 18.8, 10.8), None, (172, 21.2, 1.5)), 0.47),
    "S2 line": ("S2", LINE, ((142, 6.9, 2.7), (713, 13.3, 18.5), (519, 15.5, 9.5), (131, 11.1, 0.8)), 0.71),
    "S2 held": ("S2", HELD, ((164, 8.6, 3.9), (210, 11.3, 8.3), (255, 16.2, 7.4), (147, 12.5, 1.3)), 0),
    "S3 paper": ("S3", PAPER, ((172, 11.5, 9.1), (273, 18.6, 19.5), (368, 15.0, 26.5), (173, 12.5, 9.9)), 0),
    "S4 paper": ("S4", PAPER, (None, (225, 19.1, 10.4), (195, 19.7, 6.9), (174, 13.1, 5.5)), 0.003),
}
# Position within these shares: the table's own error is 1.5 %, up to 8 m behind a turn and 20 to 30 m where tracks are
# lost; ours is a half larger.
SHARES = {"pre": 0.09, "man": 0.2, "rec": 0.2, "end": 0.1}


@pytest.mark.slow
@pytest.mark.parametrize("case", TABLE)
def test_table_9_1(case: str) -> None:
    name, rules, rows, lost = TABLE[case]
    outcome = tracked(name, rules)
    on, off = (100.0, {"S2": 168.70}.get(name, 160.0))
    spans = {"pre": (49, 100), "man": (on, off), "rec": (off, off + 40), "end": (200 if name == "S1" else 250, 300)}
    for (segment, span), row in zip(spans.items(), rows, strict=True):
        found = outcome.rms(*span)
        print(case, segment, np.round(found, 1), row, "lost", outcome.lost)
        if row is not None:
            np.testing.assert_allclose(found, row, rtol=SHARES[segment], atol=0.4, err_msg=segment)
    assert abs(outcome.lost - lost) < 0.02 + 4 * np.sqrt(lost / RUNS)
    if name == "S1":
        inside = (TIMES >= 50) & (TIMES <= 100)
        share = outcome.called[inside].mean()
        assert abs(share - {"ml6": 0.035, "line": 0.039}[rules.predictor]) < 0.008 or rules is RARE
