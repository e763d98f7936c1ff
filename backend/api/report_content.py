"""What the report of a run says, from its numbers: the same for a run on the server and for one without."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from algorithms.result import Table
from backend.api.algorithms import ReferenceOut, catalogue
from backend.db.runs import Entry

if TYPE_CHECKING:
    from backend.charts.report import ReportContent, ReportMetric, ReportRequirement
    from backend.charts.view import Figure


def report_content(
    *,
    title: str,
    facts: Sequence[tuple[str, str]],
    recording: Sequence[tuple[str, str]],
    warnings: Sequence[str],
    entries: Sequence[Entry],
    used: Sequence[Mapping[str, Any]],
    metrics: Table,
    decisions: Table,
    figures: Sequence[Figure],
    software: Mapping[str, Any],
    requirements: Table | None = None,
) -> ReportContent:
    """Put a report together.

    Parameters
    ----------
    facts, recording : names and values about the run and about what it worked on
    entries, used : the algorithms as they were asked for, and per label the settings and notes of what was used
    metrics, decisions, requirements : the tables of all labels; without rows where there are none
    """
    from backend.charts.report import ReportContent, ReportEntry

    by_label = {str(e["label"]): e for e in used}
    shown = [
        ReportEntry(
            label=e.label,
            algorithm=e.name,
            summary=catalogue()[e.name].summary if e.name in catalogue() else "",
            settings=[
                (name, _plain(setting["value"]), str(setting["source"]))
                for name, setting in sorted(by_label.get(e.label, {}).get("settings", {}).items())
            ],
            notes=[(n["detail"], int(n["count"])) for n in by_label.get(e.label, {}).get("notes", ())],
        )
        for e in entries
    ]
    of_all, by_target = _metrics(metrics)
    left_out = [
        "Every number is in the tables of the run: tables/NAME.csv, .parquet and .json, result.npz, result.mat."
    ]
    if by_target:
        left_out.append(f"{by_target} metrics of single targets are in the table metrics.")
    return ReportContent(
        title=title,
        facts=facts,
        recording=recording,
        warnings=warnings,
        entries=shown,
        metrics=of_all,
        figures=figures,
        decisions=_decisions(decisions, entries),
        references=_references(entries),
        software={str(k): str(v) for k, v in software.items()},
        left_out=left_out,
        requirements=_requirements(requirements),
    )


def about_scenario(source: Mapping[str, Any], trials: int) -> list[tuple[str, str]]:
    """Say which scenario a run is of."""
    return [
        ("Scenario", str(source["name"])),
        ("Trials", str(trials)),
        ("Settings", json.dumps(source["scenario"], ensure_ascii=False)),
        *([("Sweep", json.dumps(source["sweep"], ensure_ascii=False))] if source.get("sweep") else []),
    ]


def counted(words: str, count: int) -> str:
    """Words with how often they hold."""
    return f"{words} ({count})" if count > 1 else words


def _metrics(table: Table) -> tuple[list[ReportMetric], int]:
    """Metrics of all targets together, and how many there are of single ones."""
    from backend.charts.report import ReportMetric

    rows = [dict(zip(table.names, row, strict=True)) for row in table.rows()]
    out = [
        ReportMetric(
            metric=row["metric"],
            label=row["label"],
            segment=row["segment"] or "",
            value=row["value"],
            ci95=None if row["ci95_low"] is None or row["ci95_high"] is None else (row["ci95_low"], row["ci95_high"]),
            unit=row["unit"] or "",
            n=int(row["n"]),
        )
        for row in rows
        if not row["target"]
    ]
    return out, len(rows) - len(out)


def _requirements(table: Table | None) -> list[ReportRequirement]:
    """Rows with a threshold; where none was given, the values of all targets together."""
    from backend.charts.report import ReportRequirement

    if table is None or not len(table):
        return []
    rows = [dict(zip(table.names, row, strict=True)) for row in table.rows()]
    asked = [row for row in rows if row["threshold"] is not None]
    return [
        ReportRequirement(
            label=row["label"],
            target=row["target"] or "",
            segment=row["segment"],
            requirement=row["requirement"],
            value=row["value"],
            threshold=row["threshold"],
            unit=row["unit"],
            verdict=row["verdict"],
            n=int(row["n"]),
        )
        for row in asked or [row for row in rows if not row["target"]]
    ]


def _decisions(table: Table, entries: Sequence[Entry]) -> list[tuple[str, str, str, int]]:
    names = ("label", "decision", "reason")
    if not len(table) or any(n not in table.columns for n in names):
        return []
    counts = Counter(zip(*(table.columns[n] for n in names), strict=True))
    place = {e.label: i for i, e in enumerate(entries)}
    order = sorted(counts.items(), key=lambda item: (place.get(str(item[0][0]), 0), -item[1]))
    return [(str(label), str(what), str(why or ""), count) for (label, what, why), count in order]


def _references(entries: Sequence[Entry]) -> list[str]:
    found = [
        ReferenceOut.of(reference)
        for entry in entries
        if (algorithm := catalogue().get(entry.name)) is not None
        for reference in algorithm.references
    ]
    return list(dict.fromkeys(f"{r.text} ({r.place})" if r.place else r.text for r in found))


def _plain(value: Any) -> str:
    if isinstance(value, float):
        return np.format_float_positional(value, trim="-") if 1e-6 <= abs(value) < 1e9 or value == 0 else repr(value)
    return json.dumps(value, ensure_ascii=False) if isinstance(value, list | dict) else str(value)
