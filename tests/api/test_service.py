"""Addresses that are not there, methods that are not possible, the page, the description, health, events."""

from __future__ import annotations

import gzip
import json
import re
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import pytest

from backend.app import api_description
from backend.http.problem_codes import PROBLEMS
from tests.api.conftest import ServerProcess, finished, problem


@pytest.mark.parametrize("accept", ["*/*", "text/html,application/xhtml+xml"])
@pytest.mark.parametrize(
    "path", ["/api", "/api/", "/api/v1/nope", "/api/v2/runs", "/api/v1/runs/", "/nope", "/js/nope.js"]
)
def test_unknown_address_is_a_problem_for_browsers_too(api: httpx2.Client, path: str, accept: str) -> None:
    problem(api.get(path, headers={"Accept": accept}), 404, "not_found")


def test_unknown_address_has_no_method(api: httpx2.Client) -> None:
    problem(api.post("/api/v1/nope"), 404, "not_found")
    problem(api.delete("/nope"), 404, "not_found")


@pytest.mark.parametrize(
    ("method", "path", "allow"),
    [
        ("PUT", "/api/v1/runs", "GET, POST"),
        ("DELETE", "/api/v1/recordings", "GET, POST"),
        ("POST", "/api/v1/runs/x", "GET, PATCH, DELETE"),
        ("GET", "/api/v1/runs/x/cancel", "POST"),
        ("POST", "/api/v1/runs/x/tables/states.csv", "GET"),
        ("POST", "/healthz", "GET"),
        ("POST", "/js/main.js", "GET, HEAD"),
        ("POST", "/api/v1/algorithms/rdf", "GET"),
    ],
)
def test_impossible_method_lists_the_possible_ones(api: httpx2.Client, method: str, path: str, allow: str) -> None:
    answer = api.request(method, path)
    problem(answer, 405, "method_not_allowed")
    assert answer.headers["allow"] == allow


def test_meta_tells_versions_limits_and_engine(api: httpx2.Client) -> None:
    meta = api.get("/api/v1/meta").json()
    assert re.fullmatch(r"\d+\.\d+\.\d+", meta["plotly_js"])
    assert meta["engine"]["workers"] <= 1
    assert meta["limits"]["max_upload_bytes"] == 16 * 2**20
    assert meta["versions"]["numpy"]


def test_server_becomes_ready(api: httpx2.Client, run: dict[str, Any]) -> None:
    assert api.get("/healthz").json() == {"status": "ok"}
    assert api.get("/readyz").json() == {"status": "ready", "detail": ""}


def test_page_is_checked_each_time_and_plotly_kept(api: httpx2.Client) -> None:
    page = api.get("/")
    assert page.headers["content-type"].startswith("text/html")
    assert page.headers["cache-control"] == "no-cache"
    assert api.get("/", headers={"If-None-Match": page.headers["etag"]}).status_code == 304
    version = api.get("/api/v1/meta").json()["plotly_js"]
    url = f"/assets/plotly-{version}.min.js"
    with api.stream("GET", url, headers={"Accept-Encoding": "gzip"}) as packed:
        assert packed.headers["content-encoding"] == "gzip"
        assert "immutable" in packed.headers["cache-control"]
        script = gzip.decompress(b"".join(packed.iter_raw()))
    plain = api.get(url, headers={"Accept-Encoding": "identity"})
    assert plain.content == script
    alias = api.get("/assets/plotly.min.js")
    assert alias.content == script
    assert alias.headers["cache-control"] == "no-cache"
    assert api.get("/assets/plotly.min.js", headers={"If-None-Match": alias.headers["etag"]}).status_code == 304
    problem(api.get("/assets/plotly-0.0.0.min.js"), 404, "not_found")


def test_documentation_needs_no_network(api: httpx2.Client) -> None:
    page = api.get("/docs").text
    assert "http" not in page.replace("http-equiv", "")
    for address in re.findall(r'(?:src|href)="([^"]+)"', page):
        assert api.get(f"/{address}").status_code == 200


def test_committed_description_is_current(repository: Path) -> None:
    committed = json.loads((repository / "openapi.json").read_text(encoding="utf-8"))
    assert committed == api_description(), "run: uv run filterroom openapi > openapi.json"


def test_served_description_is_the_committed_one(api: httpx2.Client) -> None:
    assert api.get("/openapi.json").json() == api_description()


def test_operations_have_names_of_their_own_and_problems() -> None:
    operations = [(path, method, o) for path, item in api_description()["paths"].items() for method, o in item.items()]
    names = [o["operationId"] for _, _, o in operations]
    assert len(set(names)) == len(names)
    for path, _, operation in operations:
        assert operation["description"], path
        if path.startswith("/api/"):
            assert "401" in operation["responses"], path


