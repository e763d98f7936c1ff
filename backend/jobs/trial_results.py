"""From the blocks of a Monte Carlo run to its tables: metrics with intervals, curves, comparisons, consistency.

While trials still run the same functions work on the blocks that are there (see `partial_results`). Every table has
the column `label` and one column for each swept name; the tables of single estimates (`states`, `errors`, ...) hold the
first trial of the first cell as an example.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from algorithms.errors import AlgorithmError
from algorithms.registry import studies_by_name
from algorithms.result import Column, Metric, Note, Table
from algorithms.studies import StudyRun
from algorithms.texts import Texts
from algorithms.toolbox.monte_carlo.running import Running
from backend.db.outcomes import StoredTable
from backend.files.store import json_array
from backend.jobs import results
from backend.jobs.gathering import Arrays, Gathering, under
from backend.jobs.outcome import Outcome, finite, outcome_of
from backend.jobs.plan import TrialsPlan, Variant, series_name

_METRIC_COLUMNS = ("value", "ci95_low", "ci95_high")


def compose(gathering: Gathering, study: str | None = None) -> results.Composed:
    """Put together what the blocks of a run gave, in the order of its cells and trials; judge what a study claims."""
    plan, statistics, bounds = gathering.plan, gathering.statistics, gathering.bounds
    examples = _examples(plan, gathering.first)
    labels = list(examples)
    composed = results.compose(labels, [examples[label][0] for label in labels])
    arrays = dict(composed.arrays)
    arrays |= {name: array for name, array in gathering.first.items() if name.startswith("array/recording/")}
    arrays = {name.removeprefix("array/"): array for name, array in arrays.items()}
    counts = {"curves": dict.fromkeys(labels, 0)}
    for label in labels:
        table = _curves(plan, bounds, statistics, label, quantiles=True)
        if table is not None:
            arrays |= table.to_arrays(f"tables/curves/{label}")
            counts["curves"][label] = len(table)
        arrays |= _single_values(plan, statistics, label)
    kept = [table for table in composed.tables if table.name != "metrics"]
    metrics = measured(plan, statistics, quantiles=True)
    tables = [*kept, *small_tables(plan, statistics, metrics)]
    if plan.swept:
        tables.append(_times(gathering))
    if study is not None:
        # An algorithm that gives one answer for each trial has no instants, and no curves over them.
        drawn = [label for label in labels if counts["curves"][label]]
        curves = {label: Table.from_arrays(arrays, f"tables/curves/{label}") for label in drawn}
        tables.append(_claims(study, tables, results.joined(curves)))
    entries = [
        {
            **entry,
            "tables": {**entry["tables"], **({"curves": count} if (count := counts["curves"][entry["label"]]) else {})},
            "notes": [*entry["notes"], *_thinned(plan)],
            "seconds": _seconds(gathering, entry["label"]),
            "variants": len(examples[entry["label"]][1]),
            "settings": _settings(examples[entry["label"]]),
        }
        for entry in composed.entries
    ]
    return results.Composed(arrays, tables, summary(plan, metrics), finite(entries), composed.software)


def measured(
    plan: TrialsPlan, statistics: Mapping[int, Running], *, quantiles: bool
) -> dict[tuple[int, int], list[Metric]]:
    """Metrics by cell and variant, label by label and cell by cell; quantiles need a look at every single value."""
    return {(cell, k): running.metrics(k, quantiles=quantiles) for cell, k, _, running in _lines(plan, statistics)}


def small_tables(
    plan: TrialsPlan, statistics: Mapping[int, Running], metrics: Mapping[tuple[int, int], list[Metric]]
) -> list[StoredTable]:
    """Tables `metrics`, `comparisons` and `consistency`."""
    return [
        _metrics(plan, metrics),
        _comparisons(plan, statistics),
        _consistency(plan, statistics),
    ]


def summary(plan: TrialsPlan, metrics: Mapping[tuple[int, int], list[Metric]]) -> dict[str, Any]:
    """Headline: {metric: {label: value}}; where values are swept the label is followed by them."""
    out: dict[str, Any] = {}
    for (cell, k), found in metrics.items():
        variant = plan.variants[k]
        name = series_name(variant.label, {**plan.cells[cell].values, **variant.values})
        for m in found:
            if not m.segment and not m.target:
                known = m.ci95_low is not None and m.ci95_high is not None
                interval = [m.ci95_low, m.ci95_high] if known else None
                out.setdefault(m.metric, {})[name] = {"value": m.value, "ci95": interval, "unit": m.unit}
    return out


def curves_of(
    plan: TrialsPlan, statistics: Mapping[int, Running], bounds: Mapping[tuple[int, int], NDArray[Any]]
) -> Table | None:
    """Curves of all labels under each other, the label first; None where nothing has instants."""
    labels = list(dict.fromkeys(variant.label for variant in plan.variants))
    tables = {label: _curves(plan, bounds, statistics, label, quantiles=False) for label in labels}
    found = {label: table for label, table in tables.items() if table is not None}
    return results.joined(found) if found else None


def _lines(plan: TrialsPlan, statistics: Mapping[int, Running]) -> Iterable[tuple[int, int, Variant, Running]]:
    """(cell, place among the variants, variant, statistics), label by label and cell by cell."""
    order = sorted(range(len(plan.variants)), key=lambda k: plan.variants[k].entry)
    for k in order:
        for cell, running in statistics.items():
            yield cell, k, plan.variants[k], running


def _swept(plan: TrialsPlan, cell: int, variant: Variant) -> list[Any]:
    values = {**plan.cells[cell].values, **variant.values}
    return [values.get(name) for name in plan.swept]


def _swept_columns(plan: TrialsPlan) -> list[tuple[str, str]]:
    """Names and kinds of the columns of swept values."""
    found: dict[str, list[Any]] = {name: [] for name in plan.swept}
    for values in (*(cell.values for cell in plan.cells), *(variant.values for variant in plan.variants)):
        for name, value in values.items():
            found[name].append(value)
    return [(name, "number" if all(map(_is_number, found[name])) else "text") for name in plan.swept]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _cells_of_table(values: Iterable[Any], kinds: Iterable[tuple[str, str]]) -> list[Any]:
    """Swept values as a table holds them: numbers as they are, anything else as words."""
    return [v if kind == "number" or v is None else str(v) for v, (_, kind) in zip(values, kinds, strict=True)]


def _metrics(plan: TrialsPlan, metrics: Mapping[tuple[int, int], list[Metric]]) -> StoredTable:
    swept = _swept_columns(plan)
    columns = [
        ("metric", "text"), ("label", "text"), ("segment", "text"), ("target", "text"), *swept,
        *((name, "number") for name in _METRIC_COLUMNS), ("unit", "text"), ("n", "integer"),
    ]  # fmt: skip
    rows: list[list[Any]] = []
    for (cell, k), found in metrics.items():
        values = _cells_of_table(_swept(plan, cell, plan.variants[k]), swept)
        rows.extend(_row(m, plan.variants[k].label, values) for m in found)
    return StoredTable("metrics", columns, finite(rows))


def _row(m: Metric, label: str, swept: list[Any]) -> list[Any]:
    return [m.metric, label, m.segment, m.target, *swept, m.value, m.ci95_low, m.ci95_high, m.unit, m.n]


def _comparisons(plan: TrialsPlan, statistics: Mapping[int, Running]) -> StoredTable:
    """Pairs of variants of one scenario cell; a variant's swept values follow its label in words."""
    swept = [c for c in _swept_columns(plan) if c[0] in plan.cells[0].values]
    columns = [
        ("metric", "text"), ("label", "text"), ("against", "text"), ("segment", "text"), ("target", "text"), *swept,
        ("difference", "number"), ("ci95_low", "number"), ("ci95_high", "number"), ("ratio", "number"),
        ("ratio_low", "number"), ("ratio_high", "number"), ("unit", "text"), ("n", "integer"), ("verdict", "text"),
    ]  # fmt: skip
    names = [series_name(v.label, v.values) for v in plan.variants]
    rows: list[list[Any]] = []
    for cell, running in statistics.items():
        values = _cells_of_table([plan.cells[cell].values[name] for name, _ in swept], swept)
        rows.extend(
            [c.metric, names[c.first], names[c.second], c.segment, c.target, *values, c.difference, c.low, c.high,
             c.ratio, c.ratio_low, c.ratio_high, c.unit, c.trials, c.verdict]
            for c in running.comparisons()
            if comparable(plan.variants[c.first], plan.variants[c.second])
        )  # fmt: skip
    return StoredTable("comparisons", columns, finite(rows))


