"""Where compiled kernels are kept, under keys that notice every change that matters.

numba's own cache does not notice an edited *callee*: a cached caller goes on with the old one. The key of a source file
is therefore a hash of itself and of every kernel source that it imports, at first or second hand; of the versions of
numba, llvmlite and numpy, and of the CPU (numba itself tells Python 3.11 from 3.12). An edit compiles again what it can
reach, and no other family. Where the sources lie does not matter: checkouts and installations of the same sources share
their kernels. The folders lie in the user's cache folder (`FILTERROOM_KERNEL_CACHE`, default
`$XDG_CACHE_HOME/filterroom`), shared by server, command line and tests.
"""

from __future__ import annotations

import ast
import fcntl
import hashlib
import os
from collections.abc import Iterable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from numba.core.caching import CompileResultCacheImpl, FunctionCache, _CacheLocator

_ALGORITHMS = Path(__file__).resolve().parents[2]
# What defines or inlines a kernel imports its decorator; what only calls compiled functions may change freely.
_MARK = b"from algorithms.toolbox.kernels import"


def key_of_all() -> str:
    """Hash that changes when any kernel has to be compiled again, 16 hexadecimal digits."""
    return _key(path for path in _ALGORITHMS.rglob("*.py") if _defines_kernels(path))


def base_folder() -> Path:
    """Folder that holds the compiled kernels of every key; made when the first is stored."""
    given = os.environ.get("FILTERROOM_KERNEL_CACHE")
    return Path(given) if given else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "filterroom"


@cache
def folder_of(path: Path) -> Path:
    """Folder of the compiled kernels that the source file `path` defines."""
    return base_folder() / _key(_reached(path))


class _Place(_CacheLocator):  # type: ignore[misc]
    """Where numba keeps a function: numba's own places hang on the path of the source, this one on what it says."""

    def __init__(self, function: Any) -> None:
        self._folder = folder_of(Path(function.__code__.co_filename).resolve())
        # numba names it where it warns.
        self._py_file = function.__code__.co_filename
        self._line = function.__code__.co_firstlineno
        self.ensure_cache_path()

    @classmethod
    def from_function(cls, py_func: Any, _py_file: str) -> _Place:
        return cls(py_func)

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._folder.name

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Impl(CompileResultCacheImpl):  # type: ignore[misc]
    _locator_classes = (_Place,)


class KernelCache(FunctionCache):  # type: ignore[misc]
    """numba's cache of one function, in the folder of its source, safe for processes that compile at once.

    numba reads the list of a function's signatures, adds one and writes it back: of two processes that do so at once
    one would lose its entry, or find the code of the other under it.

    Raises
    ------
    OSError
        The folder cannot be made or written.
    """

    _impl_class = _Impl

    def _save_overload(self, sig: Any, data: Any) -> None:
        with (Path(self.cache_path) / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            super()._save_overload(sig, data)


def _key(sources: Iterable[Path]) -> str:
    digest = hashlib.sha256(_surroundings())
    for path in sorted(sources):
        digest.update(os.path.relpath(path, _ALGORITHMS).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def _surroundings() -> bytes:
    """Compiler and processor, in which all keys differ from those of another machine."""
    import llvmlite.binding as llvm

    cpu = os.environ.get("NUMBA_CPU_NAME") or llvm.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES") or llvm.get_host_cpu_features().flatten()
    versions = [f"{package}={version(package)}" for package in ("numba", "llvmlite", "numpy")]
    return "\0".join([*versions, cpu, features]).encode()


def _defines_kernels(path: Path) -> bool:
    return path.parent.name == "kernels" or _MARK in path.read_bytes()


def _reached(path: Path) -> set[Path]:
    """`path` and every source of kernels that it imports, by however many steps."""
    seen = {path}
    waiting = [path]
    while waiting:
        new = _imports(waiting.pop()) - seen
        seen |= new
        waiting.extend(new)
    return {source for source in seen if _defines_kernels(source)}


@cache
def _imports(path: Path) -> frozenset[Path]:
    """Files of `algorithms` that `path` names in its import statements, those of its functions included."""
    names = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
    places = [_ALGORITHMS.parent / name.replace(".", "/") for name in names if name.startswith("algorithms.")]
    files = {file for place in places for file in (place.with_suffix(".py"), place / "__init__.py")}
    return frozenset(file for file in files if file.is_file())
