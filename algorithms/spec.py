"""What an algorithm and a scenario declare about themselves; found by `algorithms.registry`.

To add an algorithm, write one module in a family's folder with a constant `ALGORITHM`:

1. `Parameters` is a subclass of `algorithms.spec.Parameters` (frozen, no unknown fields, no NaN). Every field has a
   default, bounds, and a docstring under it; `parameter(...)` adds unit, symbol and group. This one declaration is
   the validation, the OpenAPI, the browser's form and the documentation.
2. `run(recording, parameters, context) -> Result` works on a block of trials, gives exactly the declared outputs,
   and never reads a file, a clock or a global.
3. It calls `context.progress` and, at least every 0.3 s, `context.check_cancelled`.
4. `tabulate` and `measure` turn the result of one recording into long tables and metrics.
5. `references` name keys of `algorithms.references`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from algorithms.recording import Kind, Recording
from algorithms.result import Metric, Output, Result, Table
from algorithms.scores import Floats, Scores


class Parameters(BaseModel):
    """Base of every algorithm's and scenario's parameters."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    @classmethod
    def schema_for_forms(cls) -> dict[str, Any]:
        """JSON schema with a title for every field; pydantic leaves it out beside a reference to another model."""
        schema = cls.model_json_schema()
        for name, field in schema.get("properties", {}).items():
            title = cls.model_fields[name].title
            if title is not None:
                field["title"] = title
        return schema


def parameter(
    default: Any = ...,
    *,
    title: str,
    unit: str = "",
    symbol: str = "",
    group: str = "measurement",
    advanced: bool = False,
    from_site: str = "",
    fallback: Any = None,
    choices: Mapping[str, str] | None = None,
    labels_from: str = "",
    row_sum: float | None = None,
    **bounds: Any,
) -> Any:
    """Declare one parameter: a pydantic field whose JSON schema carries what a form needs.

    `group` is one of measurement, motion, association, start, output. `from_site` names the site's field that is
    the default where the run gives None; `fallback` is used (and shown as placeholder) where the site has none.
    `choices` maps each allowed word to its meaning. A square matrix takes the names of its rows and columns from the
    list that is the parameter `labels_from`; each of its rows must sum to `row_sum`.
    """
    extra: dict[str, Any] = {"unit": unit, "symbol": symbol, "group": group, "advanced": advanced}
    if from_site:
        extra["from_site"] = from_site
    if fallback is not None:
        extra["fallback"] = fallback
    if choices is not None:
        extra["choices"] = dict(choices)
    if labels_from:
        extra["labels_from"] = labels_from
    if row_sum is not None:
        extra["row_sum"] = row_sum
    return Field(default, title=title, json_schema_extra=extra, **bounds)


@dataclass(frozen=True)
class Reference:
    """Where a method comes from: a key of `algorithms.references` and the place in it."""

    key: str
    place: str = ""


def trial_stream(seed: int, trial: int, purpose: int = 0) -> np.random.Generator:
    """Random stream of one trial for one purpose: it depends on nothing else.

    Purpose 0 is the algorithm's own (a start drawn around the truth); a scenario numbers its kinds of draws from 1,
    so that switching one effect on leaves the draws of the others as they were.
    """
    return np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=(trial, purpose)))


class RunContext(Protocol):
    """What a run may ask of its surroundings."""

    def random(self, lane: int) -> np.random.Generator:
        """Random stream of the trial in a lane of the recording; the same for any cut, worker or machine."""

    def progress(self, share: float) -> None:
        """Report the finished share (0 to 1) of this call."""

    def check_cancelled(self) -> None:
        """Raise RunCancelled where the user has cancelled."""


@dataclass(frozen=True)
class LocalContext:
    """A context without a server: streams from `seed`, no progress, never cancelled."""

    seed: int = 0
    first_trial: int = 0
    """Trial in the recording's lane 0."""

    def random(self, lane: int) -> np.random.Generator:
        """Random stream of the trial in a lane, apart from the ones that draw its measurements."""
        return trial_stream(self.seed, self.first_trial + lane)

    def progress(self, share: float) -> None:
        """Do nothing."""

    def check_cancelled(self) -> None:
        """Do nothing."""


@dataclass(frozen=True)
class PartOfRun:
    """The context of one of several passes: its progress is the part of the whole between two shares."""

    whole: RunContext
    first: float
    last: float

    def random(self, lane: int) -> np.random.Generator:
        """Random stream of the trial in a lane: the whole's."""
        return self.whole.random(lane)

    def progress(self, share: float) -> None:
        """Report the finished share of this pass."""
        self.whole.progress(self.first + (self.last - self.first) * share)

    def check_cancelled(self) -> None:
        """Raise RunCancelled where the user has cancelled."""
        self.whole.check_cancelled()


Run = Callable[[Any, Any, RunContext], Result]


@dataclass(frozen=True)
class Algorithm:
    """A named method: what it takes, its parameters, what it gives, and how it is run."""

    name: str
    title: str
    summary: str
    family: str
    takes: tuple[Kind, ...]
    parameters: type[Parameters]
    outputs: tuple[Output, ...]
    charts: tuple[str, ...]
    references: tuple[Reference, ...]
    run: Run
    tabulate: Callable[[Any, Result], dict[str, Table]]
    measure: Callable[[Any, Result], list[Metric]]
    score: Callable[[Any, Any, RunContext], Scores] | None = None
    """(simulated recording with truth, parameters, context) -> what is added up over trials; None = no Monte Carlo."""
    bound: Callable[[Any, Any], Floats | None] | None = None
    """(simulated recording, parameters) -> (T,) m, lower bound of the rms horizontal error at each instant of `score`;
    None = none."""
    check: Callable[[Any, Callable[[], Recording]], None] | None = None
    """(parameters, how to get the recording) -> InputError where the two cannot go together, before a run is queued;
    the recording is got only where parameters leave it open. None = parameters alone decide."""
    recommended: bool = False
    """The one of its family to begin with; the others are the paper's, its rivals, and for comparison."""


@dataclass(frozen=True)
class Leg:
    """A named interval of a scenario, start_s <= t < stop_s, whose metrics are given apart."""

    name: str
    start_s: float
    stop_s: float


@dataclass(frozen=True)
class Scenario:
    """A preset from which recordings are simulated: trials side by side, or one."""

    name: str
    title: str
    summary: str
    family: str
    kind: Kind
    parameters: type[Parameters]
    simulate: Callable[[Any, tuple[int, ...], int], Recording]
    """(parameters, trials, seed) -> Recording whose trial axis is as long as `trials`, with truth and site.

    Times, targets and truth are the same for all trials; everything drawn for a trial comes from `trial_stream`. With
    no trials at all only instants and truth are made, which checks the parameters completely in milliseconds.
    """
    legs: Callable[[Any], tuple[Leg, ...]] = lambda _: ()
    """Named intervals of the scenario with these parameters."""
    references: tuple[Reference, ...] = ()
