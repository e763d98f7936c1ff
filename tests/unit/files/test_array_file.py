"""Arrays in an .npz: what is hashed beside the writing is what stands in the file."""

from __future__ import annotations

import hashlib
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from backend.files.array_file import HashedArrays, MappedArrays, read_arrays, write_arrays

ARRAYS = {
    "rdf/state": np.arange(3_000_000.0).reshape(-1, 3)[:, ::-1],
    "rdf/used": np.array([[True, False]]),
    "empty": np.empty((0, 3)),
    "tables/states/rdf/columns": np.frombuffer(b"[]", np.uint8),
}


def test_the_hash_is_that_of_the_file_and_the_file_that_of_one_written_at_once(tmp_path: Path) -> None:
    out = HashedArrays(tmp_path / "a.npz")
    for name, array in ARRAYS.items():
        out.add({name: array})
    sha256 = out.finish()
    out.close()
    content = (tmp_path / "a.npz").read_bytes()
    assert hashlib.sha256(content).hexdigest() == sha256
    at_once = io.BytesIO()
    write_arrays(at_once, ARRAYS)
    assert content == at_once.getvalue()
    back = read_arrays(np.frombuffer(content, np.uint8))
    assert list(back) == list(ARRAYS)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(back[name], array)


def test_the_hash_does_not_run_ahead_of_members_that_are_still_written(tmp_path: Path) -> None:
    """The header of a member is written once more at its end; what is read before is another one."""
    out = HashedArrays(tmp_path / "a.npz")
    out.add({f"a{i}": np.full(40_000 if i % 2 else 400, i) for i in range(300)})
    sha256 = out.finish()
    out.close()
    assert sha256 == hashlib.sha256((tmp_path / "a.npz").read_bytes()).hexdigest()


def test_arrays_are_used_where_they_lie_and_the_file_stays(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    write_arrays(path, ARRAYS | {"метка/x": np.arange(5, dtype=np.int16), "fortran": np.asfortranarray(np.eye(3))})
    before = path.read_bytes()
    mapped = MappedArrays(path)
    with np.load(path, allow_pickle=False) as usual:
        assert list(mapped) == list(usual)
        for name in usual:
            array = mapped[name]
            np.testing.assert_array_equal(array, usual[name])
            assert array.dtype == usual[name].dtype
            assert array.size == 0 or array.__array_interface__["data"][0] % 64 == 0, name
    mapped["rdf/state"][0] = 7.0
    assert path.read_bytes() == before
    with pytest.raises(KeyError):
        mapped["absent"]


def test_files_of_earlier_versions_are_read(tmp_path: Path) -> None:
    """Their members begin anywhere."""
    path = tmp_path / "a.npz"
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in ARRAYS.items():
            with archive.open(f"{name}.npy", "w") as out:
                np.lib.format.write_array(out, array, allow_pickle=False)
    mapped = MappedArrays(path)
    for name, array in ARRAYS.items():
        np.testing.assert_array_equal(mapped[name], array)
        assert mapped[name].flags.aligned


def test_pickles_and_compressed_members_are_not_read(tmp_path: Path) -> None:
    np.savez(tmp_path / "a.npz", a=np.array([object()]), allow_pickle=True)
    with pytest.raises(ValueError, match="allow_pickle"):
        MappedArrays(tmp_path / "a.npz")["a"]
    np.savez_compressed(tmp_path / "b.npz", a=np.zeros(3))
    with pytest.raises(ValueError, match="compressed"):
        MappedArrays(tmp_path / "b.npz")["a"]


@pytest.mark.parametrize("rows", [1, 1_000_000], ids="{} rows".format)
def test_what_the_disk_refuses_is_told_at_the_end(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    full = Path("/dev/full")
    opened = Path.open
    monkeypatch.setattr(Path, "open", lambda path, mode, **how: opened(path, mode.replace("x", "w"), **how))
    out = HashedArrays(full)
    out.add({"a": np.zeros(rows)})
    with pytest.raises(OSError, match="No space left"):
        out.finish()
    out.close()


def test_pickles_are_not_written(tmp_path: Path) -> None:
    out = HashedArrays(tmp_path / "a.npz")
    out.add({"a": np.array([object()])})
    with pytest.raises(ValueError, match="allow_pickle"):
        out.finish()
    out.close()
