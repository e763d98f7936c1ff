"""What the studies of forward scatter name in common."""

from __future__ import annotations

from algorithms.studies import Word

PAPER = "scatter2014"
FAMILY = "forward_scatter"
PRESET = "forward_scatter_pass"
RMS, SD, MEAN = (f"crossing_distance_{name}_m" for name in ("rms", "sd", "mean"))
BOUND = "crossing_distance_bound_3_m"
LINES, ML, ANGLE = (f"forward_scatter_{name}" for name in ("lines", "ml", "angle"))


def word_of(holds: bool, partly: bool) -> Word:
    """Reproduced, partly, or not."""
    return "reproduced" if holds else "partly" if partly else "not"
