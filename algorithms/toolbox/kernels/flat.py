"""Calls without a toll: a flat view of an array, and functions that become a part of their caller.

A call hands over each array's address, shape and strides; of named tuples of arrays that is some hundred numbers, and
took a multiple-model step longer than its arithmetic. Numba's own `reshape` asks the runtime whether it may.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array

from algorithms.toolbox.kernels import _compiled

woven = _compiled(inline="always", _nrt=False)
"""As `bare`, for parts of a long step that are called from one place: a second one would compile them twice."""


@intrinsic
def flat(typing_context: Any, array: Any) -> Any:
    """View of a contiguous array in one dimension."""
    view = types.Array(array.dtype, 1, "C")

    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        whole = make_array(array)(context, builder, arguments[0])
        out = make_array(view)(context, builder)
        populate_array(
            out,
            data=whole.data,
            shape=cgutils.pack_array(builder, [whole.nitems]),
            strides=cgutils.pack_array(builder, [whole.itemsize]),
            itemsize=whole.itemsize,
            meminfo=whole.meminfo,
            parent=whole.parent,
        )
        return out._getvalue()

    return view(array), emit
