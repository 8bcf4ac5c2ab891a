"""What the thin functions around laws in libraries share: some constants, memory on the stack, counters of troubles."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["DIFFERENCE", "NUMBERS", "SHARED", "SharedPlaces", "note_trouble", "numbers_on_the_stack"]


class SharedPlaces(NamedTuple):
    """Where the constants hold what both thin functions read; what one of them reads alone begins at ``own``."""

    troubles: int = 0
    """Address of an int64 counter for each reason why a step has no stress."""
    state_count: int = 1
    """Number of the state variables that the library keeps."""
    stress_factor: int = 2
    time_factor: int = 3
    """Units of stress of the library a kPa, of time a day."""
    numerical: int = 4
    """1: the tangent is found by differences."""
    least_time: int = 5
    least_log_time: int = 6
    """The least time increment, day, as many divide by it, and its logarithm."""
    limit: int = 7
    """Place in the state of the variable that shows whether the point yields; -1: none."""
    own: int = 8


SHARED: Final = SharedPlaces()

DIFFERENCE: Final = 1.0e-7
"""Of strain, where a tangent is found by differences."""

NUMBERS = types.CPointer(types.float64)  # type: ignore[no-untyped-call]  # Numba has no types


def numbers_on_the_stack(size: int) -> Any:
    """A function, for kernels, that reserves memory for numbers of 8 bytes as long as its caller runs."""

    @intrinsic
    def room(typing_context):  # type: ignore[no-untyped-def]  # Numba has no types
        del typing_context

        def generate(_context, builder, _signature, _values):  # type: ignore[no-untyped-def]  # Numba has no types
            return cgutils.alloca_once(builder, ir.DoubleType(), size=size)  # type: ignore[no-untyped-call]  # Numba's

        return NUMBERS(), generate

    return room


@intrinsic
def _make_note(typing_context, counters, place):  # type: ignore[no-untyped-def]  # noqa: ARG001  Numba hands them on
    """Count a trouble at a place behind an address."""
    del typing_context

    def generate(_context, builder, _signature, values):  # type: ignore[no-untyped-def]  # Numba has no types
        whole = ir.IntType(64)
        counter = builder.gep(builder.inttoptr(values[0], whole.as_pointer()), [values[1]])
        builder.store(builder.add(builder.load(counter), ir.Constant(whole, 1)), counter)
        return ir.Constant(ir.LiteralStructType([]), None)

    return types.none(types.int64, types.int64), generate


note_trouble: Any = _make_note  # Numba's type of an intrinsic counts its first argument, which it hands over itself
