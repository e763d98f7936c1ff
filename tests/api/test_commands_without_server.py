"""`filterroom run` and `filterroom study`: files in, files out, exit statuses; nothing but the command is started."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from backend.cli import main

ROOT = Path(__file__).parents[2]
SAMPLE = ROOT / "examples" / "recordings"
MARKS, SITE = str(SAMPLE / "sample_marks.csv"), str(SAMPLE / "sample_site.json")
STUDY = "multilateration_figure_3"


def said(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    """What was printed for scripts: exactly one object and nothing beside it."""
    captured = capsys.readouterr()
    assert captured.err == ""
    found = json.loads(captured.out)
    assert isinstance(found, dict)
    return found


def test_a_run_writes_tables_charts_and_its_account(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "results"
    arguments = ["run", "single_mark", MARKS, "--site", SITE, "--set", "sigma_altitude_m=125", "--out", str(out)]
    assert main(arguments) == 0
    printed = capsys.readouterr()
    assert "1193 rows read, 1193 accepted" in printed.out
    assert "rms_horizontal_m" in printed.out
    assert printed.err == "", "no bar where the standard error is not a terminal"
    about = json.loads((out / "run.json").read_text(encoding="utf-8"))
    assert about["settings"]["sigma_altitude_m"] == {"value": 125, "source": "run"}
    states = pq.read_table(out / "tables" / "states.parquet")
    rows = (out / "tables" / "states.csv").read_text(encoding="utf-8").splitlines()
    assert states.num_rows == len(rows) - 1 == 1193
    assert states.column_names == rows[0].split(",")
    with np.load(out / "result.npz", allow_pickle=False) as arrays:
        assert len(arrays["single_mark/state"]) == 1193
    page = (out / "charts" / "plan.html").read_text(encoding="utf-8")
    assert "Plotly.newPlot" in page
    report = (out / "report.html").read_text(encoding="utf-8")
    assert about["recording"]["files"][0]["sha256"] in report
    assert f"{about['summary']['rms_horizontal_m']['single_mark']['value']:.0f}" in report
    assert report.count('type="application/json"') == len(list((out / "charts").iterdir()))
    assert {"result.npz", "run.json", "report.html", "tables", "charts"} == {path.name for path in out.iterdir()}


def test_the_pages_of_a_run_in_russian(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "results"
    assert main(["run", "single_mark", MARKS, "--site", SITE, "--language", "ru", "--out", str(out)]) == 0
    assert "1193 rows read" in capsys.readouterr().out, "what scripts look for on the terminal stays"
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "прочитано 1193, принято 1193, отклонено 0" in report
    assert '<html lang="ru">' in (out / "charts" / "plan.html").read_text(encoding="utf-8")
    with pytest.raises(SystemExit):
        main(["run", "single_mark", MARKS, "--language", "xx"])


def test_a_script_gets_the_same_numbers(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "single_mark", MARKS, "--site", SITE, "--json"]) == 0
    found = said(capsys)
    assert found["recording"]["rows"] == {"read": 1193, "accepted": 1193, "rejected": 0}  # type: ignore[index]
    assert 0.5 < found["summary"]["answered_share"]["single_mark"]["value"] < 0.6  # type: ignore[index]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["nonsense", MARKS], "rdfv"),
        (["rdfv", MARKS, "--set", "sigma_altitude=1"], "sigma_altitude_m"),
        (["rdfv", MARKS, "--set", "sigma_altitude_m=wide"], "sigma_altitude_m"),
        (["rdfv", MARKS, "--set", "sigma_altitude_m=NaN"], "sigma_altitude_m"),
        (["rdfv", MARKS, "--set", "sigma_altitude_m"], "name=value"),
        (["rdfv", MARKS, "--set", "earth=sphere", "--set", "earth=wgs84"], "twice"),
        (["rdfv", MARKS, "--read", "colour=red"], "mapping"),
        (["rdfv", MARKS, "--read", "kind=sounds"], "kind"),
        (["rdfv", MARKS, "--seed", "-1"], "--seed"),
        (["rdfv", MARKS, "--out", MARKS], "is a file"),
        (["rdfv", MARKS, "--out", str(SAMPLE)], "--overwrite"),
    ],
)
def test_wrong_usage_of_a_run(arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", *arguments]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert word in captured.err
    assert main(["run", *arguments, "--json"]) == 2
    assert said(capsys)["error"]["code"] == "usage"  # type: ignore[index]


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "empty_file"),
        (b"\x00\x01\x02\xff" * 400, "unsupported_format"),
        (b"one,two\n1,2\n", "unsupported_format"),
        (b"time_s,toa_a_ns,toa_b_ns\n", "no_rows"),
    ],
)
def test_a_broken_file_fails(tmp_path: Path, content: bytes, code: str, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "broken.csv", tmp_path / "results"
    path.write_bytes(content)
    assert main(["run", "rdf", str(path), "--json", "--out", str(out)]) == 1
    assert said(capsys)["error"]["code"] == code  # type: ignore[index]
    assert list(out.iterdir()) == []


def test_what_a_run_lacks_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "rdf", str(tmp_path / "missing.csv"), "--json"]) == 1
    assert "missing.csv" in said(capsys)["error"]["detail"]  # type: ignore[index]
    assert main(["run", "rdf", MARKS, "--json"]) == 1
    assert said(capsys)["error"]["code"] == "site_missing"  # type: ignore[index]
    plots = tmp_path / "plots.csv"
    plots.write_text("time_s,range_m,azimuth_deg\n0,1000,10\n4,1100,11\n", encoding="utf-8")
    assert main(["run", "rdf", str(plots), "--json"]) == 1
    assert said(capsys)["error"]["code"] == "kind_mismatch"  # type: ignore[index]


def test_rejected_rows_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = Path(MARKS).read_text(encoding="utf-8").splitlines()
    path, out = tmp_path / "marks.csv", tmp_path / "results"
    path.write_text("\n".join([*lines[:400], "soon,1,2,3", *lines[400:]]), encoding="utf-8")
    assert main(["run", "single_mark", str(path), "--site", SITE, "--out", str(out)]) == 0
    assert "row 400 of marks.csv: line 401: 4 cells" in capsys.readouterr().out
    header, row = (out / "tables" / "rejections.csv").read_text(encoding="utf-8").splitlines()
    assert header == "row,code,detail,file"
    assert row.startswith("400,")


def test_wrong_usage_of_a_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "nonsense", "--json"]) == 2
    assert STUDY in said(capsys)["error"]["detail"]  # type: ignore[index]
    assert main(["study", STUDY, "--trials", "0"]) == 2
    assert "--trials" in capsys.readouterr().err
    assert main(["study", STUDY, "--workers", "0"]) == 2
    assert "--workers" in capsys.readouterr().err


@pytest.mark.slow
def test_a_study_is_judged_and_does_not_depend_on_the_processes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = []
    for workers in ("1", "2"):
        out = tmp_path / workers
        assert main(["study", STUDY, "--trials", "65", "--workers", workers, "--json", "--out", str(out)]) == 0
        assert STUDY in (out / "report.html").read_text(encoding="utf-8")
        found = said(capsys)
        assert len(found["claims"]) == 4  # type: ignore[arg-type]
        assert {"tables/claims.csv", "charts/trials_sweep.html", "result.npz"} <= set(found["files"])  # type: ignore[call-overload]
        results.append((out / "result.npz").read_bytes())
    assert results[0] == results[1]


@pytest.mark.slow
def test_an_interrupted_study_leaves_nothing(tmp_path: Path) -> None:
    out = tmp_path / "results"
    command = [sys.executable, "-m", "backend.cli", "study", STUDY, "--trials", "20000", "--json", "--out", str(out)]
    running = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 60
        while not children_of(running.pid):
            assert time.monotonic() < deadline
            time.sleep(0.1)
        time.sleep(1)
        started = children_of(running.pid)
        running.send_signal(signal.SIGINT)
        printed, errors = running.communicate(timeout=30)
    finally:
        running.kill()
    assert running.returncode == 1
    assert json.loads(printed)["error"]["code"] == "interrupted"
    assert "Traceback" not in errors
    assert list(out.iterdir()) == []
    deadline = time.monotonic() + 10
    while any(computing(pid) for pid in started):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def computing(pid: str) -> bool:
    """Whether a process is there and not merely waiting to be buried."""
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


def children_of(pid: int) -> list[str]:
    """Processes that a process has started."""
    return Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
