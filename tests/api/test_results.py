"""Tables, charts and the result file of a run."""

from __future__ import annotations

import csv
import io
from typing import Any

import httpx2
import numpy as np
import pytest

from tests.api.conftest import problem

COLUMNS = {
    "states": "label,trial,track,time_s,east_m,north_m,up_m,velocity_east_mps,velocity_north_mps,velocity_up_mps,"
    "acceleration_east_mps2,acceleration_north_mps2,acceleration_up_mps2,sigma_east_m,sigma_north_m,sigma_up_m,"
    "drms_m,nis,dof,status,used",
    "errors": "label,trial,track,target,time_s,error_east_m,error_north_m,error_up_m,error_horizontal_m,"
    "error_velocity_mps",
    "tracks": "label,track,target,state,start_s,end_s,updates,misses,reason",
    "decisions": "label,track,row,time_s,decision,distance,threshold,probability,reason",
    "metrics": "metric,label,segment,target,value,ci95_low,ci95_high,unit,n",
}


@pytest.fixture(scope="session")
def results(run: dict[str, Any]) -> str:
    """The address of a finished run."""
    return f"/api/v1/runs/{run['id']}"


def test_tables_have_the_promised_columns(api: httpx2.Client, results: str) -> None:
    items = {t["name"]: t for t in api.get(f"{results}/tables").json()["items"]}
    assert set(COLUMNS) <= set(items)
    for name, promised in COLUMNS.items():
        columns = promised.split(",")
        table = api.get(items[name]["json_url"]).json()
        assert table["columns"][: len(columns)] == columns
        assert table["total"] == len(table["rows"]) == items[name]["rows"]


@pytest.mark.parametrize("name", COLUMNS)
def test_csv_and_json_hold_the_same(api: httpx2.Client, results: str, name: str) -> None:
    table = api.get(f"{results}/tables/{name}.json").json()
    answer = api.get(f"{results}/tables/{name}.csv")
    assert answer.headers["content-type"] == "text/csv; charset=utf-8"
    header, *rows = list(csv.reader(io.StringIO(answer.text)))
    assert header == table["columns"]
    assert len(rows) == table["total"]
    for text, plain in zip(rows, table["rows"], strict=True):
        for cell, value in zip(text, plain, strict=True):
            if value is None or isinstance(value, str):
                assert cell == (value or "")
            else:
                assert float(cell) == value


def test_part_of_a_table(api: httpx2.Client, results: str) -> None:
    url = f"{results}/tables/states.json"
    whole = api.get(url).json()
    part = api.get(url, params={"offset": 5, "limit": 3}).json()
    assert part["rows"] == whole["rows"][5:8]
    assert part["total"] == whole["total"]
    assert api.get(url, params={"offset": 10**9}).json()["rows"] == []
    assert len(api.get(f"{results}/tables/states.csv?offset=5&limit=3").text.splitlines()) == 4
    assert len(api.get(f"{results}/tables/states.csv?offset=1000000000").text.splitlines()) == 1
    problem(api.get(url, params={"limit": 0}), 422, "validation", "/query/limit")


def test_labels_of_tables_are_those_of_the_run(api: httpx2.Client, results: str) -> None:
    table = api.get(f"{results}/tables/states.json").json()
    assert list(dict.fromkeys(row[0] for row in table["rows"])) == ["rdf", "rdfv 50 m"]


def test_errors_give_the_headline(api: httpx2.Client, results: str, run: dict[str, Any]) -> None:
    table = api.get(f"{results}/tables/errors.json").json()
    label, error = (table["columns"].index(c) for c in ("label", "error_horizontal_m"))
    errors = np.array([r[error] for r in table["rows"] if r[label] == "rdf" and r[error] is not None])
    headline = run["summary"]["rms_horizontal_m"]["rdf"]["value"]
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(headline, rel=1e-9)


def test_unknown_table_and_suffix(api: httpx2.Client, results: str) -> None:
    problem(api.get(f"{results}/tables/none.json"), 404, "table_not_found")
    problem(api.get(f"{results}/tables/none.csv"), 404, "table_not_found")
    problem(api.get(f"{results}/tables/states.xlsx"), 404, "not_found")
    problem(api.get(f"{results}/result.pickle"), 404, "not_found")


def test_result_file_opens_without_pickle_and_never_changes(api: httpx2.Client, results: str) -> None:
    answer = api.get(f"{results}/result.npz")
    with np.load(io.BytesIO(answer.content), allow_pickle=False) as arrays:
        assert {name.split("/")[0] for name in arrays} == {"rdf", "rdfv 50 m", "tables"}
    assert "immutable" in answer.headers["cache-control"]
    etag = answer.headers["etag"]
    assert api.get(f"{results}/result.npz", headers={"If-None-Match": etag}).status_code == 304


def test_every_chart_is_drawn_in_three_forms(api: httpx2.Client, results: str) -> None:
    charts = api.get(f"{results}/charts").json()["items"]
    assert [c["name"] for c in charts[:4]] == ["plan", "drms", "nis", "radial_error"]
    for chart in charts:
        url = f"{results}/charts/{chart['name']}"
        figure = api.get(f"{url}.json")
        assert figure.json()["data"], chart
        # What the marks say of the receivers is the same for every entry.
        labels = {None} if chart["name"] == "receiver_delays" else {"rdf", "rdfv 50 m"}
        assert {t["meta"]["label"] for t in figure.json()["data"]} >= labels, chart
        etag = figure.headers["etag"]
        assert api.get(f"{url}.json", headers={"If-None-Match": etag}).status_code == 304
        rows = api.get(f"{url}.csv")
        assert len(rows.text.splitlines()) > 2
        assert "attachment" in rows.headers["content-disposition"]


def test_chart_page_stands_alone(api: httpx2.Client, results: str) -> None:
    page = api.get(f"{results}/charts/plan.html")
    assert page.headers["content-security-policy"].startswith("sandbox allow-scripts")
    assert "attachment" in page.headers["content-disposition"]
    assert "<script src" not in page.text
    assert len(page.content) > 10**6


def test_decimation_can_be_switched_off(api: httpx2.Client, results: str) -> None:
    few = api.get(f"{results}/charts/drms.json?points=50")
    full = api.get(f"{results}/charts/drms.json?full=true")
    assert few.json()["layout"]["meta"]["decimated"]["shown"] < few.json()["layout"]["meta"]["decimated"]["of"]
    assert "decimated" not in full.json()["layout"]["meta"]
    assert few.headers["etag"] != full.headers["etag"]
    problem(api.get(f"{results}/charts/drms.json?points=1"), 422, "validation", "/query/points")
    problem(api.get(f"{results}/charts/none.json"), 404, "chart_not_found")
    problem(api.get(f"{results}/charts/plan.pdf"), 404, "not_found")
