"""What a run and a recording give to other tools, each read by a program that is not ours."""

from __future__ import annotations

import datetime as dt
import io
import json
import re
from collections.abc import Callable
from typing import Any
from xml.etree import ElementTree

import httpx2
import numpy as np
import pyarrow.parquet as pq
import pymap3d
import pytest
import scipy.io

from tests.api.conftest import finished, problem, ready

KML = {"k": "http://www.opengis.net/kml/2.2", "gx": "http://www.google.com/kml/ext/2.2"}
LABELS = ("rdf", "rdfv 50 m")


@pytest.fixture(scope="module")
def results(run: dict[str, Any]) -> str:
    return f"/api/v1/runs/{run['id']}"


@pytest.fixture(scope="module")
def states(api: httpx2.Client, results: str) -> list[dict[str, Any]]:
    table = api.get(f"{results}/tables/states.json").json()
    return [dict(zip(table["columns"], row, strict=True)) for row in table["rows"]]


def test_parquet_and_json_hold_the_same(api: httpx2.Client, results: str) -> None:
    for item in api.get(f"{results}/tables").json()["items"]:
        name = item["name"]
        answer = api.get(f"{results}/tables/{name}.parquet")
        assert answer.headers["content-type"] == "application/vnd.apache.parquet"
        assert f'filename="{name}-' in answer.headers["content-disposition"]
        table = pq.read_table(io.BytesIO(answer.content))
        plain = api.get(f"{results}/tables/{name}.json").json()
        assert table.column_names == plain["columns"]
        assert [list(row.values()) for row in table.to_pylist()] == plain["rows"]


def test_matlab_holds_arrays_and_tables(api: httpx2.Client, results: str, states: list[dict[str, Any]]) -> None:
    answer = api.get(f"{results}/result.mat")
    assert answer.headers["content-type"] == "application/x-matlab-data"
    read = scipy.io.loadmat(io.BytesIO(answer.content), simplify_cells=True)
    with np.load(io.BytesIO(api.get(f"{results}/result.npz").content)) as arrays:
        assert read["labels"].tolist() == [["rdf", "rdf"], ["rdfv_50_m", "rdfv 50 m"]]
        for spelled, label in read["labels"]:
            names = [n.split("/", 1)[1] for n in arrays.files if n.startswith(f"{label}/")]
            assert sorted(read[spelled]) == sorted(names)
            for name in names:
                np.testing.assert_array_equal(read[spelled][name].ravel(), arrays[f"{label}/{name}"].ravel())
    table = read["tables"]["states"]
    np.testing.assert_array_equal(table["time_s"], [row["time_s"] for row in states])
    names = ["", *np.atleast_1d(table["status_names"])]
    assert [names[int(code)] for code in table["status"]] == [row["status"] or "" for row in states]
    assert np.isnan(table["nis"]).sum() == sum(row["nis"] is None for row in states)


def _local(site: dict[str, Any], longitude: Any, latitude: Any, height: Any) -> np.ndarray:
    origin = site["origin"]
    enu = pymap3d.geodetic2enu(
        latitude, longitude, height, origin["latitude_deg"], origin["longitude_deg"], origin.get("height_m", 0)
    )
    return np.stack(enu, axis=1)


def _expected(states: list[dict[str, Any]], label: str, target: str) -> np.ndarray:
    rows = [r for r in states if r["label"] == label and r["target"] == target and r["east_m"] is not None]
    rows.sort(key=lambda r: (r["track"], r["time_s"]))
    return np.array([[r["time_s"], r["east_m"], r["north_m"], r["up_m"]] for r in rows])


def test_geojson_keeps_to_its_standard(
    api: httpx2.Client, results: str, states: list[dict[str, Any]], site: dict[str, Any]
) -> None:
    answer = api.get(f"{results}/tracks.geojson")
    assert answer.headers["content-type"] == "application/geo+json"
    collection = answer.json()
    assert collection["type"] == "FeatureCollection"
    features = collection["features"]
    places = [f for f in features if f["properties"]["role"] == "station"]
    assert [f["properties"]["name"] for f in places] == [s["name"] for s in site["stations"]]
    lines = [f for f in features if f["geometry"]["type"] == "LineString"]
    assert {f["properties"]["role"] for f in lines} == {"truth", "estimate"}
    for feature in features:
        assert set(feature) == {"type", "geometry", "properties"}
        assert feature["type"] == "Feature"
    for line in lines:
        coordinates = np.array(line["geometry"]["coordinates"])
        assert coordinates.shape[0] >= 2
        assert coordinates.shape[1] == 3
        assert (np.abs(coordinates[:, 0]) <= 180).all()
        assert (np.abs(coordinates[:, 1]) <= 90).all()
        assert len(line["properties"]["time_s"]) == len(coordinates)
    for label in LABELS:
        for target in {r["target"] for r in states}:
            mine = [f for f in lines if f["properties"]["label"] == label and f["properties"]["target"] == target]
            found = np.concatenate([f["geometry"]["coordinates"] for f in mine])
            expected = _expected(states, label, target)
            np.testing.assert_allclose(_local(site, *found.T), expected[:, 1:], atol=0.01)
            times = np.concatenate([f["properties"]["time_s"] for f in mine])
            np.testing.assert_allclose(times, expected[:, 0], atol=1e-6)


