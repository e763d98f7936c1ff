"""Which charts the family's algorithms are drawn in, by name."""

from __future__ import annotations

PLAIN_CHARTS = ("plan", "height", "nis", "radial_error")
MODELS_CHARTS = (*PLAIN_CHARTS, "mode_probabilities")
