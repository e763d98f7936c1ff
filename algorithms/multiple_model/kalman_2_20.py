"""Kalman-2 20: one constant acceleration model with noise 20 m/s2 a step."""

from __future__ import annotations

from algorithms.multiple_model.one_model import one_model

ALGORITHM = one_model(
    "kalman_2_20",
    "Kalman filter, constant acceleration, 20 m/s² (Kalman-2 20)",
    "One Kalman filter with constant acceleration and noise of 20 m/s² a step.",
    "ca",
    20.0,
)
