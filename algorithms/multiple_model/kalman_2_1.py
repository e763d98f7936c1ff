"""Kalman-2 1: one constant acceleration model with noise 1 m/s2 a step."""

from __future__ import annotations

from algorithms.multiple_model.one_model import one_model

ALGORITHM = one_model(
    "kalman_2_1",
    "Kalman filter, constant acceleration, 1 m/s² (Kalman-2 1)",
    "One Kalman filter with constant acceleration and noise of 1 m/s² a step.",
    "ca",
    1.0,
)
