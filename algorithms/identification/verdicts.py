"""How numbers that the paper does not print are claimed and judged: they come from a simulation of their own."""

from __future__ import annotations

from algorithms.studies import Claim, Found, Verdict, Word

PAPER = "prosov2008"
# Numbers that stand in no paper: they come from a simulation of its own with up to 40,000 trials.
REFERENCE = "{} (reference, not printed)"


def verdict(claim: Claim, found: Found, expected: float, within: float) -> Verdict:
    """Judge a number against the expected one."""
    near = abs(found.value - expected) <= within
    word: Word = "reproduced" if near else "partly" if abs(found.value - expected) <= 2 * within else "not"
    return Verdict(
        claim, found.value, "1", word, f"Here {found.value:.3f}, expected {expected:.3f}.", found.low, found.high
    )
