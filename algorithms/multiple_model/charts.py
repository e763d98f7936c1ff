"""Which charts the family's algorithms are drawn in, by name."""

from __future__ import annotations

PLAIN_CHARTS = (
    "plan", "height", "speed", "acceleration", "nis", "radial_error", "trials_up", "trials_velocity_up",
    "trials_stages",
)  # fmt: skip
MODELS_CHARTS = (*PLAIN_CHARTS, "mode_probabilities", "leading_models", "trials_modes")
"""Charts of multiple-model tracking."""
