"""`filterroom run`: one algorithm on one recording, without a server."""

from __future__ import annotations

import argparse
import hashlib
import io
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from backend.cli import outputs
from backend.cli.given import assignments, checked_model
from backend.cli.outputs import LocalRun, prepared_folder, summary_lines, write_outputs
from backend.cli.terminal import DONE, ProgressBar, UsageError, settings_of

if TYPE_CHECKING:
    from algorithms.recording import Recording
    from algorithms.result import Table
    from backend.db.runs import Entry
    from backend.files.report import ReadReport
    from backend.jobs.outcome import Outcome

# Rejected rows that are told; all of them stand in tables/rejections.csv.
_TOLD = 5
_TOLD_TO_SCRIPTS = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments of the command."""
    parser.add_argument("algorithm", metavar="ALGORITHM", help="its name, as `filterroom algorithms` lists it")
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="measurements; several are one recording")
    parser.add_argument("--site", type=Path, metavar="FILE", help="places of the stations: JSON, or a table in CSV")
    parser.add_argument("--truth", type=Path, metavar="FILE", help="true positions, to measure the errors against")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a parameter of the algorithm")
    parser.add_argument("--read", action="append", default=[], metavar="NAME=VALUE", help="an option of reading")
    parser.add_argument("--seed", type=int, default=0, help="seed of the random streams (default 0)")
    outputs.add_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Read the files, compute, print the headline, write what was asked for."""
    from algorithms.registry import algorithms_by_name
    from backend.db.runs import Entry

    algorithm = algorithms_by_name().get(options.algorithm)
    if algorithm is None:
        raise UsageError(f"There is no algorithm {options.algorithm!r}; there are {', '.join(algorithms_by_name())}.")
    if options.seed < 0:
        raise UsageError("--seed: a seed is not negative.")
    parameters = assignments(options.set, "--set")
    checked_model(algorithm.parameters, parameters, "--set", strict=True)
    prepared_folder(options.out, options.overwrite)
    recording, report = _read(options)
    if recording.kind not in algorithm.takes:
        raise _unfit(algorithm.name, algorithm.takes, recording.kind)
    entry = Entry(algorithm.name, algorithm.name, parameters)
    outcome = _computed(entry, recording, options.seed)
    finished = _composed(entry, options, recording, outcome)
    about = _about(finished, options, report)
    if options.out is not None:
        with ProgressBar("writing") as bar:
            about["files"] = write_outputs(
                options.out,
                finished,
                about,
                bar.show,
                more={"rejections": _rejections(report)},
                language=options.language,
            )
    print(json.dumps(_for_scripts(about), ensure_ascii=False) if options.json else "\n".join(_lines(about, options)))
    return DONE


def _read(options: argparse.Namespace) -> tuple[Recording, ReadReport]:
    from backend.files.reading import NamedFile, ReadLimits, ReadOptions, read_recording

    given = checked_model(ReadOptions, assignments(options.read, "--read"), "--read", strict=False)
    # Opened here first: a file that is missing is named as it was typed.
    for path in [*options.files, *(p for p in (options.site, options.truth) if p is not None)]:
        path.open("rb").close()
    return read_recording(
        [NamedFile(path.name, path) for path in options.files],
        site=None if options.site is None else options.site.read_bytes(),
        truth=None if options.truth is None else NamedFile(options.truth.name, options.truth),
        options=given,
        limits=ReadLimits(max_rows=settings_of().max_rows),
    )


def _unfit(name: str, takes: tuple[str, ...], kind: str) -> Exception:
    from algorithms.errors import InputError

    return InputError(
        f"{name} takes {' or '.join(takes)}, and this recording holds {kind}.",
        remedy="`filterroom algorithms --json` says what each one takes.",
        code="kind_mismatch",
    )


def _computed(entry: Entry, recording: Recording, seed: int) -> Outcome:
    import numpy as np

    from backend.files.array_file import write_arrays
    from backend.jobs.work import Block, run_block

    packed = io.BytesIO()
    write_arrays(packed, recording.to_arrays())
    block = Block(
        token="",
        algorithm=entry.name,
        label=entry.label,
        parameters=entry.parameters,
        seed=seed,
        recordings=[("", np.frombuffer(packed.getbuffer(), np.uint8))],
    )
    with ProgressBar(entry.name) as bar:
        outcome = run_block(block, bar.show)
    return succeeded(outcome)


