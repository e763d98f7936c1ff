"""Runs side by side: names for the entries of several runs, what they were given, what came of it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from algorithms.result import Table
from algorithms.site import Site
from backend.api.measurements import Measurements
from backend.charts.view import Overlay
from backend.db.runs import Entry, Run

# Digits of an id that tell runs of the same name apart.
ID_DIGITS = 6
# How many plots have a partner, a track or a place in an ellipse is no merit.
_SMALLER_IS_BETTER = re.compile(
    r"(rms|median|p\d+|max)_.*|(?!accepted_|tracked_|inner_|middle_|outer_|manoeuvre_)\w+_share"
    r"|switches|false_tracks|ospa_m|gospa_.+"
)
_LARGER_IS_BETTER = frozenset({"answered_share", "tracked_share", "purity", "join_recall", "join_precision"})


@dataclass(frozen=True)
class Compared:
    """One algorithm of one of the compared runs; `index` counts through all of them (colour and dash)."""

    index: int
    run: Run
    entry: Entry
    label: str


@dataclass(frozen=True)
class Row:
    """One line of a table: a value for each compared entry, None where it has none."""

    name: str
    values: list[Any]
    differs: bool


def titles_of(runs: Sequence[Run]) -> list[str]:
    """Return what each run is called: its label or its recording's name, with its id where others are called so."""
    titles = [run.label or str(run.source.get("name", run.id)) for run in runs]
    known = Counter(titles)
    return [
        f"{title} {run.id[:ID_DIGITS]}" if known[title] > 1 else title for title, run in zip(titles, runs, strict=True)
    ]


def compared_entries(runs: Sequence[Run]) -> list[Compared]:
    """Return the entries of all runs in order, under labels `run / entry` that are unique among them."""
    titles = titles_of(runs)
    labels = [f"{title} / {e.label}" for title, run in zip(titles, runs, strict=True) for e in run.algorithms]
    if len(set(labels)) < len(labels):
        # `a / b` with `c` reads like `a` with `b / c`.
        labels = [
            f"{title} {run.id} / {e.label}" for title, run in zip(titles, runs, strict=True) for e in run.algorithms
        ]
    pairs = [(run, entry) for run in runs for entry in run.algorithms]
    return [Compared(i, run, entry, labels[i]) for i, (run, entry) in enumerate(pairs)]


def given(entries: Sequence[Compared], recordings: Sequence[Measurements]) -> list[Row]:
    """What runs are about: recording, algorithm, seed, trials."""
    known = {r.id: r for r in recordings}
    names = Counter(r.name for r in known.values())
    of_runs = dict(zip(dict.fromkeys(one.run.id for one in entries), recordings, strict=True))

    def recording(one: Compared) -> str:
        found = of_runs[one.run.id]
        return f"{found.name} {found.id[:ID_DIGITS]}" if names[found.name] > 1 else found.name

    facts: dict[str, Callable[[Compared], Any]] = {
        "recording": recording,
        "algorithm": lambda one: one.entry.name,
        "seed": lambda one: one.run.seed,
        "trials": lambda one: one.run.trials,
    }
    return [_row(name, [fact(one) for one in entries]) for name, fact in facts.items()]


def software(entries: Sequence[Compared]) -> list[Row]:
    """Versions and processors with which the entries were computed."""
    names = dict.fromkeys(name for one in entries for name in one.run.software or {})
    return [_row(name, [(one.run.software or {}).get(name) for one in entries]) for name in names]


def parameters(entries: Sequence[Compared]) -> list[Row]:
    """Every parameter as it was used, {value, source}; None where the entry's algorithm has no such parameter."""
    used = [_settings(one) for one in entries]
    names = dict.fromkeys(name for settings in used for name in settings)
    rows = []
    for name in names:
        cells = [settings.get(name) for settings in used]
        rows.append(Row(name, cells, _differ([cell["value"] for cell in cells if cell is not None])))
    return rows


@dataclass(frozen=True)
class MetricRow:
    """One metric of all entries; `best` holds the places of the best value, none where there is no better."""

    metric: str
    unit: str
    values: list[dict[str, Any] | None]
    differs: bool
    best: list[int]


def metrics(
    entries: Sequence[Compared], tables: dict[str, Table], *, target: str, segment: str, comparable: bool
) -> list[MetricRow]:
    """Metrics of one target and segment (empty: of all) from the runs' tables `metrics` by run id."""
    found: dict[tuple[str, str], dict[int, dict[str, Any]]] = {}
    places = {(one.run.id, one.entry.label): one.index for one in entries}
    for run_id, table in tables.items():
        for line in table.rows():
            row = dict(zip(table.columns, line, strict=True))
            if ((row["target"] or ""), (row["segment"] or "")) != (target, segment):
                continue
            ci95 = [row["ci95_low"], row["ci95_high"]]
            place = places[run_id, row["label"]]
            cell = {"value": row["value"], "ci95": None if None in ci95 else ci95, "n": row["n"]}
            found.setdefault((row["metric"], row["unit"]), {})[place] = cell
    rows = []
    for (metric, unit), cells in found.items():
        values = [cells.get(i) for i in range(len(entries))]
        numbers = [None if cell is None else cell["value"] for cell in values]
        best = best_places(metric, numbers) if comparable else []
        rows.append(MetricRow(metric, unit, values, _differ([n for n in numbers if n is not None]), best))
    return rows


def best_places(metric: str, values: Sequence[float | None]) -> list[int]:
    """Return where the best value stands; nothing where all are the same or neither direction is better."""
    known = [v for v in values if v is not None]
    larger = metric in _LARGER_IS_BETTER
    if not (larger or _SMALLER_IS_BETTER.fullmatch(metric)) or not _differ(known):
        return []
    best = max(known) if larger else min(known)
    return [i for i, value in enumerate(values) if value == best]


def same_recording(recordings: Sequence[Measurements]) -> bool:
    """Whether all runs worked on the same measurements, site and truth."""
    return len({one.key for one in recordings}) == 1


def obstacle(overlay: Overlay, recordings: Sequence[Measurements]) -> str | None:
    """Say why runs on these recordings cannot be drawn into one chart; None where they can."""
    if same_recording(recordings):
        return None
    if overlay == "recording":
        return "This chart shows what is in the recording itself, and the runs worked on different recordings."
    if len({r.start_utc for r in recordings}) > 1:
        return "The runs worked on recordings that count time from different instants."
    if overlay == "frame" and not _same_frame(recordings):
        return "The runs worked on recordings whose local frames have different or unknown origins."
    return None


def _same_frame(recordings: Sequence[Measurements]) -> bool:
    sites = [None if r.site is None else Site.model_validate(r.site) for r in recordings]
    if all(site is not None and site == sites[0] for site in sites):
        return True
    origins = [None if site is None else site.frame_origin() for site in sites]
    return origins[0] is not None and all(origin == origins[0] for origin in origins)


def _settings(one: Compared) -> dict[str, Any]:
    found = next((e for e in one.run.entries or () if e["label"] == one.entry.label), None)
    return {} if found is None else dict(found["settings"])


def _row(name: str, values: list[Any]) -> Row:
    return Row(name, values, _differ([v for v in values if v is not None]))


def _differ(values: Sequence[Any]) -> bool:
    return any(value != values[0] for value in values)
