"""Which models an algorithm of the family runs, found by its name, and how many operations a mark costs it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from algorithms.multiple_model import (
    kalman_1_5,
    kalman_1_20,
    kalman_2_1,
    kalman_2_20,
    mma2_11,
    mma2_122,
    model_smoother,
    multiple_model,
)
from algorithms.multiple_model.tracker import ModelSet

_CV, _CA = 568, 937
_THREE = {"gpb1": 3_407, "imm": 4_444, "gpb2": 8_344}
_TWO = {"gpb1": 1_698, "imm": 1_964, "gpb2": 2_772}
_ONE = {
    kalman_1_5.ALGORITHM.name: _CV,
    kalman_1_20.ALGORITHM.name: _CV,
    kalman_2_1.ALGORITHM.name: _CA,
    kalman_2_20.ALGORITHM.name: _CA,
}


def model_set_of(algorithm: str, given: Mapping[str, Any]) -> ModelSet | None:
    """Return the models of an algorithm with these parameters; None where it has one or is of another family."""
    told = dict(given)
    if algorithm == mma2_122.ALGORITHM.name:
        return mma2_122.models_of(mma2_122.Mma2Parameters.model_validate(told))
    if algorithm == mma2_11.ALGORITHM.name:
        return mma2_11.models_of(mma2_11.Mma211Parameters.model_validate(told))
    if algorithm == model_smoother.ALGORITHM.name:
        return multiple_model.models_of(model_smoother.ModelSmootherParameters.model_validate(told))
    if algorithm == multiple_model.ALGORITHM.name:
        return multiple_model.models_of(multiple_model.MultipleModelParameters.model_validate(told))
    return None


def operations_of(algorithm: str, given: Mapping[str, Any]) -> int | None:
    """Return arithmetic operations of a mark: packed symmetric 9x9, written out, an exponential or logarithm as 34.

    Counted for the paper's own sets only (specification 6.5); None for any other.
    """
    counted = {"mma2_122": _THREE, "mma2_11": _TWO}.get(algorithm)
    return _ONE.get(algorithm) if counted is None else counted[str(given.get("structure", "imm"))]
