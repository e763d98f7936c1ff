"""Whose mark is it: emitters without addresses told apart by where their marks can come from.

Each mark is held against all live tracks. It belongs to the one inside whose gate it lies; marks of one instant are
matched together, one a track. Where two tracks claim it nearly alike nobody gets it, unless the two are one emitter:
then the younger is given up. What no track claims is kept on piles of marks whose range differences follow each other;
a pile begins a track as soon as the filter can start one from it: from one complete mark, or from several together
(specification 5, step 3). A track that gathers no more than five marks was none: its marks belong to nobody. Every
decision is kept.

A track is tentative, confirmed with its sixth mark, and dropped a minute after its last, or when it turns out to be
another one: stages, reasons and the diary of them are those of plots (`algorithms.toolbox.tracks.life_cycle`). Marks
come one by one and at no period, so no track coasts.

References
----------
Specification 5; barshalom2001, section 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration.conditions import Conditions
from algorithms.multilateration.emitter_tracks import RoughTracks
from algorithms.multilateration.lanes import GAP_S
from algorithms.recording import ToaMarks
from algorithms.spec import RunContext
from algorithms.toolbox.association.assignment import most_likely_matching
from algorithms.toolbox.association.gate import gate_threshold
from algorithms.toolbox.sensors.time_of_arrival import SPEED_OF_LIGHT_MPS
from algorithms.toolbox.tracks import life_cycle
from algorithms.toolbox.tracks.life_cycle import Diary

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Start = Callable[[ToaMarks], tuple[Floats, Floats, float] | None]

DECISIONS = ("", "assigned", "started", "waits", "two_tracks", "too_few", "never_confirmed", "same_emitter")
(_, ASSIGNED, STARTED, WAITS, TWO_TRACKS, TOO_FEW, NEVER_CONFIRMED, SAME_EMITTER) = range(8)

# Probability that a mark of a track lies outside its gate.
TAIL = 1e-4
# Two tracks whose -2 ln likelihoods differ by less than this claim a mark nearly alike.
NEARLY_ALIKE = 9.0
CONFIRMED_MARKS = 6
# Fastest emitter whose marks are chained, m/s, and how many timing errors a range difference may jump.
FASTEST_MPS = 350.0
JUMP_SIGMA = 6.0
# A pile keeps marks no longer than this, s.
PILE_S = 60.0
# Marks of a pile at which a start from several is tried.
TRIED_AT = (5, 7, 10, 14, 19, 25, 32, 40, 50)
MOST_PILE = 50
# Chi-square of six degrees of freedom, 99 %.
ONE_EMITTER = 16.8
# A mark that is better than none, however unlikely inside the gate.
ALWAYS = 1e6


@dataclass(frozen=True)
class Separation:
    """Of each mark (M,): its emitter (0, 1, ...; -1 = nobody's), what was decided, NIS against the gate it was held
    against (NaN = none), and the emitter that claimed it too (-1 = none). Of each step in the life of a track: the
    track's number (from 1), its emitter, the instant, where it went and why (`life_cycle`).
    """

    emitter: Ints
    decision: Ints
    distance: Floats
    threshold: Floats
    rival: Ints
    step_track: Ints
    step_emitter: Ints
    step_time_s: Floats
    step_state: Ints
    step_reason: Ints


@dataclass
class _Book:
    """What has been decided so far; numbers of tracks, not yet of emitters."""

    track: Ints
    decision: Ints
    distance: Floats
    threshold: Floats
    rival: Ints
    same: dict[int, int] = field(default_factory=dict)
    diary: Diary = field(default_factory=Diary)
    confirmed: set[int] = field(default_factory=set)

    def confirm(self, number: int, marks: int, time_s: float) -> None:
        """A track that has enough marks is one, for good."""
        if marks >= CONFIRMED_MARKS and number not in self.confirmed:
            self.confirmed.add(number)
            self.step(number, time_s, life_cycle.CONFIRMED, life_cycle.ENOUGH)

    def step(self, number: int | Ints, time_s: float, state: int, reason: int | Ints) -> None:
        """Write down where tracks go in their lives."""
        numbers = np.atleast_1d(np.asarray(number, np.int64))
        self.diary.note(np.zeros(numbers.size, np.int64), numbers, time_s, state, reason)

    def whose(self, number: int) -> int:
        """The track that a track turned out to be."""
        while number in self.same:
            number = self.same[number]
        return number


def separate(
    recording: ToaMarks, toa_s: Floats, altitude_m: Floats, conditions: Conditions, start: Start, context: RunContext
) -> Separation:
    """Tell the emitters of a recording apart.

    Parameters
    ----------
    toa_s : (M, S), corrected by the stations' offsets
    altitude_m : (M,), NaN = not used
    start : tries to start a track from the marks of a pile: state of nine, covariance and instant at its last mark
    """
    marks = len(recording)
    book = _Book(
        np.full(marks, -1), np.full(marks, WAITS), np.full(marks, np.nan), np.full(marks, np.nan), np.full(marks, -1)
    )
    tracks, begun = RoughTracks(), 0
    piles: list[list[int]] = []
    bounds = [*np.flatnonzero(np.diff(recording.time_s, prepend=-np.inf)).tolist(), marks]
    for first, stop in pairwise(bounds):
        if first % 64 == 0:
            context.check_cancelled()
        now = float(recording.time_s[first])
        silent = now - tracks.last_s > GAP_S
        why = np.where(tracks.marks < CONFIRMED_MARKS, life_cycle.NEVER_CONFIRMED, life_cycle.SENSOR_SILENT)
        book.step(tracks.number[silent], now, life_cycle.DROPPED, why[silent])
        tracks.keep(~silent)
        tracks.predict(now)
        here = np.arange(first, stop)
        heard = np.isfinite(toa_s[here]).sum(axis=1) >= 2
        book.decision[here[~heard]] = TOO_FEW
        open_marks = _assign(tracks, here[heard], toa_s, altitude_m, conditions, book)
        for k in open_marks:
            pile = _pile_of(k, piles, recording.time_s, toa_s, conditions)
            found = _tried(pile, recording, toa_s, altitude_m, start)
            if found is None:
                continue
            tracks.add(*found, begun, len(pile))
            book.track[pile], book.decision[pile] = begun, STARTED
            piles.remove(pile)
            book.step(begun, now, life_cycle.TENTATIVE, life_cycle.BEGUN)
            book.confirm(begun, len(pile), now)
            begun += 1
    return _settled(book)


def _assign(
    tracks: RoughTracks, here: Ints, toa_s: Floats, altitude_m: Floats, conditions: Conditions, book: _Book
) -> list[int]:
    """Give the marks of an instant to tracks; return those that no track claims."""
    if not len(tracks.x) or not here.size:
        return here.tolist()
    cost = np.full((here.size, len(tracks.x)), np.inf)
    for i, k in enumerate(here):
        nis, log_det, dof = tracks.compare(toa_s[k], altitude_m[k], conditions)
        gate = gate_threshold(TAIL, dof)
        book.threshold[k], book.distance[k] = gate, nis.min()
        cost[i] = np.where(nis <= gate, nis + log_det, np.inf)
    chosen = most_likely_matching(np.where(np.isfinite(cost), ALWAYS - cost, -np.inf))
    left: list[int] = []
    gone: set[int] = set()
    for i, k in enumerate(here.tolist()):
        if chosen[i] < 0:
            if not np.isfinite(cost[i]).any():
                left.append(k)
            else:
                book.decision[k] = TWO_TRACKS
            continue
        mine = int(chosen[i])
        others = cost[i].copy()
        others[[mine, *(int(c) for c in chosen if c >= 0)]] = np.inf
        rival = int(others.argmin())
        if others[rival] - cost[i, mine] < NEARLY_ALIKE:
            book.rival[k] = tracks.number[rival]
            if tracks.apart(mine, rival) < ONE_EMITTER:
                older, younger = sorted((mine, rival), key=lambda t: (-tracks.marks[t], tracks.number[t]))
                book.same[int(tracks.number[younger])] = book.whose(int(tracks.number[older]))
                book.decision[k] = SAME_EMITTER
                if younger not in gone:
                    now = float(tracks.time_s[younger])
                    book.step(int(tracks.number[younger]), now, life_cycle.DROPPED, life_cycle.DUPLICATE)
                    tracks.marks[older] += tracks.marks[younger]
                gone.add(younger)
                mine = older
            else:
                book.decision[k] = TWO_TRACKS
                continue
        else:
            book.decision[k] = ASSIGNED
        book.track[k] = tracks.number[mine]
        tracks.update(mine, float(tracks.time_s[mine]), toa_s[k], altitude_m[k], conditions)
        book.confirm(int(tracks.number[mine]), int(tracks.marks[mine]), float(tracks.time_s[mine]))
    if gone:
        tracks.keep(~np.isin(np.arange(len(tracks.x)), list(gone)))
    return left


def _pile_of(k: int, piles: list[list[int]], time_s: Floats, toa_s: Floats, conditions: Conditions) -> list[int]:
    """Put a mark on the pile whose last mark it may follow most nearly, or on a new one."""
    best, least = None, np.inf
    for pile in list(piles):
        while pile and (time_s[k] - time_s[pile[0]] > PILE_S or len(pile) >= MOST_PILE):
            pile.pop(0)
        if not pile:
            piles.remove(pile)
            continue
        jump = _jump(k, pile, time_s, toa_s, conditions)
        if jump < least:
            best, least = pile, jump
    if best is None:
        best = []
        piles.append(best)
    best.append(k)
    return best


def _jump(k: int, pile: list[int], time_s: Floats, toa_s: Floats, conditions: Conditions) -> float:
    """Largest jump of a range difference that a mark shares with the pile, as a share of what may be; inf = none."""
    for last in reversed(pile):
        both = np.flatnonzero(np.isfinite(toa_s[k]) & np.isfinite(toa_s[last]))
        if both.size < 2:
            continue
        d = SPEED_OF_LIGHT_MPS * (toa_s[k, both] - toa_s[last, both])
        sigma = float(np.sqrt(2.0 * conditions.variance[both].max()))
        may = 2.0 * FASTEST_MPS * (time_s[k] - time_s[last]) + JUMP_SIGMA * 2.0 * sigma
        share = float(np.ptp(d)) / may
        return share if share <= 1.0 else np.inf
    return np.inf


def _tried(
    pile: list[int], recording: ToaMarks, toa_s: Floats, altitude_m: Floats, start: Start
) -> tuple[Floats, Floats, float] | None:
    """Try to start a track from a pile where that is worth it."""
    k = pile[-1]
    complete = np.isfinite(toa_s[k]).sum() + np.isfinite(altitude_m[k]) >= 4
    if not complete and len(pile) not in TRIED_AT:
        return None
    return start(recording.take(np.array(pile[-1:] if complete else pile)))


def _settled(book: _Book) -> Separation:
    """Number the emitters in the order of their first marks; what never was a track belongs to nobody."""
    number = np.array([book.whose(int(t)) if t >= 0 else -1 for t in book.track], np.int64)
    tracks, count = np.unique(number[number >= 0], return_counts=True)
    real = tracks[count >= CONFIRMED_MARKS]
    place = {int(t): i for i, t in enumerate(real)}
    emitter = np.array([place.get(int(t), -1) for t in number], np.int64)
    decision = np.where((number >= 0) & (emitter < 0), NEVER_CONFIRMED, book.decision)
    rival = np.array([place.get(book.whose(int(t)), -1) if t >= 0 else -1 for t in book.rival], np.int64)
    _, step_track, instant, state, reason = book.diary.joined()
    of_step = np.array([place.get(book.whose(int(t)), -1) for t in step_track], np.int64)
    steps = step_track + 1, of_step, instant, state, reason
    return Separation(emitter, decision, book.distance, book.threshold, rival, *steps)
