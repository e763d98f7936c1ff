"""What a run without a server gives: tables, charts, arrays and an account of it, as files in one folder."""

from __future__ import annotations

import argparse
import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from backend.cli.terminal import UsageError

if TYPE_CHECKING:
    from algorithms.recording import Recording
    from algorithms.result import Table
    from backend.charts.language import Language
    from backend.charts.view import Chart, RunView
    from backend.db.runs import Entry
    from backend.jobs.results import Composed


@dataclass(frozen=True)
class LocalRun:
    """A finished run that is stored nowhere.

    Attributes
    ----------
    source : what it worked on; with "scenario" where that was simulated
    recording : the measurements, or the first simulated trial
    """

    title: str
    entries: Sequence[Entry]
    source: Mapping[str, Any]
    recording: Recording
    composed: Composed

    def tables(self) -> dict[str, Table]:
        """All tables by name, rows of all labels under each other."""
        from backend.jobs.results import joined, table_of_stored

        out = {stored.name: table_of_stored(stored) for stored in self.composed.tables}
        for name in self._big_names():
            found = {e.label: self._big(name, e.label) for e in self.entries}
            out[name] = joined({label: table for label, table in found.items() if table is not None})
        return out

    def charts(self) -> list[Chart]:
        """The charts that the page shows of such a run."""
        from backend.api.charts import charts_of_entries

        return charts_of_entries(self.entries, self.source)

    def view(self) -> RunView:
        """What the charts see."""
        from algorithms.result import Table
        from backend.api.charts import preset_of
        from backend.charts.view import Entry as ChartEntry
        from backend.charts.view import RunView, rows_of_label
        from backend.jobs.results import table_of_stored

        small = {stored.name: table_of_stored(stored) for stored in self.composed.tables}

        def entry(index: int, declared: Entry) -> ChartEntry:
            label = declared.label

            def table(name: str) -> Table:
                if name in small:
                    return rows_of_label(small[name], label)
                return self._big(name, label) or Table({})

            def arrays() -> dict[str, Any]:
                prefix = f"{label}/"
                own = self.composed.arrays
                return {name.removeprefix(prefix): own[name] for name in own if name.startswith(prefix)}

            return ChartEntry(label, index, declared.name, table, arrays, declared.parameters)

        return RunView(
            recording=self.recording,
            entries=tuple(entry(i, e) for i, e in enumerate(self.entries)),
            legs=tuple((name, start, stop) for name, start, stop in self.source.get("legs", ())),
            scenario=preset_of(self.source),
        )

    def _big_names(self) -> list[str]:
        ends = "/columns"
        keys = [key.split("/") for key in self.composed.arrays if key.startswith("tables/") and key.endswith(ends)]
        return list(dict.fromkeys(parts[1] for parts in keys))

    def _big(self, name: str, label: str) -> Table | None:
        from algorithms.result import Table

        prefix = f"tables/{name}/{label}"
        arrays = self.composed.arrays
        return Table.from_arrays(arrays, prefix) if f"{prefix}/columns" in arrays else None


