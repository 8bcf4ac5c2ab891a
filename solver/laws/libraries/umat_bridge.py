"""A thin function with the binary interface of laws around a user routine of Abaqus (UMAT).

A UMAT is a Fortran subroutine with 37 arguments by reference, the length of the text CMNAME behind them by value.
Tension is positive in it, shear strains are engineering ones, the order is 11, 22, 33, 12, 13, 23, or 12, 23, 13 where
that is declared. Everything that the routine needs in addition to the strain increment is in the constants
(:data:`geoswarm.solver.laws.libraries.calls.SHARED`, :data:`PLACES`), its address included, so that one function serves
all routines and is compiled once.

Behind the routine's own state variables (STATEV) the state holds what its argument list has beside: total strain (6,),
compression positive, total time, day, and the number of increments, :data:`BESIDE` in all.

A routine that ends itself (XIT, STOP) has no way back; the utilities that ``geoswarm model build-umat`` links leave it
by ``longjmp`` to where :func:`_routine` has called ``_setjmp``. Where they are not linked there is no such place.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.libraries.calls import DIFFERENCE, NUMBERS, SHARED, note_trouble, numbers_on_the_stack

__all__ = ["BESIDE", "NAME_LENGTH", "PLACES", "TROUBLES", "Places", "umat_update"]


class Places(NamedTuple):
    """Where the constants hold what no other law in a library has."""

    address: int = SHARED.own
    """Of the routine."""
    returns: int = SHARED.own + 1
    """Address of the pointer by which XIT and STOP leave the routine; 0: none."""
    prop_count: int = SHARED.own + 2
    cyclic: int = SHARED.own + 3
    """1: shear in the order 12, 23, 13; 0: 12, 13, 23."""
    whole: int = SHARED.own + 4
    """1: the routine takes six components only."""
    temperature: int = SHARED.own + 5
    name: int = SHARED.own + 6
    """CMNAME, 64 of its 80 characters; blanks follow."""
    props: int = SHARED.own + 14
    """PROPS, to the end."""


PLACES: Final = Places()

TROUBLES: Final = ("asked for a shorter increment (PNEWDT)", "ended itself (XIT, STOP)", "gave numbers that are none")
"""Why a step has no stress, in words, in the order of the counters."""

BESIDE: Final = 8
"""State variables beside those of the routine."""

NAME_LENGTH: Final = 64

# Places in the work space, numbers of 8 bytes.
_STRESS, _STRAN, _DSTRAN, _DDSDDE, _DDSDDT, _DRPLDE = 0, 6, 12, 18, 54, 60
_TIME, _SSE, _SPD, _SCD, _RPL, _DRPLDT, _DTIME, _TEMP, _DTEMP = 66, 68, 69, 70, 71, 72, 73, 74, 75
_PNEWDT, _CELENT, _PREDEF, _DPRED, _COORDS, _DROT, _DFGRD0, _DFGRD1 = 76, 77, 78, 79, 80, 83, 92, 101
_WORK: Final = 110
_NAME: Final = 110  # CMNAME, 80 characters
_SIZE: Final = 120
# Places among the integers.
_NDI, _NSHR, _NTENS, _NSTATV, _NPROPS, _NOEL, _KSTEP, _KINC = 0, 1, 2, 3, 4, 5, 9, 13
_INTEGERS: Final = 16

_JUMP_BUFFER: Final = 512
"""Bytes; glibc takes 200 on x86-64, 312 on aarch64."""

_BLANKS: Final = float(np.frombuffer(b" " * 8)[0])

_integers = types.CPointer(types.int32)  # type: ignore[no-untyped-call]  # Numba has no types


@intrinsic
def _make_counts(typing_context):  # type: ignore[no-untyped-def]  # Numba has no types
    """Integers of four bytes on the stack."""
    del typing_context

    def generate(_context, builder, _signature, _values):  # type: ignore[no-untyped-def]  # Numba has no types
        return cgutils.alloca_once(builder, ir.IntType(32), size=_INTEGERS)  # type: ignore[no-untyped-call]  # Numba's

    return _integers(), generate


def _caller(module: ir.Module) -> ir.Function:
    """The function that calls the routine: (address, returns, work, integers, STATEV, PROPS) -> 1 if it left by a jump.

    A function of its own that is not inlined: what its caller keeps in registers is as it was when ``_setjmp`` comes
    back.
    """
    whole, number, integer, byte = ir.IntType(64), ir.DoubleType(), ir.IntType(32), ir.IntType(8)
    kind = ir.FunctionType(whole, [whole, whole, number.as_pointer(), integer.as_pointer(), *[number.as_pointer()] * 2])
    name = "geoswarm_call_umat"
    if name in module.globals:
        return module.globals[name]
    made = ir.Function(module, kind, name)
    made.linkage = "internal"
    made.attributes.add("noinline")
    address, returns, work, integers, statev, props = made.args
    builder = ir.IRBuilder(made.append_basic_block("entry"))

    def at(place: int) -> Any:
        return builder.gep(work, [ir.Constant(whole, place)])

    def count(place: int) -> Any:
        return builder.gep(integers, [ir.Constant(whole, place)])

    arguments = [
        *(at(_STRESS), statev, at(_DDSDDE), at(_SSE), at(_SPD), at(_SCD), at(_RPL), at(_DDSDDT), at(_DRPLDE)),
        *(at(_DRPLDT), at(_STRAN), at(_DSTRAN), at(_TIME), at(_DTIME), at(_TEMP), at(_DTEMP), at(_PREDEF), at(_DPRED)),
        builder.bitcast(at(_NAME), byte.as_pointer()),
        *(count(_NDI), count(_NSHR), count(_NTENS), count(_NSTATV), props, count(_NPROPS)),
        *(at(_COORDS), at(_DROT), at(_PNEWDT), at(_CELENT), at(_DFGRD0), at(_DFGRD1)),
        *(count(_NOEL), count(_NOEL + 1), count(_NOEL + 2), count(_NOEL + 3), count(_KSTEP), count(_KINC)),
    ]
    routine = ir.FunctionType(ir.VoidType(), [*(one.type for one in arguments), whole])
    called = builder.inttoptr(address, routine.as_pointer())
    length = ir.Constant(whole, 80)
    with builder.if_then(builder.icmp_unsigned("!=", returns, ir.Constant(whole, 0))):
        target = builder.inttoptr(returns, byte.as_pointer().as_pointer())
        buffer = builder.alloca(byte, _JUMP_BUFFER)
        buffer.align = 16
        setjmp = module.globals.get("_setjmp")
        if setjmp is None:
            setjmp = ir.Function(module, ir.FunctionType(integer, [byte.as_pointer()]), "_setjmp")
            setjmp.attributes.add("returns_twice")
        builder.store(buffer, target)
        came = builder.call(setjmp, [buffer])
        with builder.if_then(builder.icmp_signed("!=", came, ir.Constant(integer, 0))):
            builder.store(ir.Constant(byte.as_pointer(), None), target)
            builder.ret(ir.Constant(whole, 1))
        builder.call(called, [*arguments, length])
        builder.store(ir.Constant(byte.as_pointer(), None), target)
        builder.ret(ir.Constant(whole, 0))
    builder.call(called, [*arguments, length])
    builder.ret(ir.Constant(whole, 0))
    return made


# Numba has no types, and hands the arguments on.
@intrinsic
def _make_call(typing_context, address, returns, work, integers, statev, props):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call the routine; 1 if it has left by a jump."""
    del typing_context

    def generate(_context, builder, _signature, values):  # type: ignore[no-untyped-def]  # Numba has no types
        address, returns, work, integers, statev, constants = values
        props = builder.gep(constants, [ir.Constant(ir.IntType(64), PLACES.props)])
        return builder.call(_caller(builder.module), [address, returns, work, integers, statev, props])

    return types.int64(types.int64, types.int64, NUMBERS, _integers, NUMBERS, NUMBERS), generate


