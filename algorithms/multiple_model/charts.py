"""Which charts the family's algorithms are drawn in, by name."""

from __future__ import annotations

PLAIN_CHARTS = (
    "plan", "height", "trajectory", "speed", "acceleration", "nis", "radial_error", "trials_up", "trials_velocity_up",
    "trials_position", "trials_stages", "trials_cost",
)  # fmt: skip
MODELS_CHARTS = (*PLAIN_CHARTS, "mode_probabilities", "leading_models", "trials_modes", "transition_powers")
"""Charts of multiple-model tracking."""