def comparable(first: Variant, second: Variant) -> bool:
    """Whether two variants differ in nothing but their algorithms, where these sweep parameters of one name."""
    if first.label == second.label:
        return True
    others = {name.rpartition(".")[2]: value for name, value in second.values.items()}
    return all(others.get(name.rpartition(".")[2], value) == value for name, value in first.values.items())


def _consistency(plan: TrialsPlan, statistics: Mapping[int, Running]) -> StoredTable:
    swept = _swept_columns(plan)
    numbers = ("value", "bound_low", "bound_high", "inside_share", "above_share")
    columns = [
        ("statistic", "text"), ("label", "text"), ("segment", "text"), ("target", "text"), *swept,
        *((name, "number") for name in numbers), ("instants", "integer"), ("verdict", "text"),
    ]  # fmt: skip
    rows: list[list[Any]] = []
    for cell, k, variant, running in _lines(plan, statistics):
        values = _cells_of_table(_swept(plan, cell, variant), swept)
        for found in running.consistency(k):
            rest = [found[name] for name, _ in columns[4 + len(swept) :]]
            rows.append([found["statistic"], variant.label, found["segment"], found["target"], *values, *rest])
    return StoredTable("consistency", columns, finite(rows))


def _curves(
    plan: TrialsPlan,
    bounds: Mapping[tuple[int, int], NDArray[Any]],
    statistics: Mapping[int, Running],
    label: str,
    *,
    quantiles: bool,
) -> Table | None:
    """Curves of all cells and variants of a label under each other; None where it has no instants."""
    swept = _swept_columns(plan)
    parts: list[dict[str, Column]] = []
    for cell, k, variant, running in _lines(plan, statistics):
        if variant.label != label:
            continue
        axes = running.axes(k)
        count = axes.time_s.size
        if count == 0:
            continue
        columns: dict[str, Column] = {
            name: np.full(count, np.nan if value is None else value)
            if kind == "number"
            else Texts.repeated(value, count)
            for (name, kind), value in zip(swept, _cells_of_table(_swept(plan, cell, variant), swept), strict=True)
        }
        columns["target"] = Texts.coded(axes.target, axes.layout.targets)
        columns["time_s"] = axes.time_s
        columns |= running.curves(k, quantiles=quantiles)
        bound = bounds.get((cell, k))
        columns["bound_horizontal_m"] = np.full(count, np.nan) if bound is None else bound
        columns["trials"] = np.full(count, running.trials)
        parts.append(columns)
    return _stacked(parts) if parts else None


