"""How the trials of a Monte Carlo run are cut: into batches, whose sums are added in order, and into tasks of batches.

A sum over trials is first taken over a batch of fixed length, then over the batches in their order. Tasks are whole
numbers of batches, so the result does not depend, in any bit, on how many batches a task has or who computes it.
"""

from __future__ import annotations

import math
from itertools import pairwise

# Two blocks of the kernels' sixteen lanes: short enough that two workers share a short run evenly.
BATCH = 32
# Work of one task: a worker that dies, or a user who cancels, loses at most this.
TASK_S = 1.0
# A short run is cut into so many tasks, so that no worker waits long for the last one; but none is shorter than this,
# for each costs the server some milliseconds.
TASKS = 8
SHORTEST_S = 0.06
# What one instant of one trial costs one algorithm, s: about right for a filter.
INSTANT_S = 1e-6


def batches_per_task(trials: int, instants: int, algorithms: int, cells: int = 1) -> int:
    """Return how many batches of trials make a task: a second, less where the run is short.

    Parameters
    ----------
    trials : of the run
    instants : rows of the simulated recording
    algorithms : entries that filter the same draws
    cells : of the scenario, so many trials in each
    """
    batch_s = max(instants, 1) * BATCH * max(algorithms, 1) * INSTANT_S
    whole = math.ceil(trials / BATCH)
    task_s = min(TASK_S, max(batch_s * whole * cells / TASKS, SHORTEST_S))
    return max(1, min(round(task_s / batch_s), whole))


def tasks(trials: int, most: int) -> list[tuple[int, int]]:
    """Return the trials first <= i < stop of every task of at most so many batches, which differ by one at most.

    A last task that is shorter than the others would leave a worker without work.
    """
    whole = math.ceil(trials / BATCH)
    count = math.ceil(whole / most)
    ends = [BATCH * (whole * k // count) for k in range(count + 1)]
    return [(first, min(stop, trials)) for first, stop in pairwise(ends)]


def batches(first: int, stop: int) -> list[tuple[int, int]]:
    """Return the batches of a task."""
    return [(k, min(k + BATCH, stop)) for k in range(first, stop, BATCH)]
