"""The report of a run: everything about it on one page that stands alone."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from algorithms.result import Table
from backend.api import uploads
from backend.api.charts import LanguageQuery, chart_entry, charts_of_run, preset_of
from backend.api.measurements import of_run
from backend.api.report_content import about_scenario, counted, report_content
from backend.api.responses import content, problems
from backend.api.services import Services, ServicesDep
from backend.api.tables import finished
from backend.db import runs as stored
from backend.db.recordings import Recording as StoredRecording
from backend.errors import NotFoundError
from backend.http.etag import etag_of, matches, not_modified
from backend.version import program_version

if TYPE_CHECKING:
    from backend.charts.language import Words

router = APIRouter(prefix="/runs/{run_id}", tags=["results"])


@router.get(
    "/report.html",
    name="get_run_report",
    response_class=Response,
    responses=content("text/html", "A page that stands alone, offline") | problems(404, 409),
)
def get_run_report(
    run_id: str, request: Request, services: ServicesDep, query: Annotated[LanguageQuery, Query()]
) -> Response:
    """Tell what was run, on what, and what came out, as a page that needs no server."""
    run = finished(services, run_id)
    etag = etag_of("report", query.language, program_version(), run.id, run.result_sha256 or "", run.label, *run.tags)
    if matches(request, etag):
        return not_modified(etag)
    from backend.charts.html import CONTENT_SECURITY_POLICY
    from backend.charts.language import words_of
    from backend.charts.report import report_page

    words = words_of(query.language)
    return Response(
        report_page(_content(services, run, words), words),
        media_type="text/html; charset=utf-8",
        headers={
            "ETag": etag,
            "Cache-Control": "private, no-cache",
            "Content-Disposition": f'attachment; filename="report-{run_id}.html"',
            "Content-Security-Policy": CONTENT_SECURITY_POLICY,
        },
    )


def _content(services: Services, run: stored.Run, words: Words) -> Any:
    from backend.charts.figure_words import figure_in
    from backend.charts.view import ChartOptions, RunView

    measured = of_run(services, run)
    ids = run.source.get("recording_ids") or [i for i in (measured.recording_id,) if i is not None]
    recordings = [uploads.ready(services, i) for i in ids]
    view = RunView(
        recording=measured.load(),
        entries=tuple(chart_entry(services, run, e, index=i, label=e.label) for i, e in enumerate(run.algorithms)),
        legs=tuple((name, start, stop) for name, start, stop in run.source.get("legs", ())),
        scenario=preset_of(run.source),
    )
    return report_content(
        title=run.label or f"Run {run.id}",
        facts=_facts(run),
        recording=[fact for one in recordings for fact in _about_recording(one)]
        or about_scenario(run.source, run.trials),
        warnings=[counted(w["detail"], w["count"]) for one in recordings for w in one.warnings],
        entries=run.algorithms,
        used=run.entries or (),
        metrics=_table(services, run, "metrics"),
        decisions=_table(services, run, "decisions"),
        figures=[figure_in(chart.draw(view, ChartOptions()), words, chart.name) for chart in charts_of_run(run)],
        software=run.software or {},
        requirements=_table(services, run, "requirements"),
    )


def _facts(run: stored.Run) -> list[tuple[str, str]]:
    seconds = (
        f"{(run.finished_at - run.started_at).total_seconds():.1f} s" if run.finished_at and run.started_at else ""
    )
    return [
        ("Run", run.id),
        ("Algorithms", ", ".join(e.label if e.label == e.name else f"{e.label} ({e.name})" for e in run.algorithms)),
        *([("Tags", ", ".join(run.tags))] if run.tags else []),
        ("Seed", str(run.seed)),
        ("Started", f"{run.created_at.isoformat(timespec='seconds').replace('+00:00', 'Z')}, took {seconds}"),
        ("Result (SHA-256)", run.result_sha256 or ""),
    ]


def _about_recording(recording: StoredRecording) -> list[tuple[str, str]]:
    span = ""
    if recording.time_first_s is not None and recording.time_last_s is not None:
        span = f"{recording.time_first_s:.3f} s to {recording.time_last_s:.3f} s"
    site = recording.site or {}
    places = [
        f"{len(site[field])} {field}"
        for field in ("stations", "radars", "transmitters", "receivers")
        if site.get(field)
    ]
    return [
        ("Name", recording.name),
        ("Kind and format", f"{recording.kind}, {recording.format}"),
        ("Files (SHA-256)", "; ".join(f"{f.name} {f.sha256}" for f in recording.files)),
        (
            "Rows",
            f"{recording.rows_read} read, {recording.rows_accepted} accepted, "
            f"{recording.rows_read - recording.rows_accepted} rejected",
        ),
        ("Times", f"{span}, from {recording.start_utc}" if recording.start_utc else f"{span}, from an unknown start"),
        ("Site", ", ".join(places) or "none"),
        ("Truth", "known" if recording.has_truth else "not known"),
        ("Options", json.dumps(recording.options, ensure_ascii=False) if recording.options else "none"),
    ]


def _table(services: Services, run: stored.Run, name: str) -> Table:
    from backend.jobs.results import load_table

    try:
        return load_table(services.database, services.store, run, name)
    except NotFoundError:
        return Table({})