def prepared_folder(folder: Path | None, overwrite: bool) -> None:
    """Say before anything is computed that the results could not be written there."""
    if folder is None:
        return
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder} is a file; --out names a folder.")
    if folder.is_dir() and not overwrite and any(folder.iterdir()):
        raise UsageError(f"{folder} is not empty: choose another folder, or say --overwrite.")
    folder.mkdir(parents=True, exist_ok=True)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where the results go, and in which language their pages are."""
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for tables, charts, result.npz and run.json")
    parser.add_argument("--overwrite", action="store_true", help="write into a folder that is not empty")
    parser.add_argument(
        "--language", choices=("en", "ru"), default="en", help="of the report and the charts (default en)"
    )


def write_outputs(
    folder: Path,
    run: LocalRun,
    about: Mapping[str, Any],
    report: Callable[[float], None],
    *,
    more: Mapping[str, Table] | None = None,
    language: Language = "en",
) -> list[str]:
    """Write everything, then move it into the folder: what is interrupted leaves nothing half written.

    `about` becomes `run.json`, `more` are tables beside those of the run. Gives the names of the files.
    """
    with tempfile.TemporaryDirectory(prefix=".unfinished-", dir=folder) as unfinished:
        _write(Path(unfinished), run, about, more or {}, report, language)
        written = sorted(path for path in Path(unfinished).rglob("*") if path.is_file())
        names = [path.relative_to(unfinished).as_posix() for path in written]
        for path, name in zip(written, names, strict=True):
            target = folder / name
            target.parent.mkdir(exist_ok=True)
            os.replace(path, target)
    return names


def _write(
    folder: Path,
    run: LocalRun,
    about: Mapping[str, Any],
    more: Mapping[str, Table],
    report: Callable[[float], None],
    language: Language,
) -> None:
    from algorithms.result import Table
    from backend.api.report_content import about_scenario, counted, report_content
    from backend.charts.figure_words import figure_in
    from backend.charts.html import chart_page
    from backend.charts.language import words_of
    from backend.charts.report import report_page
    from backend.charts.view import ChartOptions
    from backend.files.array_file import write_arrays
    from backend.files.parquet_writer import write_parquet
    from backend.files.table_writer import write_table_csv

    own, charts = run.tables(), run.charts()
    tables = {**own, **more}
    steps = 2 * len(tables) + len(charts)
    done = 0
    for part in ("tables", "charts"):
        (folder / part).mkdir()
    for name, table in tables.items():
        with (folder / "tables" / f"{name}.csv").open("w", encoding="utf-8", newline="") as out:
            write_table_csv(table, out)
        write_parquet(table, folder / "tables" / f"{name}.parquet", about={"run": run.title, "table": name})
        done += 2
        report(done / steps)
    view, words = run.view(), words_of(language)
    figures = []
    for chart in charts:
        figure = figure_in(chart.draw(view, ChartOptions(entries=len(run.entries))), words, chart.name)
        figures.append(figure)
        (folder / "charts" / f"{chart.name}.html").write_bytes(chart_page(figure, words.said(run.title), language))
        done += 1
        report(done / steps)
    content = report_content(
        title=run.title,
        facts=_facts(run, about),
        recording=_about_recording(about) if "recording" in about else about_scenario(run.source, about["trials"]),
        warnings=[counted(w["detail"], w["count"]) for w in about.get("recording", {}).get("warnings", ())],
        entries=run.entries,
        used=run.composed.entries,
        metrics=own.get("metrics", Table({})),
        decisions=own.get("decisions", Table({})),
        figures=figures,
        software=run.composed.software,
        requirements=own.get("requirements"),
    )
    (folder / "report.html").write_bytes(report_page(content, words))
    write_arrays(folder / "result.npz", run.composed.arrays)
    text = json.dumps(about, indent=2, ensure_ascii=False, allow_nan=False)
    (folder / "run.json").write_text(text + "\n", encoding="utf-8")


def _facts(run: LocalRun, about: Mapping[str, Any]) -> list[tuple[str, str]]:
    labels = [e.label if e.label == e.name else f"{e.label} ({e.name})" for e in run.entries]
    study = [("Study", str(about["study"]))] if "study" in about else []
    return [*study, ("Algorithms", ", ".join(labels)), ("Seed", str(about["seed"]))]


def _about_recording(about: Mapping[str, Any]) -> list[tuple[str, str]]:
    read = about["recording"]
    rows, (first, last) = read["rows"], read["time_span_s"]
    start = f"from {read['start_utc']}" if read["start_utc"] else "from an unknown start"
    files = [*read["files"], *(f for f in (read["site_file"], read["truth_file"]) if f is not None)]
    site = read["site"] or {}
    places = [f"{len(site[n])} {n}" for n in ("stations", "radars", "transmitters", "receivers") if site.get(n)]
    return [
        ("Kind and format", f"{read['kind']}, {read['format']}"),
        ("Files (SHA-256)", "; ".join(f"{f['name']} {f['sha256']}" for f in files)),
        ("Rows", f"{rows['read']} read, {rows['accepted']} accepted, {rows['rejected']} rejected"),
        ("Times", f"{first:.3f} s to {last:.3f} s, {start}"),
        ("Site", ", ".join(places) or "none"),
        ("Truth", "known" if read["has_truth"] else "not known"),
        ("Options", json.dumps(read["options"], ensure_ascii=False) if read["options"] else "none"),
    ]


def summary_lines(summary: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> list[str]:
    """Headline as lines of a table: metric, label, value with its 95 % interval, unit."""
    from backend.charts.report import number_text

    rows = []
    for metric, found in summary.items():
        for label, number in found.items():
            interval = None if number["ci95"] is None or None in number["ci95"] else tuple(number["ci95"])
            value = number_text(number["value"], interval)
            if interval is not None:
                value += f" [{number_text(interval[0], interval)}, {number_text(interval[1], interval)}]"
            rows.append((metric, label, value, number["unit"]))
    widths = [max((len(row[i]) for row in rows), default=0) for i in range(3)]
    return [
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[3]]).rstrip() for row in rows
    ]
