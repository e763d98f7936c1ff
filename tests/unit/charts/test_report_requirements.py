"""The report of a run names what was asked of it: failed first, and nothing where nothing can be asked."""

from __future__ import annotations

from backend.charts.report import ReportContent, ReportRequirement, report_page


def page(*requirements: ReportRequirement) -> str:
    content = ReportContent(
        title="A run", facts=(), recording=(), warnings=(), entries=(), metrics=(), figures=(), decisions=(),
        references=(), requirements=requirements,
    )  # fmt: skip
    return report_page(content).decode()


def row(verdict: str, target: str, value: float | None) -> ReportRequirement:
    return ReportRequirement("imm", target, "whole", "rms_horizontal_m", value, 200.0, "m", verdict, 51)


def test_failed_ones_come_first_and_are_counted() -> None:
    text = page(row("passed", "1", 119.0), row("failed", "2", 222.2), row("no data", "<3>", None))
    assert "1 failed, 1 passed, 1 no data." in text
    assert text.index("222.2") < text.index(">119<")
    assert "&lt;3&gt;" in text


def test_a_run_without_requirements_says_nothing_of_them() -> None:
    assert "Requirements" not in page()
