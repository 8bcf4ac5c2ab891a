"""Arrays that live as long as the call of a kernel: memory of its frame, without a request to the system.

Laws are called some hundred thousand times a second: asking for an array would take longer than filling it.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

__all__ = ["local_matrix", "local_vector"]

_MOST: Final = 1024
"""Numbers in an array: what is larger is no matter of a frame."""


def _in_frame(lengths: tuple[Any, ...]) -> Any:
    """Signature and code of an array whose lengths are literal types."""
    if not all(isinstance(one, types.IntegerLiteral) for one in lengths):
        raise TypingError(f"{lengths}: numbers that are written out, or Final, are accepted")
    shape = [int(one.literal_value) for one in lengths]
    count = int(np.prod(shape))
    if not 0 < count <= _MOST:
        raise TypingError(f"{shape}: 1 to {_MOST} numbers are accepted")
    array = types.Array(types.float64, len(shape), "C")

    def generate(context, builder, signature, _values):  # type: ignore[no-untyped-def]  # Numba has no types
        number, whole = context.get_value_type(types.float64), context.get_value_type(types.intp)
        size = context.get_abi_sizeof(number)
        made = context.make_array(signature.return_type)(context, builder)
        context.populate_array(
            made,
            data=cgutils.alloca_once(builder, number, size=whole(count)),  # type: ignore[no-untyped-call]  # Numba has no types
            shape=[whole(one) for one in shape],
            strides=[whole(size * int(np.prod(shape[i + 1 :], dtype=int))) for i in range(len(shape))],
            itemsize=whole(size),
            meminfo=None,
        )
        return made._getvalue()

    return array(*lengths), generate


@intrinsic(prefer_literal=True)
def _vector(typing_context, count):  # type: ignore[no-untyped-def]  # Numba has no types
    """See :data:`local_vector`."""
    del typing_context
    return _in_frame((count,))


@intrinsic(prefer_literal=True)
def _matrix(typing_context, rows, columns):  # type: ignore[no-untyped-def]  # Numba has no types
    """See :data:`local_matrix`."""
    del typing_context
    return _in_frame((rows, columns))


local_vector: Any = _vector
"""``local_vector(count)``: array (count,) of float64 in a kernel, not filled; ``count`` is written out.

It ends with the call of the kernel: it is handed down to other kernels only, never returned or kept.
"""

local_matrix: Any = _matrix
"""``local_matrix(rows, columns)``: array (rows, columns) as :data:`local_vector` gives them."""
