"""Who may ask, from where, how much, and what every answer carries."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import httpx2
import pytest

from tests.api.conftest import TOKEN, ServerProcess, problem


@pytest.fixture
def stranger(server: ServerProcess) -> Iterator[httpx2.Client]:
    """A client that knows nothing."""
    with httpx2.Client(base_url=server.url, timeout=30) as client:
        yield client


def raw(server: ServerProcess, request: bytes) -> bytes:
    """Send bytes as they are and return what comes back before the connection ends or falls silent."""
    where = urlsplit(server.url)
    out = b""
    with socket.create_connection((where.hostname or "", where.port or 0), timeout=5) as connection:
        connection.sendall(request)
        try:
            while chunk := connection.recv(65536):
                out += chunk
                if b"\r\n\r\n" in out and b'"errors"' in out:
                    break
        except TimeoutError:
            pass
    return out


@pytest.mark.parametrize(
    ("header", "code"),
    [
        (None, "token_required"),
        ("Bearer wrong", "token_wrong"),
        ("Bearer", "token_wrong"),
        (f"Basic {TOKEN}", "token_required"),
        (f"Bearer {TOKEN}x", "token_wrong"),
        (f"Bearer {TOKEN[:-1]}", "token_wrong"),
    ],
)
@pytest.mark.parametrize("path", ["/api/v1/runs", "/api/v1/events", "/api/v1/nothing", "/api"])
def test_api_needs_the_token(stranger: httpx2.Client, path: str, header: str | None, code: str) -> None:
    answer = stranger.get(path, headers={} if header is None else {"Authorization": header})
    problem(answer, 401, code)
    assert answer.headers["www-authenticate"].startswith("Bearer")


@pytest.mark.parametrize("path", ["/", "/healthz", "/readyz", "/openapi.json", "/docs", "/problems", "/js/main.js"])
def test_what_tells_nothing_of_the_data_is_open(stranger: httpx2.Client, path: str) -> None:
    # Workers may still be coming up, which /readyz says with 503; nothing else may.
    allowed = {200, 503} if path == "/readyz" else {200}
    assert stranger.get(path).status_code in allowed


def test_token_in_the_address_becomes_a_cookie(stranger: httpx2.Client, server: ServerProcess) -> None:
    swap = stranger.get("/", params={"token": TOKEN})
    assert swap.status_code == 303
    assert swap.headers["location"] == "./"
    assert swap.headers["cache-control"] == "no-store"
    cookie = swap.headers["set-cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=strict" in cookie
    assert TOKEN not in cookie
    instance = (server.data / "instance").read_text().strip()
    assert cookie.startswith(f"filterroom_{instance}=")
    assert stranger.get("/api/v1/runs").status_code == 200


def test_wrong_token_in_the_address_gives_no_cookie(stranger: httpx2.Client) -> None:
    swap = stranger.get("/", params={"token": "wrong"})
    assert swap.status_code == 303
    assert "set-cookie" not in swap.headers


def test_cookie_among_foreign_ones_is_found(stranger: httpx2.Client) -> None:
    cookie = stranger.get("/", params={"token": TOKEN}).headers["set-cookie"].split(";")[0]
    answer = stranger.get("/api/v1/runs", headers={"Cookie": f'other={{"a": 1}}; {cookie}; last=é'.encode()})
    assert answer.status_code == 200
    assert stranger.get("/api/v1/runs", headers={"Cookie": cookie + "0"}).status_code == 401


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "localhost@evil.example", "", "localhost.evil.example:80", "::1"],
)
def test_foreign_host_is_refused(server: ServerProcess, host: str) -> None:
    answer = raw(server, f"GET /healthz HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n".encode())
    assert answer.startswith(b"HTTP/1.1 400 ")
    if b"host_not_allowed" in answer:
        assert b"FILTERROOM_ALLOWED_HOSTS" in answer
        assert b"application/problem+json" in answer


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1:8000", "[::1]:9", "radar.example", "LOCALHOST"])
def test_own_names_are_accepted(stranger: httpx2.Client, host: str) -> None:
    assert stranger.get("/healthz", headers={"Host": host}).status_code == 200


@pytest.mark.parametrize(
    ("headers", "allowed"),
    [
        ({"Sec-Fetch-Site": "cross-site"}, False),
        ({"Sec-Fetch-Site": "same-site"}, False),
        ({"Sec-Fetch-Site": "same-origin"}, True),
        ({"Sec-Fetch-Site": "none"}, True),
        ({"Origin": "http://evil.example"}, False),
        ({"Origin": "null"}, False),
        ({}, True),
    ],
)
def test_change_asked_by_another_site_is_refused(
    stranger: httpx2.Client, headers: dict[str, str], allowed: bool
) -> None:
    stranger.get("/", params={"token": TOKEN})
    answer = stranger.post("/api/v1/runs", json={}, headers=headers)
    if allowed:
        problem(answer, 422, "source_missing")
    else:
        problem(answer, 403, "cross_site")
    assert stranger.get("/api/v1/runs", headers=headers).status_code == 200, "reading is for CORS to refuse"


def test_own_origin_of_an_old_browser_is_accepted(stranger: httpx2.Client, server: ServerProcess) -> None:
    stranger.get("/", params={"token": TOKEN})
    problem(stranger.post("/api/v1/runs", json={}, headers={"Origin": server.url}), 422, "source_missing")


def test_no_other_origin_is_let_in(api: httpx2.Client) -> None:
    answer = api.get("/api/v1/runs", headers={"Origin": "http://evil.example"})
    assert not [h for h in answer.headers if h.startswith("access-control-")]


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("GET", "/"),
        ("GET", "/healthz"),
        ("GET", "/api/v1/runs"),
        ("GET", "/api/v1/nothing"),
        ("GET", "/nothing"),
        ("POST", "/healthz"),
        ("GET", "/docs"),
        ("GET", "/js/main.js"),
    ],
)
def test_every_answer_carries_the_headers(api: httpx2.Client, method: str, path: str) -> None:
    headers = api.request(method, path).headers
    assert headers["content-security-policy"].startswith("default-src 'none'; script-src 'self'")
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cross-origin-opener-policy"] == "same-origin"
    assert headers["cache-control"]
    assert "server" not in headers


def test_claimed_length_is_refused_before_anything_is_read(server: ServerProcess) -> None:
    head = (
        f"POST /api/v1/recordings HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {TOKEN}\r\n"
        "Content-Type: application/octet-stream\r\nContent-Length: 10000000000\r\n\r\n"
    )
    answer = raw(server, head.encode())
    assert answer.startswith(b"HTTP/1.1 413 ")
    assert b"FILTERROOM_MAX_UPLOAD_BYTES" in answer
    assert b"application/problem+json" in answer


@pytest.mark.parametrize(
    ("path", "media_type", "size", "setting"),
    [
        ("/api/v1/recordings", "application/octet-stream", 17 * 2**20, "FILTERROOM_MAX_UPLOAD_BYTES"),
        ("/api/v1/recordings", "application/json", 2**20 + 1, "FILTERROOM_MAX_JSON_BYTES"),
        ("/api/v1/runs", "application/json", 2**20 + 1, "FILTERROOM_MAX_JSON_BYTES"),
    ],
)
def test_body_that_grows_too_large_is_refused(
    api: httpx2.Client, server: ServerProcess, path: str, media_type: str, size: int, setting: str
) -> None:
    def chunks() -> Iterator[bytes]:
        for _ in range(size // 65536 + 1):
            yield b"1" * 65536

    try:
        answer = api.post(path, content=chunks(), headers={"Content-Type": media_type})
    except (httpx2.WriteError, httpx2.ReadError, httpx2.RemoteProtocolError):
        # The server closed the connection while we were still sending; the answer is lost with it.
        pass
    else:
        assert setting in problem(answer, 413, "too_large")["detail"]
    assert api.get("/healthz").status_code == 200
    assert not list((server.data / "store" / "tmp").iterdir())


def test_token_never_reaches_the_log(stranger: httpx2.Client, server: ServerProcess) -> None:
    stranger.get("/", params={"token": TOKEN})
    assert TOKEN not in server.log.read_text()


def test_secrets_are_readable_by_their_owner_only(server: ServerProcess) -> None:
    assert (server.data / "instance").stat().st_mode & 0o077 == 0


@pytest.mark.parametrize("path", ["/../pyproject.toml", "/..%2fpyproject.toml", "/js/..%2f..%2fpyproject.toml"])
def test_page_folder_is_not_left(server: ServerProcess, path: str) -> None:
    answer = raw(server, f"GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n".encode())
    assert answer.startswith(b"HTTP/1.1 404 ")


def test_unreadable_json_is_said_so(api: httpx2.Client) -> None:
    json_type: dict[str, Any] = {"Content-Type": "application/json"}
    problem(api.post("/api/v1/runs", content=b"{", headers=json_type), 400, "malformed_json")
    problem(api.post("/api/v1/runs", content=b"\xff\xfe", headers=json_type), 400, "malformed_json")
    deep = b'{"algorithms":' + b"[" * 100_000
    assert api.post("/api/v1/runs", content=deep, headers=json_type).status_code in (400, 422)
    problem(
        api.post("/api/v1/runs", content=b"{}", headers={"Content-Type": "text/plain"}), 415, "unsupported_media_type"
    )
    problem(api.post("/api/v1/runs", content=b"{}"), 415, "unsupported_media_type")
    problem(api.post("/api/v1/recordings", content=b"{}"), 415, "unsupported_media_type")
    nan = b'{"recording_id":"x","algorithms":[{"name":"rdf","parameters":{"sigma_toa_ns":NaN}}]}'
    assert api.post("/api/v1/runs", content=nan, headers=json_type).status_code == 422
