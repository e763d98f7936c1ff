"""Several motion models as a person sees them: the sample, a study, Russian on a telephone."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from tests.browser.charts import drawn
from tests.browser.conftest import Server, Visit
from tests.browser.russian import english_left

pytestmark = [pytest.mark.browser, pytest.mark.slow]

LABELS = ("multiple_model", "mma2_122", "switched_kalman", "model_smoother")


def test_the_sample_shows_models_and_the_manoeuvre(visit: Callable[..., Visit], server: Server) -> None:
    run = server.sample_run("before an antenna")["id"]
    visited = visit()
    page = visited.open(f"#/runs/{run}")
    models = drawn(page, "Probabilities of the models")
    names = {t["name"] for t in models.traces(role="series")}
    assert names == {
        *(f"multiple_model, {m}" for m in ("cv_0.5", "gd_1", "ca_0.05", "ca_30")),
        *(f"{label}, {m}" for label in ("mma2_122", "model_smoother") for m in ("cv_0.05", "ca_0.05", "ca_30")),
    }
    for title in ("Speed", "Absolute acceleration"):
        chart = drawn(page, title)
        assert {t["label"] for t in chart.traces(role="series")} == set(LABELS)
        assert chart.traces(role="truth")
    space = drawn(page, "Trajectory in space")
    assert {t["label"] for t in space.traces(role="series")} == set(LABELS)
    assert [t["type"] for t in space.traces(role="truth")] == ["scatter3d"]
    # Where the cursor stands its values are told, with the height.
    page.get_by_role("img", name=re.compile("Speed")).first.press("ArrowRight")
    strip = page.locator("chart-panel", has=page.get_by_role("heading", name="Trajectory in space")).locator(".strip")
    expect(strip).to_contain_text(re.compile(r"multiple_model E .+, N .+, U .+ km"))
    page.get_by_role("tab", name=re.compile("Decisions")).click()
    expect(page.get_by_role("tabpanel")).to_contain_text("unusual")
    visited.assert_clean()


def test_a_study_shows_curves_with_the_bound_and_its_verdicts(visit: Callable[..., Visit], server: Server) -> None:
    study = server.ask("runs", {"study": "multiple_model_figures_1hz", "trials": 64})
    visited = visit()
    page = visited.open(f"#/runs/{study['id']}")
    expect(page.locator(".run-head .state")).to_have_text(re.compile("succeeded"), timeout=180_000)
    up = drawn(page, "Vertical error over trials")
    assert len(up.traces(role="series")) == 6
    assert [t["name"] for t in up.traces(role="bound")] == ["bound, manoeuvre known"]
    for title in ("Vertical velocity error over trials", "Probabilities of the models over trials"):
        drawn(page, title)
    page.get_by_role("tab", name=re.compile("Claims")).click()
    panel = page.get_by_role("tabpanel")
    expect(panel.locator("tbody tr")).to_have_count(4)
    expect(panel).to_contain_text("the scenario was selected for this")
    visited.assert_clean()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_speaks_russian_and_fits_a_telephone(visit: Callable[..., Visit], server: Server, scheme: str) -> None:
    run = server.sample_run("before an antenna")["id"]
    visited = visit(locale="ru-RU", color_scheme=scheme, viewport={"width": 360, "height": 740})
    page = visited.open(f"#/runs/{run}")
    drawn(page, "Вероятности моделей")
    names = (
        *LABELS, "OBJECT", "sample_antenna", "Sample: ballistic arc and a manoeuvre before an antenna", "sample",
        "cv_0.5", "gd_1", "ca_0.05", "ca_30", "cv_0.05", "antenna",
    )  # fmt: skip
    assert english_left(page, names) == []
    overflow = page.evaluate("() => document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert overflow <= 0
    visited.assert_clean()
