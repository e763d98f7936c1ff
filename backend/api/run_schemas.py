"""Runs as the API takes and gives them."""

from __future__ import annotations

import datetime as dt
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, AwareDatetime, BaseModel, ConfigDict, Field

from backend.api.algorithms import ReferenceOut
from backend.db import runs as stored
from backend.http.pagination import PageQuery

State = Literal["queued", "running", "succeeded", "failed", "cancelled"]

MAX_ENTRIES = 20
MAX_TAGS = 20
MAX_TRIALS = 1_000_000
# What a list keeps of a summary: the first of these that a run has stands for it in the page. All numbers of fifty
# runs would be nine tenths of the answer.
LISTED_METRICS = ("rms_horizontal_m", "rms_position_m", "claimed_horizontal_m", "nis")


def _readable(text: str) -> str:
    if not text.isprintable():
        raise ValueError("control characters are not allowed here")
    return text


def _visible(text: str) -> str:
    if not text.strip():
        raise ValueError("give at least one visible character")
    return _readable(text)


def _member_name(text: str) -> str:
    # Labels name the members of the result file, beside its big tables and the measurements it worked on.
    if "/" in text or "\\" in text or text in ("tables", "recording", ".", ".."):
        raise ValueError("a label may not contain a slash or a backslash, and may not be `tables` or `recording`")
    return _visible(text)


Words = Annotated[str, Field(max_length=200), AfterValidator(_readable)]
Label = Annotated[str, Field(min_length=1, max_length=80), AfterValidator(_member_name)]
Tag = Annotated[str, Field(min_length=1, max_length=80), AfterValidator(_visible)]
Id = Annotated[str, Field(max_length=64)]


class _In(BaseModel):
    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, allow_inf_nan=False)


class _Out(BaseModel):
    model_config = ConfigDict(use_attribute_docstrings=True)


class EntryIn(_In):
    """One algorithm of a run."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    """Name in the catalogue of algorithms."""
    label: Label | None = None
    """What charts, tables and metrics call it; unique in the run; default: the name."""
    parameters: dict[str, Any] = {}
    """What differs from the defaults; see the algorithm's `parameters_schema`."""


class ScenarioIn(_In):
    """A scenario to simulate."""

    preset: Annotated[str, Field(min_length=1, max_length=80)]
    """Name in the catalogue of scenarios."""
    parameters: dict[str, Any] = {}
    """What differs from the preset; see its `parameters_schema`."""


class RunIn(_In):
    """What is to be computed: algorithms and one source."""

    algorithms: Annotated[list[EntryIn], Field(max_length=MAX_ENTRIES)] = []
    recording_id: Id | None = None
    """The recording to work on."""
    recording_ids: Annotated[list[Id], Field(max_length=64)] | None = None
    """Recordings of radars to work on as one, each with its site; the frame is that of the first."""
    scenario: ScenarioIn | None = None
    """The scenario to simulate."""
    study: Annotated[str, Field(max_length=80)] | None = None
    """A recipe of the catalogue of studies."""
    sweep: Annotated[dict[str, Annotated[list[Any], Field(min_length=1)]], Field(max_length=10)] | None = None
    """Parameters to vary: `<label>.<parameter>` or `scenario.<parameter>` with its values; every combination is run."""
    trials: Annotated[int, Field(ge=1, le=MAX_TRIALS)] | None = None
    """Simulated trials, 100 where nothing is said; a recording is one."""
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    """Seed of the random streams; default 0."""
    label: Words = ""
    """What the list of runs shows."""
    tags: Annotated[list[Tag], Field(max_length=MAX_TAGS)] = []


class RunPatch(_In):
    """What may change after the start: how the run is called."""

    label: Words | None = None
    tags: Annotated[list[Tag], Field(max_length=MAX_TAGS)] | None = None


class Progress(_Out):
    """How far a run is: rows of the recording times algorithms, or trials times cells of the scenario."""

    done: int
    total: int
    eta_s: float | None
    """Estimated seconds to go; null where there is no pace yet."""


class EntryOut(_Out):
    """One algorithm of a run, with the parameters that were given."""

    name: str
    label: str
    parameters: dict[str, Any]


class NoteOut(_Out):
    """Something to know about how a result came about."""

    code: str
    detail: str
    count: int


class SettingOut(_Out):
    """A parameter as it was used."""

    value: Any
    source: str
    """Where the value came from: run, site, profile or default."""


class MetricOut(_Out):
    """A headline number."""

    value: float | None
    ci95: tuple[float, float] | None
    """95 % interval, null where it is not known."""
    unit: str


