"""a b + c with one rounding, said where it is meant.

The flag `contract` lets the compiler fuse where it likes, and it likes differently in the pieces into which it cuts a
loop over lanes, so that a last digit hung on the lane. An explicit fused multiply-add is the same in every piece, as
fast, and as exact on processors without the instruction (where it is slow).
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.extending import intrinsic


@intrinsic
def fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """A b + c of three numbers, rounded once."""

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), emit
