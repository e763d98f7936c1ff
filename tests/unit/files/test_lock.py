from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from backend.errors import StateError
from backend.files.lock import DataFolderLock

HOLD = """
import sys, pathlib
from backend.files.lock import DataFolderLock
lock = DataFolderLock(pathlib.Path(sys.argv[1]))
lock.acquire()
print("held", flush=True)
sys.stdin.read()
"""


def test_a_second_server_is_refused_with_folder_and_process(tmp_path: Path) -> None:
    with DataFolderLock(tmp_path):
        with pytest.raises(StateError) as caught:
            DataFolderLock(tmp_path).acquire()
        assert str(tmp_path) in caught.value.message
        assert str(os.getpid()) in caught.value.message
        assert caught.value.code == "data_folder_in_use"
    with DataFolderLock(tmp_path):
        pass


def test_the_lock_of_a_killed_server_is_free(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLD, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as server:
        assert server.stdout is not None
        assert server.stdout.readline() == "held\n"
        with pytest.raises(StateError, match=str(server.pid)):
            DataFolderLock(tmp_path).acquire()
        server.kill()
    with DataFolderLock(tmp_path):
        pass
