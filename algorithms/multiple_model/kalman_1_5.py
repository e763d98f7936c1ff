"""Kalman-1 5: one constant velocity model with noise 5 m/s2 a step."""

from __future__ import annotations

from algorithms.multiple_model.one_model import one_model

ALGORITHM = one_model(
    "kalman_1_5",
    "Kalman filter, constant velocity, 5 m/s² (Kalman-1 5)",
    "One Kalman filter with constant velocity and noise of 5 m/s² a step.",
    "cv",
    5.0,
)
