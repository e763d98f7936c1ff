"""Find what is declared: walk the families' modules for `ALGORITHM` and `SCENARIOS`.

Third parties add algorithms through the entry-point group `filterroom.algorithms` (each entry point is a module
with a constant `ALGORITHM`). A duplicate name is an error at start, not a surprise later.
"""

from __future__ import annotations

import importlib
import pkgutil
import threading
from collections.abc import Iterator
from functools import cache
from importlib.metadata import entry_points
from types import ModuleType

import algorithms
from algorithms.spec import Algorithm, Scenario
from algorithms.studies import Study

# Not families: the shared toolbox has no declarations, and importing all of it would only cost time.
_SKIPPED = ("algorithms.toolbox",)
# The order in which people meet them; what is installed beside them comes last.
_FAMILIES = ("multilateration", "identification", "multiple_model", "plot_tracking", "forward_scatter")

_IMPORTING = threading.RLock()


def module_names() -> Iterator[str]:
    """Names of the families' modules; asking for the next one imports packages, and they take seconds in all."""
    for module in pkgutil.walk_packages(algorithms.__path__, "algorithms."):
        if not module.name.startswith(_SKIPPED):
            yield module.name


def _modules() -> list[ModuleType]:
    # Threads of a starting server ask at the same time: packages that import each other are imported by one.
    with _IMPORTING:
        found = [importlib.import_module(name) for name in module_names()]
    found.sort(key=lambda module: _place(module.__name__))
    found += [point.load() for point in entry_points(group="filterroom.algorithms")]
    return found


def _place(module: str) -> int:
    """Place of a module's family; within a family the order of the walk stays."""
    family = module.split(".")[1]
    return _FAMILIES.index(family) if family in _FAMILIES else len(_FAMILIES)


@cache
def algorithms_by_name() -> dict[str, Algorithm]:
    """All algorithms, in the order in which families and files are found."""
    out: dict[str, Algorithm] = {}
    for module in _modules():
        declared = getattr(module, "ALGORITHM", None)
        if isinstance(declared, Algorithm):
            if declared.name in out:
                raise RuntimeError(f"two algorithms are called {declared.name!r}; the second is in {module.__name__}")
            out[declared.name] = declared
    return out


@cache
def scenarios_by_name() -> dict[str, Scenario]:
    """All scenario presets."""
    out: dict[str, Scenario] = {}
    for module in _modules():
        for declared in getattr(module, "SCENARIOS", ()):
            if declared.name in out:
                raise RuntimeError(f"two scenarios are called {declared.name!r}; the second is in {module.__name__}")
            out[declared.name] = declared
    return out


@cache
def studies_by_name() -> dict[str, Study]:
    """All reproductions of figures, tables and claims."""
    out: dict[str, Study] = {}
    for module in _modules():
        for declared in getattr(module, "STUDIES", ()):
            if declared.name in out:
                raise RuntimeError(f"two studies are called {declared.name!r}; the second is in {module.__name__}")
            out[declared.name] = declared
    return out
