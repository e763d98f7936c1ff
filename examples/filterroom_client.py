"""A small client of Filter Room for notebooks and scripts: upload, run, wait, get NumPy arrays or pandas frames.

One file to copy; it needs NumPy, and pandas only where a frame is asked for.

    from filterroom_client import FilterRoom

    room = FilterRoom()                                     # the server of this machine
    recording = room.upload("marks.csv", site="site.json")
    run = room.run(recording, ["rdf", ("rdfv", {"sigma_altitude_m": 100})])
    run.metric("rms_horizontal_m")["rdf"].value             # a number, with its interval
    run.table("states")["east_m"]                           # an array
    run.frame("states")                                     # a pandas frame

Everything else is one `room.get(path)` away; docs/api.md has the paths.
"""

from __future__ import annotations

import io
import json
import os
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np
from numpy.typing import NDArray

Algorithm = str | tuple[str, Mapping[str, Any]] | Mapping[str, Any]
"""A name; a name with parameters; or an entry as the API takes it, with its own label."""
Progress = Callable[[int, int], None]
Source = str | os.PathLike[str]

_POLL_S = 0.3


class ProblemError(Exception):
    """The server refused: `code` is stable, `errors` name the fields by JSON pointers."""

    def __init__(self, status: int, body: Mapping[str, Any]) -> None:
        super().__init__(f"{body.get('title', 'Error')}: {body.get('detail', '')} ({body.get('code', status)})")
        self.status = status
        self.code = str(body.get("code", ""))
        self.errors: list[dict[str, Any]] = list(body.get("errors", ()))


class RunEndedError(Exception):
    """A run failed or was cancelled."""


class Metric(NamedTuple):
    """A headline number with its 95 % interval, None where that is not known."""

    value: float | None
    low: float | None
    high: float | None
    unit: str


class FilterRoom:
    """A server. The token comes from the argument, FILTERROOM_TOKEN, or the server's own data folder."""

    def __init__(self, server: str | None = None, token: str | None = None) -> None:
        self.server = (server or os.environ.get("FILTERROOM_SERVER") or "http://127.0.0.1:8000").rstrip("/")
        self._token = token or os.environ.get("FILTERROOM_TOKEN") or _token_of_this_machine()

    def get(self, path: str) -> Any:
        """Give the JSON at a path below /api/v1."""
        return json.loads(self.content(path))

    def post(self, path: str, body: Any) -> Any:
        """Send JSON, give JSON."""
        return json.loads(self._sent("POST", path, json.dumps(body).encode(), "application/json"))

    def content(self, path: str) -> bytes:
        """Give the bytes at a path below /api/v1: a table as CSV, a chart as a page, a report."""
        return self._sent("GET", path, None, "")

    def upload(
        self, *files: Source, site: Source | None = None, truth: Source | None = None, **options: Any
    ) -> Recording:
        """Upload files as one recording and wait until it is read; `options` as in docs/api.md (mapping, kind, ...)."""
        parts = [("file", Path(file)) for file in files]
        parts += [(name, Path(path)) for name, path in (("site", site), ("truth", truth)) if path is not None]
        mark = uuid.uuid4().hex
        form = bytearray()
        for name, path in parts:
            label = path.name.replace('"', "_")
            form += f'--{mark}\r\nContent-Disposition: form-data; name="{name}"; filename="{label}"\r\n\r\n'.encode()
            form += path.read_bytes() + b"\r\n"
        form += f'--{mark}\r\nContent-Disposition: form-data; name="options"\r\n\r\n{json.dumps(options)}\r\n'.encode()
        form += f"--{mark}--\r\n".encode()
        found = json.loads(self._sent("POST", "recordings", bytes(form), f"multipart/form-data; boundary={mark}"))
        while found["state"] == "parsing":
            time.sleep(_POLL_S)
            found = self.get(f"recordings/{found['id']}")
        if found["state"] == "failed":
            raise ProblemError(422, found["error"])
        return Recording(self, found)

    def recording(self, recording_id: str) -> Recording:
        """Give a recording that is there."""
        return Recording(self, self.get(f"recordings/{recording_id}"))

    def simulate(
        self, preset: str, parameters: Mapping[str, Any] | None = None, *, seed: int = 0, name: str | None = None
    ) -> Recording:
        """Simulate one recording of a scenario and keep it."""
        asked = {"preset": preset, "parameters": dict(parameters or {}), "seed": seed} | (
            {"name": name} if name else {}
        )
        return Recording(self, self.post("scenarios/recording", asked))

    def run(
        self,
        recordings: Recording | Sequence[Recording],
        algorithms: Sequence[Algorithm],
        *,
        on_progress: Progress | None = None,
        **more: Any,
    ) -> Run:
        """Run algorithms on a recording, or on those of several radars as one; wait until it is done.

        `more`: label, tags, seed. Raises RunEndedError where it fails, ProblemError where it cannot start.
        """
        one = isinstance(recordings, Recording)
        source = {"recording_id": recordings.id} if one else {"recording_ids": [r.id for r in recordings]}
        return self._run({**source, "algorithms": _entries(algorithms), **more}, on_progress)

    def trials(
        self,
        preset: str,
        algorithms: Sequence[Algorithm],
        *,
        parameters: Mapping[str, Any] | None = None,
        on_progress: Progress | None = None,
        **more: Any,
    ) -> Run:
        """Run many trials of a scenario; `more`: trials, seed, sweep, label, tags."""
        scenario = {"preset": preset, "parameters": dict(parameters or {})}
        return self._run({"scenario": scenario, "algorithms": _entries(algorithms), **more}, on_progress)

    def study(self, name: str, *, on_progress: Progress | None = None, **more: Any) -> Run:
        """Reproduce a figure of a paper; `more`: trials, seed. Its verdicts are in the table `claims`."""
        return self._run({"study": name, **more}, on_progress)

    def _run(self, body: Mapping[str, Any], on_progress: Progress | None) -> Run:
        return Run(self, self.post("runs", body)).wait(on_progress=on_progress)

    def _sent(self, method: str, path: str, body: bytes | None, content_type: str) -> bytes:
        headers = {"Authorization": f"Bearer {self._token}"} | ({"Content-Type": content_type} if body else {})
        request = Request(f"{self.server}/api/v1/{path.lstrip('/')}", body, headers, method=method)
        try:
            with urlopen(request) as answer:
                content: bytes = answer.read()
                return content
        except HTTPError as error:
            raise ProblemError(error.code, _body_of(error)) from None