def _stacked(parts: list[dict[str, Column]]) -> Table:
    out: dict[str, Column] = {}
    for name in parts[0]:
        columns = [part[name] for part in parts]
        if all(isinstance(c, np.ndarray) for c in columns):
            out[name] = np.concatenate([np.asarray(c) for c in columns])
        else:
            out[name] = Texts.joined(c for c in columns if isinstance(c, Texts))
    return Table(out)


def _claims(study: str, tables: list[StoredTable], curves: Table) -> StoredTable:
    """Table `claims`: what the paper says, our number, and whether it holds."""
    found = {t.name: results.table_of_stored(t) for t in tables if t.name in ("metrics", "comparisons", "consistency")}
    declared = studies_by_name()[study]
    try:
        verdicts = declared.judge(StudyRun({**found, "curves": curves}))
    except (LookupError, ZeroDivisionError) as error:
        raise AlgorithmError(
            f"The study {study} did not find a number that it judges by: {error}",
            remedy="Run it with more trials; two are the least.",
            code="study_mismatch",
        ) from error
    columns = [
        ("figure", "text"), ("claim", "text"), ("paper", "text"), ("value", "number"), ("ci95_low", "number"),
        ("ci95_high", "number"), ("unit", "text"), ("verdict", "text"), ("reason", "text"),
    ]  # fmt: skip
    rows = [
        [v.claim.figure, v.claim.claim, v.claim.paper, v.value, v.ci95_low, v.ci95_high, v.unit, v.verdict, v.reason]
        for v in verdicts
    ]
    return StoredTable("claims", columns, finite(rows))


