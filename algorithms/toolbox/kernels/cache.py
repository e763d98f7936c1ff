"""Where compiled kernels are kept, under a key that notices every change that matters.

numba's own cache does not notice an edited *callee*: a cached caller goes on with the old one. The key is therefore a
hash of every kernel source, of the versions of numba, llvmlite and numpy, and of the CPU; and of the place of the
sources, because numba finds a function by its path: a second checkout would take the folder of the first for complete
and compile in every process. The folder is the user's cache folder (`FILTERROOM_KERNEL_CACHE`, default
`$XDG_CACHE_HOME/filterroom/<key>`), shared by server, command line and tests.
"""

from __future__ import annotations

import hashlib
import os
from importlib.metadata import version
from pathlib import Path

_ALGORITHMS = Path(__file__).resolve().parents[2]
# What defines or inlines a kernel imports its decorator; what only calls compiled functions may change freely.
_MARK = "from algorithms.toolbox.kernels import"


def kernel_key() -> str:
    """Hash of kernel sources, their place, compiler versions and CPU, 16 hexadecimal digits."""
    import llvmlite.binding as llvm

    digest = hashlib.sha256(str(_ALGORITHMS).encode())
    for path in sorted(_ALGORITHMS.rglob("*.py")):
        text = path.read_bytes()
        if _MARK.encode() in text or path.parent.name == "kernels":
            digest.update(path.relative_to(_ALGORITHMS).as_posix().encode() + b"\0" + text)
    for package in ("numba", "llvmlite", "numpy"):
        digest.update(f"{package}={version(package)}".encode())
    cpu = os.environ.get("NUMBA_CPU_NAME") or llvm.get_host_cpu_name()
    features = os.environ.get("NUMBA_CPU_FEATURES") or llvm.get_host_cpu_features().flatten()
    digest.update(f"{cpu}/{features}".encode())
    return digest.hexdigest()[:16]


def kernel_cache_folder() -> Path:
    """Folder of this key's compiled kernels; made where it does not exist."""
    given = os.environ.get("FILTERROOM_KERNEL_CACHE")
    base = Path(given) if given else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "filterroom"
    return base / kernel_key()


def use_kernel_cache() -> None:
    """Point numba at the folder; before numba is imported where possible, else through its configuration."""
    import sys

    folder = kernel_cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        # A read-only home is no reason not to run: numba then compiles anew in each process.
        return
    os.environ["NUMBA_CACHE_DIR"] = str(folder)
    if "numba" in sys.modules:
        import numba

        numba.config.CACHE_DIR = str(folder)