def test_one_target_alone_is_exported(
    api: httpx2.Client, results: str, run: dict[str, Any], states: list[dict[str, Any]]
) -> None:
    names = {row["target"] for row in states}
    assert len(names) == 2
    chosen = min(names)
    table = pq.read_table(io.BytesIO(api.get(f"{results}/tables/states.parquet?target={chosen}").content))
    assert table.to_pylist() == [row for row in states if row["target"] == chosen]
    tracks = api.get(f"{results}/tracks.geojson?target={chosen}").json()["features"]
    assert {f["properties"]["target"] for f in tracks if f["properties"]["role"] != "station"} == {chosen}
    assert {f["properties"]["role"] for f in tracks} >= {"truth", "estimate"}
    globe, whole = (api.get(f"{results}/tracks.kml{query}").content for query in (f"?target={chosen}", ""))
    assert 0 < globe.count(b"<gx:Track>") < whole.count(b"<gx:Track>")
    for name in ("tables/states.parquet", "tracks.geojson", "tracks.kml"):
        problem(api.get(f"{results}/{name}?target=nobody"), 422, "unknown_target")
    problem(api.get(f"{results}/tables/receivers.parquet?target={chosen}"), 422, "table_without_targets")


def test_kml_can_be_played(
    api: httpx2.Client, results: str, states: list[dict[str, Any]], site: dict[str, Any]
) -> None:
    answer = api.get(f"{results}/tracks.kml")
    assert answer.headers["content-type"] == "application/vnd.google-earth.kml+xml"
    document = ElementTree.fromstring(answer.content).find("k:Document", KML)
    assert document is not None
    assert "not known" in document.findtext("k:description", "", KML)
    folders = {f.findtext("k:name", "", KML): f for f in document.findall("k:Folder", KML)}
    assert set(folders) == {"Stations", "Truth", *LABELS}
    styles = {f"#{s.get('id')}" for s in document.findall("k:Style", KML)}
    start = dt.datetime(1970, 1, 1, tzinfo=dt.UTC)
    for label in LABELS:
        for target in {r["target"] for r in states}:
            tracks = [p for p in folders[label].findall("k:Placemark", KML) if p.findtext("k:name", "", KML) == target]
            assert {p.findtext("k:styleUrl", "", KML) for p in tracks} <= styles
            expected = _expected(states, label, target)
            found = [p.find("gx:Track", KML) for p in tracks]
            whens = [w.text for t in found if t is not None for w in t.findall("k:when", KML)]
            seconds = [(dt.datetime.fromisoformat(w or "") - start).total_seconds() for w in whens]
            np.testing.assert_allclose(seconds, expected[:, 0], atol=6e-4)
            places = [(c.text or "").split() for t in found if t is not None for c in t.findall("gx:coord", KML)]
            np.testing.assert_allclose(_local(site, *np.array(places, float).T), expected[:, 1:], atol=0.01)


def test_tracks_of_a_frame_without_a_place(
    api: httpx2.Client, upload: Callable[..., httpx2.Response], site: dict[str, Any]
) -> None:
    local = {k: v for k, v in site.items() if k != "origin"}
    recording = upload("no origin", site=local).json()
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}
    run = finished(api, api.post("/api/v1/runs", json=body).raise_for_status().headers["location"])
    for name in ("tracks.geojson", "tracks.kml"):
        found = problem(api.get(f"/api/v1/runs/{run['id']}/{name}"), 422, "origin_missing")
        assert "option origin" in found["detail"]


def test_the_report_stands_alone(api: httpx2.Client, results: str, run: dict[str, Any]) -> None:
    answer = api.get(f"{results}/report.html")
    assert answer.headers["content-type"] == "text/html; charset=utf-8"
    assert answer.headers["content-disposition"].startswith("attachment")
    assert "sandbox allow-scripts" in answer.headers["content-security-policy"]
    page = answer.text
    # The library holds addresses of map services as texts; nothing else may.
    own = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert re.findall(r"(?:src|href)=", own) == []
    for word in (run["result_sha256"], "rdfv 50 m", "rms_horizontal_m", "sample.csv", "downweighted", "numba"):
        assert word in own, word
    for reference in run["references"]:
        assert reference["text"].split(" (")[0].replace("&", "&amp;") in own
    figures = re.findall(r'<script type="application/json" id="figure\d+">(.*?)</script>', page)
    charts = api.get(f"{results}/charts").json()["items"]
    titles = {json.loads(f)["layout"]["title"]["text"] for f in figures}
    assert titles
    assert len(figures) <= len(charts)
    assert own.count('class="chart"') == len(figures)