class RunItem(_Out):
    """A run in a list."""

    id: str
    state: State
    queue_position: int | None = None
    """Queued runs before this one; null where it does not wait, and in lists."""
    progress: Progress
    algorithms: list[EntryOut]
    source: dict[str, Any]
    seed: int
    trials: int
    label: str
    tags: list[str]
    created_at: dt.datetime
    started_at: dt.datetime | None
    finished_at: dt.datetime | None
    error: dict[str, Any] | None
    """Why the run failed: code, detail, remedy, pointer, label."""
    summary: dict[str, dict[str, MetricOut]] | None
    """Headline: {metric: {label: value}}; in lists only `rms_horizontal_m`, `rms_position_m`, `claimed_horizontal_m`
    and `nis`."""
    software: dict[str, Any] | None
    result_sha256: str | None
    size_bytes: int | None
    """Disk that the result file takes; null where there is none."""


class RunOut(RunItem):
    """A run with all that was used for it."""

    settings: dict[str, dict[str, SettingOut]] | None
    """By label: every parameter as it was used."""
    notes: dict[str, list[NoteOut]] | None
    """By label: what must be known about the result."""
    seconds: dict[str, float] | None
    """By label: time of the computation."""
    references: list[ReferenceOut] | None
    """What the algorithms of the run cite, each once."""

    @classmethod
    def of(
        cls,
        run: stored.Run,
        *,
        at: dt.datetime,
        size_bytes: int | None,
        queue_position: int | None = None,
        references: list[ReferenceOut] | None = None,
    ) -> Self:
        """Show a stored run."""
        entries = run.entries
        return cls(
            **item_of(run, at=at, size_bytes=size_bytes) | {"queue_position": queue_position},
            settings=None if entries is None else {e["label"]: e["settings"] for e in entries},
            notes=None if entries is None else {e["label"]: e["notes"] for e in entries},
            seconds=None if entries is None else {e["label"]: e["seconds"] for e in entries},
            references=references,
        )


def item_of(run: stored.Run, *, at: dt.datetime, size_bytes: int | None) -> dict[str, Any]:
    """Return the fields of a `RunItem` as they are stored: a list that checks each number again takes twice as long."""
    return {
        "id": run.id,
        "state": run.state,
        "queue_position": None,
        "progress": {"done": run.progress_done, "total": run.progress_total, "eta_s": run.eta_s(at)},
        "algorithms": [{"name": e.name, "label": e.label, "parameters": e.parameters} for e in run.algorithms],
        "source": run.source,
        "seed": run.seed,
        "trials": run.trials,
        "label": run.label,
        "tags": run.tags,
        "created_at": run.created_at,
        "started_at": run.started_at,
        "finished_at": run.finished_at,
        "error": run.error,
        "summary": run.summary,
        "software": run.software,
        "result_sha256": run.result_sha256,
        "size_bytes": size_bytes,
    }


def listed(run: stored.Run, *, at: dt.datetime, size_bytes: int | None) -> dict[str, Any]:
    """Return the fields of a run in a list: of its summary only what one of fifty rows can show."""
    summary = None if run.summary is None else {m: v for m, v in run.summary.items() if m in LISTED_METRICS}
    return item_of(run, at=at, size_bytes=size_bytes) | {"summary": summary}


class RunPage(_Out):
    """A page of runs."""

    items: list[RunItem]
    next_cursor: str | None


class TagItem(_Out):
    """A tag that runs carry."""

    tag: str
    runs: int
    """How many runs carry it."""


class TagList(_Out):
    """All tags, in the order of the alphabet."""

    items: list[TagItem]


class RunQuery(PageQuery):
    """Filters of the list."""

    state: Annotated[list[State], Field(default_factory=list)]
    """Only these states; may be repeated."""
    algorithm: Annotated[str, Field(max_length=80)] | None = None
    """Only runs with this algorithm."""
    tag: Annotated[str, Field(max_length=80)] | None = None
    """Only runs with this tag."""
    recording: Id | None = None
    """Only runs on this recording."""
    text: Annotated[str, Field(max_length=200)] = ""
    """Words; each must be part of a label, a tag, or the name of an algorithm, a recording, a scenario or a study."""
    created_after: AwareDatetime | None = None
    created_before: AwareDatetime | None = None
    order: Literal["-created_at", "created_at"] = "-created_at"
    """Newest or oldest first."""

    def only(self) -> stored.RunFilter:
        """Return the filter of the query."""
        return stored.RunFilter(
            state=tuple(self.state),
            algorithm=self.algorithm,
            tag=self.tag,
            recording_id=self.recording,
            text=self.text,
            created_after=self.created_after,
            created_before=self.created_before,
        )