@dataclass(frozen=True)
class Recording:
    """Measurements on the server; `facts` are what the API says of them."""

    room: FilterRoom
    facts: Mapping[str, Any]

    @property
    def id(self) -> str:
        """Id on the server."""
        return str(self.facts["id"])

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Native columns (docs/formats.md) as arrays."""
        return _named(self.room.content(f"recordings/{self.id}/data.npz"))

    def frame(self) -> Any:
        """Native columns as a pandas frame."""
        import pandas as pd

        return pd.read_csv(io.BytesIO(self.room.content(f"recordings/{self.id}/data.csv")))


@dataclass
class Run:
    """A run on the server; `facts` are what the API said of it last."""

    room: FilterRoom
    facts: Mapping[str, Any]

    @property
    def id(self) -> str:
        """Id on the server."""
        return str(self.facts["id"])

    @property
    def link(self) -> str:
        """Where the page shows it."""
        return f"{self.room.server}/#/runs/{self.id}"

    def wait(self, *, timeout_s: float | None = None, on_progress: Progress | None = None) -> Run:
        """Wait until it has succeeded, and return it.

        Raises RunEndedError where it failed or was cancelled, TimeoutError after `timeout_s`; it goes on then.
        """
        end = None if timeout_s is None else time.monotonic() + timeout_s
        while self.facts["state"] in ("queued", "running"):
            if end is not None and time.monotonic() > end:
                raise TimeoutError(f"the run {self.id} is {self.facts['state']} after {timeout_s:g} s")
            time.sleep(_POLL_S)
            self.facts = self.room.get(f"runs/{self.id}")
            if on_progress is not None:
                on_progress(self.facts["progress"]["done"], self.facts["progress"]["total"])
        if self.facts["state"] != "succeeded":
            error = self.facts["error"] or {}
            raise RunEndedError(
                f"the run has {self.facts['state']}: {error.get('detail', '')} {error.get('remedy', '')}".strip()
            )
        return self

    def metric(self, name: str) -> dict[str, Metric]:
        """Give a headline metric of each label."""
        out = {}
        for label, found in self.facts["summary"][name].items():
            low, high = found["ci95"] or (None, None)
            out[label] = Metric(found["value"], low, high, found["unit"])
        return out

    def tables(self) -> dict[str, int]:
        """Names of the tables with their numbers of rows."""
        return {item["name"]: item["rows"] for item in self.room.get(f"runs/{self.id}/tables")["items"]}

    def table(self, name: str) -> dict[str, NDArray[Any]]:
        """Give a table as arrays: numbers with NaN for nothing, texts with None."""
        found = self.room.get(f"runs/{self.id}/tables/{name}.json")
        columns = zip(*found["rows"], strict=True) if found["rows"] else [() for _ in found["columns"]]
        return {name: _array(list(values)) for name, values in zip(found["columns"], columns, strict=True)}

    def frame(self, name: str) -> Any:
        """Give a table as a pandas frame."""
        import pandas as pd

        return pd.DataFrame(self.table(name))

    def arrays(self) -> dict[str, NDArray[Any]]:
        """All arrays of the result: `<label>/<array>`."""
        with np.load(io.BytesIO(self.room.content(f"runs/{self.id}/result.npz")), allow_pickle=False) as found:
            return {name: found[name] for name in found.files}


def _entries(algorithms: Sequence[Algorithm]) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = []
    for one in algorithms:
        if isinstance(one, str):
            out.append({"name": one})
        elif isinstance(one, Mapping):
            out.append(dict(one))
        else:
            name, parameters = one
            out.append({"name": name, "parameters": dict(parameters)})
    return out


def _array(values: list[Any]) -> NDArray[Any]:
    known = [v for v in values if v is not None]
    if known and all(isinstance(v, bool) for v in known) and len(known) == len(values):
        return np.array(values, bool)
    if known and all(isinstance(v, int | float) and not isinstance(v, bool) for v in known):
        whole = len(known) == len(values) and all(isinstance(v, int) for v in known)
        return np.array(values, np.int64) if whole else np.array([np.nan if v is None else v for v in values], float)
    return np.array(values, object)


def _named(archive: bytes) -> dict[str, NDArray[Any]]:
    """Columns of a recording's archive under their own names, which an archive cannot always hold."""
    with np.load(io.BytesIO(archive), allow_pickle=False) as found:
        spelled = {str(a): str(b) for a, b in found["column_names"]}
        return {own: found[name] for name, own in spelled.items()}


def _body_of(error: HTTPError) -> Mapping[str, Any]:
    try:
        body = json.loads(error.read())
    except ValueError:
        return {"title": error.reason}
    return body if isinstance(body, dict) else {"title": error.reason}


def _token_of_this_machine() -> str:
    folder = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "filterroom"
    try:
        return (folder / "token").read_text(encoding="utf-8").strip()
    except OSError:
        raise LookupError("give the token that `filterroom serve` prints, or set FILTERROOM_TOKEN") from None
