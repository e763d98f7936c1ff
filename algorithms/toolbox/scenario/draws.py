"""Random streams of trials: trial i of a seed always draws the same, whatever the block, worker or machine."""

from __future__ import annotations

import numpy as np

NOISE, START = 0, 1
"""Separate streams of one trial, so that a filter's random start does not shift the measurement noise."""


def stream(seed: int, trial: int, purpose: int = NOISE) -> np.random.Generator:
    """Random generator of one trial for one purpose."""
    return np.random.default_rng(np.random.SeedSequence(entropy=seed, spawn_key=(trial, purpose)))
