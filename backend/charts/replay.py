"""What a plan shows of one instant while its slider moves: speed vectors of the tracks, and the gates of the next scan.

The numbers stand in `layout.meta.replay` of the plan, in metres and metres a second, as plain lists; the page draws
those of the instant that it looks at.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from algorithms.registry import algorithms_by_name
from backend.charts.columns import numbers, words
from backend.charts.estimates import Estimates
from backend.charts.view import Entry

# More than this would weigh more than the chart itself.
MOST_ROWS = 12_000


def replay_of(found: list[tuple[Entry, Estimates]]) -> dict[str, Any] | None:
    """Vectors and gates of all entries that have them; None where there is nothing, or too much of it."""
    vectors: dict[str, list[Any]] = {name: [] for name in ("index", "t", "east", "north", "v_east", "v_north", "track")}
    shape = ("index", "t", "east", "north", "major", "minor", "azimuth", "gate")
    gates: dict[str, list[Any]] = {name: [] for name in shape}
    rings: dict[str, list[float]] = {}
    for entry, states in found:
        areas = entry.table("gate_areas")
        if not len(areas):
            continue
        speed = [states.numbers(name) for name in ("velocity_east_mps", "velocity_north_mps")]
        known = np.flatnonzero(np.isfinite(speed[0] + speed[1]))
        columns = (states.time_s, states.numbers("east_m"), states.numbers("north_m"), *speed, states.numbers("track"))
        vectors["index"] += [entry.index] * known.size
        for name, column in zip(("t", "east", "north", "v_east", "v_north", "track"), columns, strict=True):
            vectors[name] += np.round(column[known], 1).tolist()
        gates["index"] += [entry.index] * len(areas)
        gates["gate"] += words(areas, "gate").tolist() if "gate" in areas.names else ["tracking"] * len(areas)
        if entry.algorithm == "curvature_tracker":
            rings[str(entry.index)] = _rings(entry)
        named = (("t", "time_s"), ("east", "east_m"), ("north", "north_m"), ("major", "semi_major_m"),
                 ("minor", "semi_minor_m"), ("azimuth", "azimuth_deg"))  # fmt: skip
        for name, column_name in named:
            gates[name] += np.round(numbers(areas, column_name), 1).tolist()
    if len(vectors["t"]) + len(gates["t"]) > MOST_ROWS:
        kept = [i for i, gate in enumerate(gates["gate"]) if gate != "start"]
        gates = {name: [values[i] for i in kept] for name, values in gates.items()}
    rows = len(vectors["t"]) + len(gates["t"])
    return {"vectors": vectors, "gates": gates, "rings": rings} if 0 < rows <= MOST_ROWS else None


def _rings(entry: Entry) -> list[float]:
    """Radii of the two inner ellipses as shares of the outer one's."""
    defaults = algorithms_by_name()[entry.algorithm].parameters.model_validate(entry.parameters)
    radii = [np.sqrt(-2 * np.log1p(-getattr(defaults, f"confidence_{n}"))) for n in ("inner", "middle", "outer")]
    return [round(float(r / radii[2]), 4) for r in radii[:2]]
