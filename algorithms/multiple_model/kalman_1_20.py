"""Kalman-1 20: one constant velocity model with noise 20 m/s2 a step."""

from __future__ import annotations

from algorithms.multiple_model.one_model import one_model

ALGORITHM = one_model(
    "kalman_1_20",
    "Kalman filter, constant velocity, 20 m/s² (Kalman-1 20)",
    "One Kalman filter with constant velocity and noise of 20 m/s² a step.",
    "cv",
    20.0,
)
