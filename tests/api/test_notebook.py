"""The client and the notebook of the examples, against a real server."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from tests.api.conftest import TOKEN, ServerProcess


@pytest.fixture(scope="module")
def client(repository: Path) -> ModuleType:
    path = repository / "examples" / "filterroom_client.py"
    specification = importlib.util.spec_from_file_location("filterroom_client", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["filterroom_client"] = module
    specification.loader.exec_module(module)
    return module


def test_the_client_gives_arrays(client: ModuleType, server: ServerProcess, repository: Path) -> None:
    room = client.FilterRoom(server.url, TOKEN)
    samples = repository / "examples" / "recordings"
    recording = room.upload(samples / "sample_marks.csv", site=samples / "sample_site.json", name="of the client")
    assert recording.facts["name"] == "of the client"
    columns = recording.arrays()
    assert len(columns["time_s"]) == recording.facts["rows"]["accepted"]
    assert all(name.startswith("toa_") is name.endswith("_ns") for name in columns)
    seen: list[tuple[int, int]] = []
    run = room.run(
        recording, ["rdf", ("rdfv", {"sigma_altitude_m": 50})], label="client", on_progress=lambda *s: seen.append(s)
    )
    assert seen[-1][0] == seen[-1][1]
    found = run.metric("rms_horizontal_m")
    errors = run.table("errors")
    for label, metric in found.items():
        of = errors["error_horizontal_m"][errors["label"] == label]
        assert np.sqrt(np.nanmean(of**2)) == pytest.approx(metric.value, rel=1e-9)
    assert run.tables()["errors"] == len(errors["label"])
    assert any(name.startswith("rdf/") for name in run.arrays())
    assert room.recording(recording.id).facts["id"] == recording.id


def test_the_client_says_what_is_wrong(client: ModuleType, server: ServerProcess, tmp_path: Path) -> None:
    room = client.FilterRoom(server.url, TOKEN)
    with pytest.raises(client.ProblemError) as e:
        room.post("runs", {"algorithms": [{"name": "nope"}], "recording_id": "none"})
    assert (e.value.status, e.value.code) == (422, "recording_not_found")
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n")
    with pytest.raises(client.ProblemError) as e:
        room.upload(tmp_path / "bad.csv")
    assert e.value.code == "unsupported_format"
    with pytest.raises(client.ProblemError) as e:
        client.FilterRoom(server.url, "wrong").get("meta")
    assert e.value.code == "token_wrong"


RUN = """
import json, sys
import nbformat
from nbclient import NotebookClient

notebook = nbformat.read(sys.argv[1], as_version=4)
NotebookClient(notebook, timeout=300, kernel_name="python3", resources={"metadata": {"path": sys.argv[2]}}).execute()
print(json.dumps(notebook))
"""


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom(server: ServerProcess, repository: Path) -> None:
    examples = repository / "examples"
    environment = {**os.environ, "FILTERROOM_SERVER": server.url, "FILTERROOM_TOKEN": TOKEN}
    command = [sys.executable, "-c", RUN, str(examples / "first_run.ipynb"), str(examples)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stderr
    cells = json.loads(done.stdout.splitlines()[-1])["cells"]
    outputs = ["".join(o.get("text", "") for o in cell["outputs"]) for cell in cells if cell["cell_type"] == "code"]
    tables = [o["data"] for cell in cells if cell["cell_type"] == "code" for o in cell["outputs"] if "data" in o]
    # Both frames of pandas, three algorithms, four lines of the swept trials, the link to the run.
    assert sum("text/html" in data for data in tables) == 2
    assert [len(text.splitlines()) for text in outputs if text] == [3, 4, 1]
    assert outputs[-1].startswith(f"{server.url}/#/runs/")


def test_the_notebook_is_kept_without_outputs(repository: Path) -> None:
    notebook = json.loads((repository / "examples" / "first_run.ipynb").read_text(encoding="utf-8"))
    assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in notebook["cells"])
