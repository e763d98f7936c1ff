from __future__ import annotations

import errno
import hashlib
import os
import time
from pathlib import Path

import numpy as np
import pytest

from backend.errors import NotFoundError, StorageError
from backend.files.store import Store, json_array, json_of


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return Store(tmp_path / "store")


def test_bytes_are_named_by_their_hash(store: Store) -> None:
    sha256 = store.put_bytes(b"plots")
    assert sha256 == hashlib.sha256(b"plots").hexdigest()
    assert store.get_bytes(sha256) == b"plots"
    assert store.put_bytes(b"plots") == sha256
    assert list(store.hashes()) == [sha256]
    assert list(store.temporary().parent.iterdir()) == []
    assert store.path(sha256).stat().st_mode & 0o777 == 0o600


def test_a_file_is_moved_in(store: Store) -> None:
    path = store.temporary()
    path.write_bytes(b"x" * 3_000_000)
    sha256 = store.put_file(path)
    assert not path.exists()
    assert sha256 == hashlib.sha256(b"x" * 3_000_000).hexdigest()


def test_a_hashed_file_is_taken_in_and_goes_back_where_nobody_could_refer_to_it(store: Store) -> None:
    path = store.temporary()
    path.write_bytes(b"result")
    sha256 = hashlib.sha256(b"result").hexdigest()

    def refer_in_vain() -> None:
        with store.adopted(path, sha256):
            assert store.get_bytes(sha256) == b"result"
            raise StorageError("The database is locked.")

    with pytest.raises(StorageError, match="locked"):
        refer_in_vain()
    assert path.read_bytes() == b"result"
    assert list(store.hashes()) == []
    with store.adopted(path, sha256):
        pass
    assert not path.exists()
    assert store.get_bytes(sha256) == b"result"
    assert store.path(sha256).stat().st_mode & 0o777 == 0o600


def test_a_file_that_is_there_already_stays_where_the_second_one_fails(store: Store) -> None:
    sha256 = store.put_bytes(b"result")
    path = store.temporary()
    path.write_bytes(b"result")

    def refer_in_vain() -> None:
        with store.adopted(path, sha256):
            raise StorageError("The database is locked.")

    with pytest.raises(StorageError, match="locked"):
        refer_in_vain()
    assert store.get_bytes(sha256) == b"result"
    with store.adopted(path, sha256):
        pass
    assert not path.exists()


def test_arrays_come_back_as_they_went_in(store: Store) -> None:
    arrays = {
        "rdf/state": np.arange(6.0).reshape(2, 3)[:, ::-1],
        "file": np.array([1, -1], np.int64),
        "empty": np.empty((0, 3)),
        "meta": json_array({"метка": [1, None]}),
    }
    back = store.get_arrays(store.put_arrays(arrays))
    assert list(back) == list(arrays)
    for name, array in arrays.items():
        np.testing.assert_array_equal(back[name], array)
    assert json_of(back["meta"]) == {"метка": [1, None]}


def test_equal_arrays_are_equal_bytes_at_any_time(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    first = store.put_arrays({"a": np.ones(3)})
    monkeypatch.setattr(time, "time", lambda: 2_000_000_000.0)
    assert store.put_arrays({"a": np.ones(3)}) == first


def test_pickles_are_never_written_nor_read(store: Store) -> None:
    with pytest.raises(ValueError, match="allow_pickle"):
        store.put_arrays({"a": np.array([object()])})


def test_a_missing_blob_says_what_to_do(store: Store) -> None:
    with pytest.raises(StorageError, match="backup") as caught:
        store.get_bytes("0" * 64)
    assert caught.value.code == "blob_missing"
    store.delete("0" * 64)


@pytest.mark.parametrize("name", ["", "../" + "0" * 61, "A" * 64, "0" * 63])
def test_only_hashes_are_names(store: Store, name: str) -> None:
    with pytest.raises(ValueError, match="SHA-256"):
        store.path(name)


def test_a_full_disk_leaves_nothing_behind(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_path: Path, data: bytes) -> int:
        _path.touch()
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(StorageError, match="full") as caught:
        store.put_bytes(b"x")
    assert caught.value.code == "disk_full"
    assert list(store.hashes()) == []
    assert list(store.temporary().parent.iterdir()) == []


def test_clear_temporary(store: Store) -> None:
    store.temporary().write_bytes(b"half")
    store.clear_temporary()
    assert list(store.temporary().parent.iterdir()) == []
    with pytest.raises(NotFoundError):
        store.put_file(store.temporary())


def test_size_of_a_blob(store: Store) -> None:
    assert store.size(store.put_bytes(b"plots")) == 5
    assert store.size("0" * 64) is None
