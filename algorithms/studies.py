"""What a study declares: a recipe of one run that reproduces a figure, table or claim of a paper, and judges it.

A study is data and one function. `judge` looks at the finished run's tables and says of every claim what our number is
and whether the paper's statement holds: *reproduced*, *partly*, *not* reproduced, or *shown* where there is no number
to hold it against.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from algorithms.result import Table
from algorithms.spec import Reference
from algorithms.texts import Texts

Word = Literal["reproduced", "partly", "not", "shown"]


@dataclass(frozen=True)
class StudyEntry:
    """An algorithm of the run."""

    name: str
    label: str
    parameters: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Claim:
    """What the paper says: in which figure or table, the statement in our words, and its number as printed."""

    figure: str
    claim: str
    paper: str


@dataclass(frozen=True)
class Verdict:
    """What we found about a claim: our number with its interval, the word, and the reason in a sentence."""

    claim: Claim
    value: float | None
    unit: str
    verdict: Word
    reason: str
    ci95_low: float | None = None
    ci95_high: float | None = None


@dataclass(frozen=True)
class Found:
    """A number of a finished run with its 95 % interval, NaN where there is none."""

    value: float
    low: float
    high: float


class StudyRun:
    """Tables of a finished run, as a judge asks them."""

    def __init__(self, tables: Mapping[str, Table]) -> None:
        self._tables = tables

    def metric(self, metric: str, label: str, segment: str = "", **swept: float) -> Found:
        """One number of the table `metrics`."""
        return self._metric({"metric": metric, "label": label, "segment": segment, "target": ""}, swept)

    def metric_of_target(self, metric: str, label: str, target: str, **swept: float) -> Found:
        """One number of the table `metrics`, of one target."""
        return self._metric({"metric": metric, "label": label, "segment": "", "target": target}, swept)

    def _metric(self, same: Mapping[str, str], swept: Mapping[str, float]) -> Found:
        row = self._row("metrics", same, swept)
        return Found(row["value"], row["ci95_low"], row["ci95_high"])

    def ratio(self, metric: str, label: str, against: str, segment: str = "", **swept: float) -> Found:
        """How many times larger a metric of `label` is than that of `against`, on the same draws."""
        same = {"metric": metric, "segment": segment, "target": ""}
        row = self._row("comparisons", same | {"label": label, "against": against}, swept, missing_ok=True)
        if row is not None:
            return Found(row["ratio"], row["ratio_low"], row["ratio_high"])
        row = self._row("comparisons", same | {"label": against, "against": label}, swept)
        return Found(1 / row["ratio"], 1 / row["ratio_high"], 1 / row["ratio_low"])

    def curve(self, column: str, label: str, **swept: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Instants and values of one curve."""
        table = self._tables["curves"]
        rows = self._rows(table, {"label": label}, swept)
        return np.asarray(table.columns["time_s"])[rows], np.asarray(table.columns[column])[rows]

    def _rows(self, table: Table, same: Mapping[str, str], swept: Mapping[str, float]) -> NDArray[np.int64]:
        keep = np.ones(len(table), np.bool_)
        for name, text in same.items():
            keep &= Texts.of(table.columns[name]).are(text)
        for name, number in swept.items():
            # Where several algorithms sweep a parameter of one name, each has a column of its own.
            own = f"{same.get('label')}.{name}"
            column = own if own in table.names else next(c for c in table.names if c.rpartition(".")[2] == name)
            keep &= np.asarray(table.columns[column], float) == number
        return np.flatnonzero(keep)

    def _row(self, name: str, same: Mapping[str, str], swept: Mapping[str, float], *, missing_ok: bool = False) -> Any:
        table = self._tables[name]
        rows = self._rows(table, same, swept)
        if rows.size == 0 and missing_ok:
            return None
        if rows.size != 1:
            raise LookupError(f"{rows.size} rows of {name} are {dict(same)} {dict(swept)}")
        row = dict(zip(table.names, next(iter(table.rows(int(rows[0]), int(rows[0]) + 1))), strict=True))
        return {key: np.nan if value is None else value for key, value in row.items()}


@dataclass(frozen=True)
class Study:
    """A recipe: which run to make, what the paper claims of it, and how the result is judged.

    Attributes
    ----------
    item : figure, table or section of the paper
    sweep : as in a run: `scenario.<name>` or `<label>.<name>` with its values
    judge : gives a verdict for every claim, in their order
    """

    name: str
    title: str
    summary: str
    family: str
    paper: Reference
    item: str
    scenario: str
    entries: tuple[StudyEntry, ...]
    claims: tuple[Claim, ...]
    judge: Callable[[StudyRun], Sequence[Verdict]]
    scenario_parameters: Mapping[str, Any] = field(default_factory=dict)
    sweep: Mapping[str, Sequence[Any]] = field(default_factory=dict)
    trials: int = 300
    seed: int = 0
