"""Find the charts: every module of this package and of its folders (one a family) with a constant `CHART`."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from types import MappingProxyType

import backend.charts
from algorithms.recording import Kind
from backend.charts.view import Chart, Source


@cache
def charts(source: Source) -> Mapping[str, Chart]:
    """Charts of runs or of recordings by name. A name given twice is an error at start."""
    found: dict[str, Chart] = {}
    for module in pkgutil.walk_packages(backend.charts.__path__, "backend.charts."):
        declared = getattr(importlib.import_module(module.name), "CHART", None)
        if isinstance(declared, Chart) and declared.source == source:
            if declared.name in found:
                raise RuntimeError(f"two charts of a {source} are called {declared.name!r}; one is in {module.name}")
            found[declared.name] = declared
    return MappingProxyType(found)


def charts_of_kind(source: Source, kind: Kind) -> tuple[Chart, ...]:
    """The charts that have something to say about recordings of this kind."""
    return tuple(chart for chart in charts(source).values() if chart.takes(kind))
