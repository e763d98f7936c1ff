"""How the trials of a Monte Carlo run are cut: into batches, whose sums are added in order, and into tasks of batches.

A sum over trials is first taken over a batch of fixed length, then over the batches in their order. Tasks are whole
numbers of batches, so the result does not depend, in any bit, on how many batches a task has or who computes it.
"""

from __future__ import annotations

import math

# Four blocks of the kernels' sixteen lanes: long enough that what leaves a worker is small against what it computed.
BATCH = 64
# Work of one task: a worker that dies, or a user who cancels, loses at most this.
TASK_S = 0.5
# What one instant of one trial costs one algorithm, s: about right for a filter.
INSTANT_S = 1e-6


def batches_per_task(trials: int, instants: int, algorithms: int) -> int:
    """Return how many batches of trials make a task of about half a second.

    Parameters
    ----------
    trials : of the run
    instants : rows of the simulated recording
    algorithms : entries that filter the same draws
    """
    batch_s = max(instants, 1) * BATCH * max(algorithms, 1) * INSTANT_S
    return max(1, min(round(TASK_S / batch_s), math.ceil(trials / BATCH)))


def tasks(trials: int, batches: int) -> list[tuple[int, int]]:
    """Return the trials first <= i < stop of every task of so many batches."""
    step = batches * BATCH
    return [(first, min(first + step, trials)) for first in range(0, trials, step)]


def batches(first: int, stop: int) -> list[tuple[int, int]]:
    """Return the batches of a task."""
    return [(k, min(k + BATCH, stop)) for k in range(first, stop, BATCH)]