def _single_values(plan: TrialsPlan, statistics: Mapping[int, Running], label: str) -> dict[str, NDArray[Any]]:
    """Kept single values of a label: (cell, instant, trial), with what its cells are and which instants were kept.

    Cells of different length cannot stand in one array: then each has its own, under its number.
    """
    values: dict[str, list[NDArray[Any]]] = {}
    cells = []
    for cell, k, variant, running in _lines(plan, statistics):
        if variant.label == label:
            cells.append({**plan.cells[cell].values, **variant.values})
            axes = running.axes(k)
            for name, array in running.sample_arrays(k).items():
                values.setdefault(name, []).append(array)
            values.setdefault("kept_time_s", []).append(axes.time_s[axes.kept])
    out: dict[str, NDArray[Any]] = {f"{label}/trials/cells": json_array(finite(cells))}
    for name, arrays in values.items():
        if name == "kept_time_s" and all(np.array_equal(a, arrays[0]) for a in arrays):
            out[f"{label}/trials/{name}"] = arrays[0]
        elif len({a.shape for a in arrays}) == 1 and name != "kept_time_s":
            out[f"{label}/trials/{name}"] = np.stack(arrays)
        else:
            out |= {f"{label}/trials/{name}/{i}": array for i, array in enumerate(arrays)}
    return out


def _examples(plan: TrialsPlan, arrays: Arrays) -> dict[str, tuple[Outcome, list[dict[str, Any]]]]:
    """First trial of the first cell by label: the first variant whole, and the settings of all its variants."""
    out: dict[str, tuple[Outcome, list[dict[str, Any]]]] = {}
    for k, variant in enumerate(plan.variants):
        example = outcome_of(under(arrays, f"array/{k}/example/"))
        out.setdefault(variant.label, (example, []))[1].append(example.settings)
    return out


def _thinned(plan: TrialsPlan) -> list[dict[str, Any]]:
    """Say where medians and quantiles are not of every instant."""
    if plan.keep_every == 1:
        return []
    detail = f"Medians and other quantiles are of one instant in {plan.keep_every}: the values of all are too many."
    return [asdict(Note("quantiles_thinned", detail, plan.keep_every))]


def _seconds(gathering: Gathering, label: str) -> float:
    """Time of computation of a label over all blocks."""
    own = [k for k, variant in enumerate(gathering.plan.variants) if variant.label == label]
    return round(float(gathering.seconds[:, own].sum()), 3)


def _times(gathering: Gathering) -> StoredTable:
    """Time that a trial of each cell took each variant: what a sweep says of the cost of what is swept."""
    plan = gathering.plan
    swept = _swept_columns(plan)
    columns = [("label", "text"), *swept, ("seconds_per_trial", "number"), ("trials", "integer")]
    rows: list[list[Any]] = []
    for cell, k, variant, running in _lines(plan, gathering.statistics):
        values = _cells_of_table(_swept(plan, cell, variant), swept)
        rows.append([variant.label, *values, float(gathering.seconds[cell, k]) / running.trials, running.trials])
    return StoredTable("computing_times", columns, finite(rows))


def _settings(example: tuple[Outcome, list[dict[str, Any]]]) -> dict[str, Any]:
    """Settings of a label; a value that the sweep varies says so."""
    first, *others = example[1]
    return {
        name: setting
        if all(other.get(name) == setting for other in others)
        else {"value": [s[name]["value"] for s in (first, *others) if name in s], "source": "sweep"}
        for name, setting in first.items()
    }
