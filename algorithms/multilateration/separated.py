"""Run a filter over a recording whose emitters have no addresses: tell them apart first, then filter each by itself.

Marks with an address keep it. What nobody can be given has no estimate, and the table `decisions` says why.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.multilateration import emitters
from algorithms.multilateration.conditions import conditions_of, toa_of
from algorithms.multilateration.emitters import Separation, separate
from algorithms.multilateration.lanes import AMBIGUOUS
from algorithms.multilateration.parameters import StartParameters
from algorithms.recording import ToaMarks
from algorithms.result import Note, Result, Setting, Table
from algorithms.spec import LocalContext, PartOfRun, RunContext
from algorithms.texts import Texts
from algorithms.toolbox.kernels.symmetric import unpack
from algorithms.toolbox.tracks import life_cycle

Floats = NDArray[np.float64]

WORDS = (
    "",
    "belongs to this emitter alone",
    "an emitter was begun with it",
    "no emitter claims it, and none could be begun with it",
    "two emitters claim it nearly alike",
    "fewer than two receptions say nothing of the emitter",
    "what it began gathered too few marks to be an emitter",
    "two tracks claimed it and turned out to be one emitter",
)
"""Of `emitters.DECISIONS`."""

LIFE_WORDS = (
    "enough marks to follow it",
    "enough marks to confirm it",
    "",
    "",
    "",
    "silent before it was confirmed",
    "silent for a minute",
    "the same as an older track",
)
"""Of `life_cycle.REASONS`, whose words are those of plots; empty where marks, which come at no period, give no such."""


def of_one_emitter(recording: ToaMarks) -> dict[str, NDArray[Any]]:
    """Arrays of a recording whose marks were not told apart, read only: of a long one they would take 32 MB."""
    marks = len(recording)
    nobody, nothing = np.broadcast_to(np.int64(-1), marks), np.broadcast_to(np.nan, marks)
    none, never = np.empty(0, np.int64), np.empty(0)
    decision = np.zeros(marks, np.int64)
    return _arrays(Separation(nobody, decision, nothing, nothing, nobody, none, none, never, none, none))


def _arrays(found: Separation) -> dict[str, NDArray[Any]]:
    return {
        "emitter": found.emitter,
        "emitter_decision": found.decision.astype(np.int8),
        "emitter_distance": found.distance,
        "emitter_threshold": found.threshold,
        "emitter_rival": found.rival,
        "event_track": found.step_track,
        "event_emitter": found.step_emitter,
        "event_time_s": found.step_time_s,
        "event_state": found.step_state.astype(np.int8),
        "event_reason": found.step_reason.astype(np.int8),
    }


def run_separated(
    recording: ToaMarks,
    parameters: StartParameters,
    context: RunContext,
    filtered: Callable[[ToaMarks, RunContext], Result],
    *,
    altitude: bool,
) -> Result:
    """Tell the emitters without a name apart, then filter the marks of each."""
    nameless = recording.targets.index("")
    rows = recording.rows_of(nameless)
    part = recording.take(rows)
    conditions = conditions_of(recording, parameters, with_altitude=altitude)
    toa = toa_of(part, conditions)[:, :, 0]
    heights = part.altitude_m[:, 0] if altitude else np.full(rows.size, np.nan)

    def start(pile: ToaMarks) -> tuple[Floats, Floats, float] | None:
        arrays = filtered(pile, LocalContext()).arrays
        if not np.isfinite(arrays["state"][-1, 0, 0]) or arrays["status"][-1, 0] == AMBIGUOUS:
            return None
        # The start's own state: a restart within the pile is a start too.
        return arrays["state"][-1, :, 0], unpack(arrays["covariance"][-1, :, 0]), float(pile.time_s[-1])

    found = _over(recording, rows, separate(part, toa, heights, conditions, start, PartOfRun(context, 0.0, 0.5)))
    result = filtered(_told_apart(recording, found, nameless), PartOfRun(context, 0.5, 1.0))
    arrays = dict(result.arrays) | {"target": recording.target} | _arrays(found)
    count, lost = int(found.emitter.max(initial=-1)) + 1, int((found.emitter[rows] < 0).sum())
    notes = (
        *result.notes,
        Note("emitters", f"{count} emitters were told apart in {rows.size} marks without an address.", count),
        Note("marks_of_nobody", f"{lost} marks could be given to no emitter; the decisions say why.", lost),
    )
    settings = dict(result.settings) | {"emitters": Setting("separate", "run")}
    return Result(arrays, notes, settings)


def _over(recording: ToaMarks, rows: NDArray[np.int64], part: Separation) -> Separation:
    """What was found of some marks, of all of them."""
    whole = {name: value.copy() for name, value in of_one_emitter(recording).items()}
    for name, value in _arrays(part).items():
        if name.startswith("emitter"):
            whole[name][rows] = value
    return replace(
        part,
        emitter=whole["emitter"],
        decision=whole["emitter_decision"].astype(np.int64),
        distance=whole["emitter_distance"],
        threshold=whole["emitter_threshold"],
        rival=whole["emitter_rival"],
    )


def _told_apart(recording: ToaMarks, found: Separation, nameless: int) -> ToaMarks:
    """The recording with a target for each emitter; the marks of nobody say nothing."""
    target, targets = _targets(recording, found.emitter)
    nobody = (recording.target == nameless) & (found.emitter < 0)
    return replace(
        recording,
        target=target,
        targets=targets,
        toa_s=np.where(nobody[:, None, None], np.nan, recording.toa_s),
        altitude_m=np.where(nobody[:, None], np.nan, recording.altitude_m),
    )


def _targets(recording: ToaMarks, emitter: NDArray[np.int64]) -> tuple[NDArray[np.int64], tuple[str, ...]]:
    names = tuple(f"emitter {i + 1}" for i in range(int(emitter.max(initial=-1)) + 1))
    return np.where(emitter >= 0, emitter + len(recording.targets), recording.target), (*recording.targets, *names)


def as_told_apart(recording: ToaMarks, result: Result) -> ToaMarks:
    """The recording with the targets that the run found; as it is where it looked for none."""
    emitter = result.arrays.get("emitter")
    if emitter is None or not result.arrays["emitter_decision"].any():
        return recording
    target, targets = _targets(recording, emitter)
    return replace(recording, target=target, targets=targets)


def emitter_decisions(recording: ToaMarks, result: Result) -> Table | None:
    """Every decision about whose a mark is; None where none was made."""
    a = result.arrays
    if "emitter" not in a or not a["emitter_decision"].any():
        return None
    rows = np.flatnonzero(a["emitter_decision"])
    _, targets = _targets(recording, a["emitter"])
    own = len(recording.targets)
    code = a["emitter_decision"][rows].astype(np.int64)

    def named(places: NDArray[np.int64]) -> list[str | None]:
        return [targets[own + i] if i >= 0 else None for i in places.tolist()]

    return Table(
        {
            "row": recording.row[rows],
            "time_s": recording.time_s[rows],
            "emitter": named(a["emitter"][rows]),
            "decision": Texts.coded(code, emitters.DECISIONS),
            "distance": np.sqrt(a["emitter_distance"][rows]),
            "threshold": np.sqrt(a["emitter_threshold"][rows]),
            "rival": named(a["emitter_rival"][rows]),
            "reason": Texts.coded(code, WORDS),
        }
    )


def emitter_lives(recording: ToaMarks, result: Result) -> Table:
    """The steps in the lives of the tracks that emitters are told apart by, with their reasons."""
    a = result.arrays
    _, targets = _targets(recording, a["emitter"])
    own = len(recording.targets)
    return Table(
        {
            "track": a["event_track"].astype(float),
            "emitter": [targets[own + i] if i >= 0 else None for i in a["event_emitter"].tolist()],
            "time_s": a["event_time_s"],
            "status": Texts.coded(a["event_state"].astype(np.int64), life_cycle.STATES),
            "reason": Texts.coded(a["event_reason"].astype(np.int64), LIFE_WORDS),
        }
    )


def with_reasons_of_nobody(decisions: Table, recording: ToaMarks, result: Result) -> Table:
    """The table `decisions`, in which marks of nobody say why they are: the filter saw none of their receptions."""
    decided = result.arrays.get("emitter_decision")
    if decided is None or not decided.any():
        return decisions
    lost = np.flatnonzero((decided > 0) & (result.arrays["emitter"] < 0))
    why = dict(zip(recording.row[lost].tolist(), decided[lost].tolist(), strict=True))
    rows = np.asarray(decisions.columns["row"]).tolist()
    columns = dict(decisions.columns)
    for name, words in (("reason", WORDS), ("code", emitters.DECISIONS)):
        texts = [words[why[row]] if row in why else text for row, text in zip(rows, columns[name], strict=True)]
        columns[name] = Texts.of(texts)
    return Table(columns)
