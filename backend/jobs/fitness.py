"""Whether a worker that somebody else runs may compute for this server: the same versions give the same bytes.

The versions are asked by a message of Dask's own, which every worker understands; only a worker that passes gets a
function of this program, which then compares the sources: two checkouts may carry the same version.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import algorithms

# What Dask's own message is asked for besides Python and numpy.
PACKAGES = ["filterroom", "numba", "scipy"]
_COMPARED = ("python", "filterroom", "numpy", "numba", "scipy")


def versions_of(answer: Mapping[str, Any]) -> dict[str, str]:
    """Return the versions that decide results, from the answer of Dask's `get_versions`."""
    packages = answer["packages"]
    found = {name: str(packages.get(name) or "none") for name in _COMPARED}
    # Results do not change with a patch of Python, and work is sent in a form that does not either.
    return found | {"python": ".".join(found["python"].split(".")[:2])}


def differences(here: Mapping[str, str], there: Mapping[str, str]) -> str:
    """Return in words what another machine has that differs from this one; empty where nothing does."""
    return ", ".join(f"{name} {there[name]} (here {here[name]})" for name in _COMPARED if here[name] != there[name])


@cache
def sources() -> str:
    """Return a hash of the sources of this program that workers run."""
    digest = hashlib.sha256()
    for folder in (Path(str(algorithms.__file__)).parent, Path(__file__).parent):
        for path in sorted(folder.rglob("*.py")):
            digest.update(f"{path.relative_to(folder).as_posix()}\n".encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()
