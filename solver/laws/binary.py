"""The binary interface of soil laws: one stress update behind a function pointer.

::

    int64 update(int64 components, float64 log_time, float64 *strain, float64 *stress, float64 *state,
                 float64 *constants, float64 *new_stress, float64 *new_state, float64 *tangent)

``components`` 6 (xx, yy, zz, xy, yz, zx), or 4: the first four of them, of a plane or an axisymmetric body. Compression
is positive, stress in kPa, strain an increment with engineering shear, ``log_time`` = ln(time increment/day), -inf for
none: creep laws meet times down to exp(-10 000) day, which are no numbers. ``stress``, ``state`` and ``strain`` stay
as they are; ``new_stress``, ``new_state`` and ``tangent`` (components x components, d new stress/d strain, row by row)
are filled. The result is 0 or above (0: below every limit; otherwise a number for each limit), or -1 where
the law has no stress for this step: it is too large.

A calculation receives the address as a number with its data and calls it; nothing of a law is compiled into it, and no
address is ever kept in a file.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.errors import TypingError
from numba.extending import intrinsic

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import compiled

__all__ = ["NumbaUpdate", "StressUpdate", "call_update", "carray"]

_POINTERS = 7
_NUMBERS = types.CPointer(types.float64)  # type: ignore[no-untyped-call]  # Numba has no types
_SIGNATURE = types.int64(types.int64, types.float64, *[_NUMBERS] * _POINTERS)
carray: Any = numba.carray  # type: ignore[attr-defined]  # Numba exports it
"""An array of a pointer and a shape, in updates that are written for Numba."""
_PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_double, *[ctypes.c_void_p] * _POINTERS)


class StressUpdate:
    """A stress update at an address in this process, for instance in a library of the user's.

    Parameters
    ----------
    address
        Of a function as the module describes it.
    """

    def __init__(self, address: int) -> None:
        self._address = address

    @property
    def address(self) -> int:
        """Where the function is in this process."""
        return self._address

    def __call__(
        self, strain: FloatArray, log_time: float, stress: FloatArray, state: FloatArray, constants: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, int]:
        """New stress (n,), new state, tangent (n, n) and status of one step; n is 4 or 6."""
        given = [np.ascontiguousarray(one, dtype=np.float64) for one in (strain, stress, state, constants)]
        count = given[0].shape[0]
        found = [np.zeros(count), given[2].copy(), np.zeros((count, count))]
        status = _PROTOTYPE(self.address)(count, log_time, *(one.ctypes.data for one in (*given, *found)))
        return found[0], found[1], found[2], int(status)


class NumbaUpdate(StressUpdate):
    """A stress update that is written in Python for Numba: compiled when its address is first wanted, cached on disk.

    To be used as a decorator; the arguments are ``(components, log_time, strain, stress, state, constants, new_stress,
    new_state, tangent)``, pointers as ``numba.carray`` takes them.
    """

    def __init__(self, function: Callable[..., int]) -> None:
        self.function = function

    @cached_property
    def _compiled(self) -> Any:
        return compiled(self.function, _SIGNATURE)

    @property
    def address(self) -> int:
        """Where the function is in this process."""
        return int(self._compiled.address)


@intrinsic
def _call_update(  # type: ignore[no-untyped-def]  # Numba has no types
    typing_context,
    address,  # noqa: ARG001  Numba hands it to ``generate``
    log_time,  # noqa: ARG001  likewise
    strain,
    stress,
    state,
    constants,
    new_stress,
    new_state,
    tangent,
):
    """See :data:`call_update`."""
    del typing_context
    arrays = (strain, stress, state, constants, new_stress, new_state, tangent)
    for one in arrays:
        if not (isinstance(one, types.Array) and one.layout == "C" and one.dtype == types.float64):
            raise TypingError(f"{one}: contiguous arrays of float64 are accepted")

    def generate(context, builder, signature, values):  # type: ignore[no-untyped-def]  # Numba has no types
        whole, number = ir.IntType(64), ir.DoubleType()
        kind = ir.FunctionType(whole, [whole, number, *[number.as_pointer()] * _POINTERS])
        function = builder.inttoptr(values[0], kind.as_pointer())
        made = [
            context.make_array(array)(context, builder, value)
            for array, value in zip(signature.args[2:], values[2:], strict=True)
        ]
        components = builder.extract_value(made[0].shape, 0)
        return builder.call(function, [components, values[1], *[one.data for one in made]])

    return types.int64(types.int64, types.float64, *arrays), generate


call_update: Any = _call_update
"""``call_update(address, log_time, strain, stress, state, constants, new_stress, new_state, tangent)`` in a kernel.

Calls the stress update at an address (int64) with arrays without gaps; there are as many components as strains."""
