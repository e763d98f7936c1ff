"""Upload a recording with its site, run three algorithms on it, print how good they were. Standard library only.

    python3 examples/run_marks.py [SERVER]          default FILTERROOM_URL, else http://127.0.0.1:8000

The token comes from FILTERROOM_TOKEN, else from the file that the server keeps in its data folder.
"""

import json
import os
import sys
import time
import uuid
from pathlib import Path
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

SAMPLES = Path(__file__).parent / "recordings"
SERVER = (sys.argv[1:] or [os.environ.get("FILTERROOM_URL", "http://127.0.0.1:8000")])[0].rstrip("/")
DATA = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "filterroom"
TOKEN = os.environ.get("FILTERROOM_TOKEN") or (DATA / "token").read_text().strip()


def call(method: str, path: str, body: bytes | None = None, content_type: str = "application/json") -> dict:
    headers = {"Authorization": f"Bearer {TOKEN}", "Content-Type": content_type}
    try:
        with urlopen(Request(f"{SERVER}/api/v1{path}", body, headers, method=method)) as answer:
            return json.load(answer)
    except HTTPError as error:
        problem = json.load(error)
        sys.exit(f"{problem['title']}: {problem['detail']} ({problem['code']})")
    except URLError as error:
        sys.exit(f"No server answers at {SERVER}: {error.reason}")


def upload(**files: Path) -> dict:
    boundary = uuid.uuid4().hex
    parts = [
        f'--{boundary}\r\nContent-Disposition: form-data; name="{field}"; filename="{path.name}"\r\n\r\n'.encode()
        + path.read_bytes()
        for field, path in files.items()
    ]
    body = b"\r\n".join([*parts, f"--{boundary}--\r\n".encode()])
    return call("POST", "/recordings", body, f"multipart/form-data; boundary={boundary}")


recording = upload(file=SAMPLES / "sample_marks.csv", site=SAMPLES / "sample_site.json")
while recording["state"] == "parsing":
    time.sleep(0.5)
    recording = call("GET", f"/recordings/{recording['id']}")
rows = recording["rows"]
print(f"{recording['name']}: {rows['accepted']} of {rows['read']} rows accepted")

wanted = {
    "recording_id": recording["id"],
    "algorithms": [{"name": name} for name in ("single_mark", "rdf", "rdfv")],
    "label": "examples/run_marks.py",
}
run = call("POST", "/runs", json.dumps(wanted).encode())
while run["state"] in ("queued", "running"):
    time.sleep(0.5)
    run = call("GET", f"/runs/{run['id']}")
if run["state"] != "succeeded":
    sys.exit(f"the run has {run['state']}: {run['error']}")

for metric in ("rms_horizontal_m", "claimed_horizontal_m", "answered_share"):
    for label, found in run["summary"][metric].items():
        print(f"{metric:22} {label:12} {found['value']:10.3f} {found['unit']}")
print(f"{SERVER}/#/runs/{run['id']}")