def test_every_code_in_the_sources_has_a_page(api: httpx2.Client, repository: Path) -> None:
    literal = re.compile(r'\bcode="([a-z][a-z0-9_]*)"|"code": "([a-z][a-z0-9_]*)"|_fail(?:ure)?\(\s*"([a-z_]+)"')
    used = {
        next(filter(None, found.groups()))
        for folder in ("backend", "algorithms")
        for path in (repository / folder).rglob("*.py")
        for found in literal.finditer(path.read_text(encoding="utf-8"))
    }
    # Codes of single entries of `errors`; the problem around them has its own.
    used -= {"missing", "repeated", "unknown_field"}
    assert used <= set(PROBLEMS), f"without a page: {sorted(used - set(PROBLEMS))}"
    for code in ("run_not_found", "cross_site"):
        assert api.get(f"/problems/{code}").json()["title"] == PROBLEMS[code].title
        assert PROBLEMS[code].title in api.get(f"/problems/{code}", headers={"Accept": "text/html"}).text
    assert len(api.get("/problems").json()["items"]) == len(PROBLEMS)
    problem(api.get("/problems/nope"), 404, "not_found")


def test_titles_tell_kinds_apart() -> None:
    for code, kind in PROBLEMS.items():
        assert re.fullmatch(r"[a-z][a-z0-9_]*", code)
        assert kind.meaning.endswith("."), code
        assert not kind.title.endswith("."), code


def events(answer: httpx2.Response) -> Iterator[dict[str, Any]]:
    """Read events from a stream."""
    event: dict[str, Any] = {}
    for line in answer.iter_lines():
        if not line:
            if "data" in event:
                yield event
            event = {}
        elif not line.startswith(":"):
            name, _, value = line.partition(": ")
            event[name] = json.loads(value) if name == "data" else value


def test_events_of_a_run_tell_its_whole_story_and_end(api: httpx2.Client, recording: dict[str, Any]) -> None:
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}
    location = api.post("/api/v1/runs", json=body).headers["location"]
    with api.stream("GET", f"{location}/events") as answer:
        assert answer.headers["content-type"].startswith("text/event-stream")
        seen = list(events(answer))
    states = [e["data"]["state"] for e in seen if e["event"] == "run.changed"]
    assert states == ["queued", "running", "succeeded"]
    ids = [int(e["id"]) for e in seen]
    assert ids == sorted(set(ids))
    middle = ids[len(ids) // 2]
    with api.stream("GET", f"{location}/events", headers={"Last-Event-ID": str(middle)}) as answer:
        assert [int(e["id"]) for e in events(answer)] == [i for i in ids if i > middle]
    assert api.get(f"{location}/events", headers={"Last-Event-ID": str(ids[-1])}).status_code == 204
    problem(api.get("/api/v1/runs/none/events"), 404, "run_not_found")


def test_stream_of_all_events_begins_now_or_where_it_was_left(api: httpx2.Client, recording: dict[str, Any]) -> None:
    body = {"recording_id": recording["id"], "algorithms": [{"name": "rdf"}]}
    earlier = finished(api, api.post("/api/v1/runs", json=body).headers["location"])
    started: list[str] = []

    def start_later() -> None:
        time.sleep(0.3)
        started.append(api.post("/api/v1/runs", json=body).json()["id"])

    thread = threading.Thread(target=start_later)
    with api.stream("GET", "/api/v1/events") as answer:
        thread.start()
        first = next(e for e in events(answer) if e["event"] == "run.changed")
        thread.join()
        assert first["data"]["id"] == started[0] != earlier["id"]
    with api.stream("GET", "/api/v1/events", headers={"Last-Event-ID": str(int(first["id"]) - 1)}) as answer:
        assert next(events(answer)) == first
    finished(api, f"/api/v1/runs/{started[0]}")


def test_answers_are_compressed(api: httpx2.Client, run: dict[str, Any]) -> None:
    answer = api.get(f"/api/v1/runs/{run['id']}/tables/states.json", headers={"Accept-Encoding": "gzip"})
    assert answer.headers["content-encoding"] == "gzip"


def test_server_answers_while_others_listen(server: ServerProcess) -> None:
    """Streams take no thread each: fifty of them leave the server free."""
    clients = [server.client() for _ in range(50)]
    streams = [c.stream("GET", "/api/v1/events") for c in clients]
    for stream in streams:
        assert stream.__enter__().status_code == 200
    with server.client() as api:
        started = time.monotonic()
        assert api.get("/api/v1/runs").status_code == 200
        assert time.monotonic() - started < 2
    for stream, client in zip(streams, clients, strict=True):
        stream.__exit__(None, None, None)
        client.close()