# Numba's type of an intrinsic counts its first argument, which it hands over itself.
_work = numbers_on_the_stack(_SIZE)
_counts: Any = _make_counts
_routine: Any = _make_call


@kernel
def _small_strain(work: Any, place: int, e0: float, e1: float, e2: float, e3: float, e4: float, e5: float) -> None:
    """Fill a matrix with 1 + strain: small strain without rotation."""
    work[place], work[place + 4], work[place + 8] = 1.0 + e0, 1.0 + e1, 1.0 + e2
    work[place + 1], work[place + 3] = e3, e3
    work[place + 5], work[place + 7] = e4, e4
    work[place + 2], work[place + 6] = e5, e5


@kernel
def _call(
    components: int,
    log_time: float,
    strain: Any,
    shift: int,
    stress: Any,
    state: Any,
    constants: Any,
    new_stress: Any,
    new_state: Any,
    work: Any,
    integers: Any,
) -> int:
    """One call of the routine, the strain component ``shift`` raised by the difference; the status.

    Pointers as in :mod:`geoswarm.solver.laws.binary`. DDSDDE stays in the work space.
    """
    ntens = 6 if constants[PLACES.whole] > 0.0 else components
    # Where the routine has yz and zx.
    yz = 4 if constants[PLACES.cyclic] > 0.0 else 5
    zx = 9 - yz
    count = int(constants[SHARED.state_count])
    factor = constants[SHARED.stress_factor]
    for i in range(_DROT):
        work[i] = 0.0
    for i in range(4):
        work[_STRESS + i] = -factor * stress[i]
        work[_DSTRAN + i] = -strain[i]
        work[_STRAN + i] = -state[count + i]
    work[_STRAN + yz], work[_STRAN + zx] = -state[count + 4], -state[count + 5]
    if components == 6:
        work[_STRESS + yz], work[_STRESS + zx] = -factor * stress[4], -factor * stress[5]
        work[_DSTRAN + yz], work[_DSTRAN + zx] = -strain[4], -strain[5]
    if shift < components:
        work[_DSTRAN + (shift if shift < 4 else (yz if shift == 4 else zx))] -= DIFFERENCE
    for i in range(count + BESIDE):
        new_state[i] = state[i]
    least = constants[SHARED.least_log_time]
    step = math.exp(log_time) if log_time > least else constants[SHARED.least_time]
    unit = constants[SHARED.time_factor]
    work[_TIME] = unit * state[count + 6]
    work[_TIME + 1] = work[_TIME]
    work[_DTIME] = unit * step
    work[_TEMP] = constants[PLACES.temperature]
    work[_PNEWDT] = 1.0
    work[_CELENT] = 1.0
    _small_strain(work, _DROT, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    e0, e1, e2, e3 = work[_STRAN], work[_STRAN + 1], work[_STRAN + 2], 0.5 * work[_STRAN + 3]
    e4, e5 = 0.5 * work[_STRAN + yz], 0.5 * work[_STRAN + zx]
    _small_strain(work, _DFGRD0, e0, e1, e2, e3, e4, e5)
    e0, e1, e2, e3 = e0 + work[_DSTRAN], e1 + work[_DSTRAN + 1], e2 + work[_DSTRAN + 2], e3 + 0.5 * work[_DSTRAN + 3]
    e4, e5 = e4 + 0.5 * work[_DSTRAN + yz], e5 + 0.5 * work[_DSTRAN + zx]
    _small_strain(work, _DFGRD1, e0, e1, e2, e3, e4, e5)
    for i in range(8):
        work[_NAME + i] = constants[PLACES.name + i]
    work[_NAME + 8], work[_NAME + 9] = _BLANKS, _BLANKS
    integers[_NDI], integers[_NSHR], integers[_NTENS] = 3, ntens - 3, ntens
    integers[_NSTATV], integers[_NPROPS] = count, int(constants[PLACES.prop_count])
    for i in range(_NOEL, _KINC):
        integers[i] = 1
    integers[_KINC] = int(state[count + 7]) + 1
    left = _routine(
        int(constants[PLACES.address]), int(constants[PLACES.returns]), work, integers, new_state, constants
    )
    troubles = int(constants[SHARED.troubles])
    if left != 0:
        note_trouble(troubles, 1)
        return -1
    if work[_PNEWDT] < 1.0:
        note_trouble(troubles, 0)
        return -1
    # The stress comes last, as it was written last.
    wrong = 0
    for i in range(ntens * ntens):
        wrong += 0 if abs(work[_DDSDDE + i]) < math.inf else 1
    for i in range(count):
        wrong += 0 if abs(new_state[i]) < math.inf else 1
    share = -1.0 / factor
    for i in range(4):
        new_stress[i] = share * work[_STRESS + i]
    if components == 6:
        new_stress[4], new_stress[5] = share * work[_STRESS + yz], share * work[_STRESS + zx]
    for i in range(components):
        wrong += 0 if abs(new_stress[i]) < math.inf else 1
        new_state[count + i] += strain[i]
    if wrong > 0:
        note_trouble(troubles, 2)
        return -1
    new_state[count + 6] += step if log_time > least else 0.0
    new_state[count + 7] += 1.0
    limit = int(constants[SHARED.limit])
    return 1 if limit >= 0 and new_state[limit] > 0.0 else 0


@NumbaUpdate
def umat_update(components, log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    """Call a user routine; the interface is that of :mod:`geoswarm.solver.laws.binary`."""
    work, integers = _work(), _counts()
    differences = constants[SHARED.numerical] > 0.0
    C = carray(tangent, (components, components))
    status = 0
    # The step itself comes last: what it gives stays.
    for j in range(0 if differences else components, components + 1):
        status = _call(components, log_time, strain, j, stress, state, constants, new_stress, new_state, work, integers)
        if status < 0:
            return -1
        if j < components:
            for i in range(components):
                C[i, j] = new_stress[i]
    if differences:
        for i in range(components):
            for j in range(components):
                C[i, j] = (C[i, j] - new_stress[i]) / DIFFERENCE
        return status
    ntens = 6 if constants[PLACES.whole] > 0.0 else components
    share = 1.0 / constants[SHARED.stress_factor]
    for i in range(components):
        for j in range(components):
            C[i, j] = share * work[_DDSDDE + i + ntens * j]
    if components == 6 and constants[PLACES.cyclic] == 0.0:
        for j in range(6):
            C[4, j], C[5, j] = C[5, j], C[4, j]
        for i in range(6):
            C[i, 4], C[i, 5] = C[i, 5], C[i, 4]
    return status
