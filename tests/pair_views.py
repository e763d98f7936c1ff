"""What the identification algorithms say of small recordings and of ten trials, for the tests of the charts."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from algorithms.recording import Recording
from algorithms.result import Table

SHARES = {
    "probability_correct": (0.7, 0.6),
    "probability_wrong": (0.1, 0.1),
    "probability_undecided": (0.2, 0.3),
    "probability_undecided_none": (0.1, 0.1),
    "probability_undecided_several": (0.1, 0.2),
    "assignment_correct": (0.98, 0.95),
    "plot_nees": (1.0, 1.1),
    "false_rejection": (0.011, 0.02),
    "lowest_share": (0.4, 0.9),
    "rms_series_m": (17.0, 139.0),
}


def pair_tables(recording: Recording) -> dict[str, Table]:
    """Each plot with the next one, accepted in turn; all of one look."""
    first = recording.row[:-1].astype(float)
    count = first.size
    return {
        "associations": Table(
            {
                "time_s": recording.time_s[:-1],
                "row_1": first,
                "row_2": first + 1,
                "statistic": 1.5 * np.arange(count, dtype=float),
                "probability": np.linspace(0.1, 0.9, count) if count else np.empty(0),
                "decision": ["accepted" if i % 2 == 0 else "undecided" for i in range(count)],
                "look": np.zeros(count),
            }
        )
    }


def pair_metrics(metrics: dict[str, Any], swept: str) -> Table:
    """The metrics of trials, with the shares of decisions after them."""
    columns = {name: list(column) for name, column in metrics.items()}
    for metric, values in SHARES.items():
        for condition, value in zip((10.0, 100.0), values, strict=True):
            row = {"metric": metric, swept: condition, "value": value, "ci95_low": value - 0.05,
                   "ci95_high": value + 0.02}  # fmt: skip
            for name, column in columns.items():
                column.append(row.get(name))
    texts = {"metric", "segment", "target"}
    return Table({n: c if n in texts else np.array(c, float) for n, c in columns.items()})


def pair_values() -> dict[str, Any]:
    """Single values of two cells, five instants and ten trials."""
    cells = [{"scenario.sigma_altitude_m": value} for value in (10.0, 100.0)]
    grid = np.linspace(0.05, 1.0, 100).reshape(2, 5, 10)
    return {
        "trials/cells": np.frombuffer(json.dumps(cells).encode(), np.uint8),
        "trials/kept_time_s": np.arange(5.0),
        "trials/statistic_same": 5 * grid,
        "trials/statistic_other": 30 * grid,
        "trials/stated_probability": grid,
        "trials/stated_right": np.where(np.arange(100).reshape(grid.shape) % 7 == 0, 0.0, 1.0),
    }