def test_the_report_and_charts_speak_the_language_of_the_page(api: httpx2.Client, results: str) -> None:
    page = api.get(f"{results}/report.html?language=ru").raise_for_status()
    assert '<html lang="ru">' in page.text
    for word in ("<h2>Измерения</h2>", "Плановая ошибка, СКО", "Начальное число", "rdfv 50 m"):
        assert word in page.text, word
    assert "<h2>Results</h2>" not in page.text
    assert page.headers["etag"] != api.get(f"{results}/report.html").headers["etag"]
    chart = api.get(f"{results}/charts/plan.html?language=ru").raise_for_status()
    assert '<html lang="ru">' in chart.text
    assert "км на восток" in chart.text
    problem(api.get(f"{results}/report.html?language=xx"), 422, "validation")
    problem(api.get(f"{results}/charts/plan.json?language=ru"), 422, "validation")


@pytest.mark.parametrize("name", ["tables/states.parquet", "result.mat", "tracks.geojson", "tracks.kml", "report.html"])
def test_exports_are_not_sent_twice(api: httpx2.Client, results: str, name: str) -> None:
    etag = api.get(f"{results}/{name}").headers["etag"]
    assert api.get(f"{results}/{name}", headers={"If-None-Match": etag}).status_code == 304
    problem(api.get(f"{results}/{name}?nothing=1"), 422, "validation")


@pytest.mark.parametrize(("form", "reader"), [("parquet", "parquet"), ("mat", "matlab"), ("npz", "numpy")])
def test_a_recording_comes_back(
    api: httpx2.Client, recording: dict[str, Any], site: dict[str, Any], form: str, reader: str
) -> None:
    whole = api.get(f"/api/v1/recordings/{recording['id']}/data.{form}")
    assert whole.status_code == 200
    files = [("file", (f"again.{form}", whole.content)), ("site", ("site.json", json.dumps(site).encode()))]
    back = ready(api, api.post("/api/v1/recordings", files=files).headers["location"])
    assert (back["format"], back["rows"], back["has_truth"]) == (reader, recording["rows"], recording["has_truth"])
    assert back["warnings"] == recording["warnings"]
    one, other = (api.get(f"/api/v1/recordings/{r['id']}/data.csv").text for r in (recording, back))
    assert one == other


def test_true_paths_of_a_recording_are_read_as_its_truth(api: httpx2.Client, recording: dict[str, Any]) -> None:
    problem(api.get(f"/api/v1/recordings/{recording['id']}/truth.csv"), 404, "no_true_paths")
    plots = "time_s,range_m,azimuth_deg,target\n1.5,1000,45,A\n4.5,1100,46,A\n"
    paths = "".join(f"{t},A,{700 + 10 * t},{710 - t},100\n" for t in range(7))
    head = "time_s,target,true_east_m,true_north_m,true_up_m\n"
    files = [("file", ("plots.csv", plots)), ("truth", ("paths.csv", head + paths))]
    one = api.post("/api/v1/recordings", files=files, data={"options": json.dumps({"name": "with paths"})}).json()
    at = f"/api/v1/recordings/{one['id']}"
    assert api.get(f"{at}/truth.csv").text.splitlines()[1] == "0.0,A,700.0,710.0,100.0"
    assert pq.read_table(io.BytesIO(api.get(f"{at}/truth.parquet").content)).num_rows == 7
    struct = scipy.io.loadmat(io.BytesIO(api.get(f"{at}/truth.mat").content), simplify_cells=True)["recording"]
    assert struct["true_east_m"].tolist() == [700 + 10 * t for t in range(7)]
    for form in ("csv", "parquet", "mat"):
        back = [("file", (f"d.{form}", api.get(f"{at}/data.{form}").content))]
        back += [("truth", (f"t.{form}", api.get(f"{at}/truth.{form}").content))]
        again = api.post("/api/v1/recordings", files=back, data={"options": json.dumps({"name": form})}).json()
        # The same paths give the same truth at the times of the plots.
        assert api.get(f"/api/v1/recordings/{again['id']}/data.csv").text == api.get(f"{at}/data.csv").text
        assert api.get(f"/api/v1/recordings/{again['id']}/truth.csv").text == api.get(f"{at}/truth.csv").text
