"""Results of the algorithms on plots as long tables (columns as the HTTP API fixes them)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.identification.instants import truth_at
from algorithms.identification.measures import dof_of
from algorithms.identification.outputs import (
    ACCEPTED,
    ALONE,
    DECISIONS,
    REASONS,
    REJECTED,
)
from algorithms.identification.registration import KINDS, UNITS
from algorithms.recording import PolarPlots
from algorithms.result import GivenColumn, Result, Table
from algorithms.toolbox.association.gate import gate_threshold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Pairs outside this gate and without a decision are not worth a row.
LISTED_TAIL = 1e-6


def tabulate(recording: PolarPlots, result: Result) -> dict[str, Table]:
    """Return the tables states, associations, decisions, tracks, registration and, with truth, errors."""
    tables = {
        "states": _states(recording, result),
        "associations": _associations(recording, result),
        "decisions": _decisions(recording, result),
        "registration": registration_table(recording.radars, result),
    }
    if recording.has_truth:
        tables["errors"] = _errors(recording, result)
    return tables


def trial_column(trial: Ints, lanes: int) -> Floats:
    """Trial numbers; empty for an uploaded recording, which is no trial."""
    return np.full(trial.size, np.nan) if lanes == 1 else trial.astype(float)


def _one_of_each_group(result: Result) -> tuple[Ints, Ints]:
    """(mark, trial) of the plot that gave each group its number, in the order of trials and rows."""
    group, row = result.arrays["group"], result.arrays["row"]
    trial, mark = np.nonzero((group == row[:, None]).T)
    return mark, trial


def _states(recording: PolarPlots, result: Result) -> Table:
    """Fused positions: one row for each set of plots that are one target."""
    a = result.arrays
    mark, trial = _one_of_each_group(result)
    xx, yy, xy = a["fused_covariance_m2"][mark, :, trial].reshape(-1, 3).T
    used = [_used(recording, a["group"], int(k), int(t)) for k, t in zip(mark, trial, strict=True)]
    count = np.array([len(u) for u in used], np.int64)
    return Table(
        {
            "trial": trial_column(trial, a["group"].shape[1]),
            "track": np.full(mark.size, np.nan),
            "time_s": a["instant_s"][mark],
            "east_m": a["fused_m"][mark, 0, trial],
            "north_m": a["fused_m"][mark, 1, trial],
            "up_m": np.full(mark.size, np.nan),
            "sigma_east_m": np.sqrt(xx),
            "sigma_north_m": np.sqrt(yy),
            "sigma_up_m": np.full(mark.size, np.nan),
            "drms_m": np.sqrt(xx + yy),
            "nis": a["statistic"][mark, trial],
            "dof": dof_of(result) * (np.maximum(count, 2) - 1),
            "status": ["fused"] * mark.size,
            "used": [" ".join(u) or None for u in used],
            "row": a["row"][mark],
            "target": [recording.targets[i] or None for i in recording.target[mark]],
            "covariance_east_north_m2": xy,
        }
    )


def _used(recording: PolarPlots, group: Ints, mark: int, trial: int) -> list[str]:
    """Names of the radars whose plots are in the group."""
    members = np.flatnonzero(group[:, trial] == group[mark, trial])
    return [recording.radars[r] for r in np.unique(recording.radar[members])]


def _associations(recording: PolarPlots, result: Result) -> Table:
    """Pairs that were decided, and those that could belong together."""
    a = result.arrays
    decision, statistic = a["pair_decision"], a["pair_statistic"]
    worth = (statistic <= gate_threshold(LISTED_TAIL, dof_of(result))) | (decision != REJECTED)
    trial, pair = np.nonzero(worth.T)
    place = {int(row): k for k, row in enumerate(a["row"])}
    rows = a["pair_row"][pair]
    first, second = (np.array([place[int(r)] for r in rows[:, s]], np.int64) for s in (0, 1))
    codes = decision[pair, trial]
    return Table(
        {
            "trial": trial_column(trial, decision.shape[1]),
            "time_s": recording.time_s[first],
            "row_1": rows[:, 0],
            "row_2": rows[:, 1],
            "statistic": statistic[pair, trial],
            "threshold": np.full(pair.size, a["threshold"][0]),
            "probability": a["pair_probability"][pair, trial],
            "decision": [DECISIONS[i] for i in codes],
            "radar_1": [recording.radars[i] or None for i in recording.radar[first]],
            "radar_2": [recording.radars[i] or None for i in recording.radar[second]],
            "look": a["pair_frame"][pair],
            "target_1": _target_names(recording, first),
            "target_2": _target_names(recording, second),
        }
    )


def _target_names(recording: PolarPlots, marks: Ints) -> list[str | None]:
    return [recording.targets[i] or None for i in recording.target[marks]]


def _decisions(recording: PolarPlots, result: Result) -> Table:
    """List every plot that was not accepted: what was decided, against which threshold, and why."""
    a = result.arrays
    decision = a["decision"]
    trial, mark = np.nonzero((decision != ACCEPTED).T)
    codes = decision[mark, trial]
    alone = a["alone_probability"][mark, trial]
    own = a["probability"][mark, trial]
    columns: dict[str, GivenColumn] = {
        "track": np.full(mark.size, np.nan),
        "row": a["row"][mark],
        "time_s": recording.time_s[mark],
        "decision": [DECISIONS[i] for i in codes],
        "distance": np.sqrt(a["statistic"][mark, trial]),
        "threshold": np.full(mark.size, np.sqrt(a["threshold"][0])),
        "probability": np.where(codes == ALONE, alone, own),
        "reason": [REASONS[i] or None for i in a["reason"][mark, trial].tolist()],
        "target": _target_names(recording, mark),
        "radar": [recording.radars[i] or None for i in recording.radar[mark]],
        "look": a["frame"][mark],
        "trial": trial_column(trial, decision.shape[1]),
    }
    return Table(columns)


def _errors(recording: PolarPlots, result: Result) -> Table:
    a = result.arrays
    mark, trial = _one_of_each_group(result)
    error = a["fused_m"][mark, :, trial].reshape(-1, 2) - truth_at(recording, a["instant_s"])[mark]
    keep = np.flatnonzero(np.isfinite(error).all(axis=1))
    none = np.full(keep.size, np.nan)
    return Table(
        {
            "trial": trial_column(trial, a["group"].shape[1])[keep],
            "track": none,
            "target": [recording.targets[i] or None for i in recording.target[mark[keep]]],
            "time_s": a["instant_s"][mark[keep]],
            "error_east_m": error[keep, 0],
            "error_north_m": error[keep, 1],
            "error_up_m": none,
            "error_horizontal_m": np.hypot(error[keep, 0], error[keep, 1]),
            "error_velocity_mps": none,
            "row": a["row"][mark[keep]],
        }
    )


def registration_table(radars: tuple[str, ...], result: Result) -> Table:
    """What may be wrong between the radars: every explanation with its size, the best first."""
    rows: list[tuple[Any, ...]] = []
    named = (*radars, "others")
    for kind, radar, against, *numbers in result.arrays["registration"].tolist():
        values, sds, (statistic, tail) = numbers[:2], numbers[2:4], numbers[4:]
        shift = KINDS[int(kind)] == "shift"
        for axis in range(2 if shift else 1):
            word = ("east", "north")[axis] if shift else KINDS[int(kind)]
            rows.append(
                (
                    named[int(radar)],
                    named[int(against)],
                    word,
                    values[axis],
                    sds[axis],
                    UNITS[int(kind)],
                    statistic,
                    tail,
                )
            )
    names = ("radar", "against", "offset", "value", "sd", "unit", "statistic", "tail")
    texts = {"radar", "against", "offset", "unit"}
    columns = list(zip(*rows, strict=True)) if rows else [()] * len(names)
    return Table({n: list(c) if n in texts else np.array(c, float) for n, c in zip(names, columns, strict=True)})
