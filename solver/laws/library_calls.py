"""What the thin functions around laws in libraries share: memory on the stack, counters of troubles."""

from __future__ import annotations

from typing import Any, Final

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

__all__ = ["DIFFERENCE", "NUMBERS", "note_trouble", "numbers_on_the_stack"]

DIFFERENCE: Final = 1.0e-7
"""Of strain, where a tangent is found by differences."""

NUMBERS = types.CPointer(types.float64)  # type: ignore[no-untyped-call]  # Numba has no types


def numbers_on_the_stack(size: int) -> Any:
    """A function, for kernels, that makes room for so many numbers of 8 bytes as long as its caller runs."""

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
