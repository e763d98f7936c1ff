"""When targets send: regularly, irregularly, or when ground interrogators ask; never in a gap.

These instants belong to the scenario and not to a trial: they come from a seed of their own, and the streams of the
targets are apart, so that a further target leaves the instants of the others as they were.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import ParameterError
from algorithms.spec import Parameters, parameter

Floats = NDArray[np.float64]

MAX_MARKS = 100_000


class Interrogator(Parameters):
    """A ground station whose turning antenna asks a target several times in each pass, so that marks come in bursts."""

    period_s: float = parameter(4.0, title="Period", unit="s", group="timing", ge=1e-3, le=3600)
    """Time of one turn."""
    phase_s: float = parameter(0.0, title="First pass", unit="s", group="timing", ge=0, le=3600)
    """When the antenna first looks at the targets."""
    replies: int = parameter(8, title="Interrogations a pass", group="timing", ge=1, le=100)
    """How often it asks while it looks."""
    interval_s: float = parameter(0.004, title="Between them", unit="s", group="timing", ge=1e-6, le=10)
    """Time from one interrogation to the next."""
    reply_probability: float = parameter(0.9, title="Reply probability", unit="1", group="timing", ge=0, le=1)
    """Share of interrogations that a target answers."""


class Gap(Parameters):
    """An interval without marks, start_s <= t < stop_s."""

    start_s: float = parameter(title="From", unit="s", group="timing", ge=0, le=1e6)
    """First instant without marks."""
    stop_s: float = parameter(title="To", unit="s", group="timing", gt=0, le=1e6)
    """First instant with marks again."""


def timing_stream(seed: int, target: int) -> np.random.Generator:
    """Return a target's stream; the first target's is that of the seed itself."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(target,) if target else ()))


def regular_times(begin_s: float, end_s: float, period_s: float) -> Floats:
    """Every `period_s` from the beginning to the end, both included."""
    count = int(np.floor((end_s - begin_s) / period_s + 1e-9)) + 1
    _refuse_too_many(count, "/period_s")
    return np.asarray(begin_s + period_s * np.arange(count), np.float64)


def irregular_times(
    begin_s: float, end_s: float, minimum_s: float, mean_extra_s: float, rng: np.random.Generator
) -> Floats:
    """Intervals of `minimum_s` and an exponential remainder of mean `mean_extra_s`, added up from the beginning."""
    if minimum_s + mean_extra_s < 1e-6:
        raise ParameterError(
            "The intervals between marks are zero.", pointer="/minimum_interval_s", remedy="Make one of the two larger."
        )
    mean = minimum_s + mean_extra_s
    _refuse_too_many(int((end_s - begin_s) / mean), "/mean_extra_interval_s")
    # Far more than are needed, drawn one after another: the first ones do not depend on how many follow.
    count = int(2 * (end_s - begin_s) / mean) + 100
    times = begin_s + np.cumsum(minimum_s + rng.exponential(mean_extra_s, count))
    return times[times < end_s]


def interrogated_times(
    begin_s: float, end_s: float, interrogators: Sequence[Interrogator], rng: np.random.Generator
) -> Floats:
    """Instants at which a target answers its interrogators."""
    found = []
    for i, one in enumerate(interrogators):
        passes = int(max(end_s - one.phase_s, -one.period_s) / one.period_s) + 1
        _refuse_too_many(passes * one.replies, f"/interrogators/{i}/period_s")
        asked = one.phase_s + one.period_s * np.arange(passes)[:, None] + one.interval_s * np.arange(one.replies)
        answered = rng.random(asked.shape) < one.reply_probability
        found.append(asked[answered & (asked >= begin_s) & (asked <= end_s)])
    times = np.sort(np.concatenate(found)) if found else np.empty(0)
    _refuse_too_many(times.size, "/interrogators")
    return times


def outside_gaps(times_s: Floats, gaps: Sequence[Gap]) -> Floats:
    """Leave out what lies in a gap."""
    keep = np.ones(times_s.size, bool)
    for i, gap in enumerate(gaps):
        if gap.stop_s <= gap.start_s:
            raise ParameterError(
                f"Gap {i + 1} ends at {gap.stop_s:g} s, not after its beginning at {gap.start_s:g} s.",
                pointer=f"/gaps/{i}/stop_s",
                remedy="Exchange the two, or remove the gap.",
            )
        keep &= (times_s < gap.start_s) | (times_s >= gap.stop_s)
    return times_s[keep]


def _refuse_too_many(count: int, pointer: str) -> None:
    if count > MAX_MARKS:
        raise ParameterError(
            f"This would make {count:,} marks of one target; a recording takes at most {MAX_MARKS:,}.",
            pointer=pointer,
            remedy="Make the observation shorter or the marks rarer.",
        )