def succeeded(outcome: Outcome) -> Outcome:
    """Return a finished outcome; raise the error of a failed one, its trace on the standard error."""
    from algorithms.errors import AlgorithmError
    from backend.cli.terminal import tell

    if outcome.error is not None:
        if outcome.trace:
            tell(outcome.trace.rstrip())
        error = outcome.error
        raise AlgorithmError(error["detail"], remedy=error["remedy"], code=error["code"])
    return outcome


def _composed(entry: Entry, options: argparse.Namespace, recording: Recording, outcome: Outcome) -> LocalRun:
    from backend.jobs.results import compose

    name = options.files[0].name
    return LocalRun(
        title=f"{entry.name}, {name}",
        entries=[entry],
        source={"name": name, "kind": recording.kind},
        recording=recording,
        composed=compose([entry.label], [outcome]),
    )


def _about(finished: LocalRun, options: argparse.Namespace, report: ReadReport) -> dict[str, Any]:
    """Everything that is needed to tell what was run, and to run it again."""
    from backend.jobs.outcome import finite

    (used,) = finished.composed.entries
    recording = finished.recording
    return {
        "algorithm": options.algorithm,
        "seed": options.seed,
        "recording": {
            "files": [_file(path) for path in options.files],
            "site_file": None if options.site is None else _file(options.site),
            "truth_file": None if options.truth is None else _file(options.truth),
            "options": assignments(options.read, "--read"),
            "kind": report.kind,
            "format": report.format,
            "rows": {
                "read": report.rows_read,
                "accepted": report.rows_accepted,
                "rejected": report.rows_read - report.rows_accepted,
            },
            "rejections": [asdict(r) for r in report.rejections[:_TOLD_TO_SCRIPTS]],
            "warnings": [asdict(w) for w in report.warnings],
            "time_span_s": list(report.time_span_s),
            "start_utc": recording.start_utc,
            "site": None if recording.site is None else recording.site.to_json(),
            "has_truth": recording.has_truth,
        },
        "settings": used["settings"],
        "notes": used["notes"],
        "seconds": used["seconds"],
        "summary": finite(finished.composed.summary),
        "software": finished.composed.software,
    }


def _for_scripts(about: dict[str, Any]) -> dict[str, Any]:
    recording = {name: value for name, value in about["recording"].items() if name != "site"}
    return {**about, "recording": recording}


def _file(path: Path) -> dict[str, str]:
    with path.open("rb") as content:
        return {"name": path.name, "sha256": hashlib.file_digest(content, "sha256").hexdigest()}


def _rejections(report: ReadReport) -> Table:
    import numpy as np

    from algorithms.result import Table

    found = report.rejections
    return Table(
        {
            "row": np.array([r.row for r in found], np.int64),
            "code": [r.code for r in found],
            "detail": [r.detail for r in found],
            "file": [r.file for r in found],
        }
    )


def _lines(about: dict[str, Any], options: argparse.Namespace) -> list[str]:
    """The same for people: what was read, what must be known, the headline, where the files are."""
    recording = about["recording"]
    rows = recording["rows"]
    out = [
        f"{recording['kind']} ({recording['format']}): {rows['read']} rows read, {rows['accepted']} accepted, "
        f"{rows['rejected']} rejected."
    ]
    for r in recording["rejections"][:_TOLD]:
        where = f" of {r['file']}" if r["file"] else ""
        out.append(f"  row {r['row']}{where}: {r['detail']}")
    if rows["rejected"] > _TOLD:
        where = "tables/rejections.csv" if options.out is not None else "the folder of --out"
        out.append(f"  {rows['rejected'] - _TOLD} more; all are in {where}.")
    out += [f"Warning: {_counted(w)}" for w in recording["warnings"]]
    out += [f"Note: {_counted(n)}" for n in about["notes"]]
    out += [f"Computed in {about['seconds']:.2f} s.", *summary_lines(about["summary"])]
    if options.out is not None:
        out.append(f"{len(about['files'])} files are in {options.out}.")
    return out


def _counted(note: dict[str, Any]) -> str:
    return f"{note['detail']} ({note['count']})" if note["count"] > 1 else str(note["detail"])
