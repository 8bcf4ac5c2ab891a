"""A thin function with the binary interface of laws around a generic behaviour of MFront (small strain, isotropic).

A behaviour is a C function of one pointer, to 21 words: error message, time increment, stiffness, ratio of time
increments, speed of sound, and two states of eight pointers each (``mfront_gb_BehaviourData`` of TFEL). Tension is
positive in it; tensors are vectors in the notation of Mandel, shear times sqrt(2), in the order xx, yy, zz, xy, xz, yz,
four or six of them. It exists once for each hypothesis: three dimensions for six components, plane strain (or axial
symmetry) for four.

Everything that a behaviour needs in addition to the strain increment is in the constants: what all laws in libraries
have (:data:`geoswarm.solver.laws.libraries.calls.SHARED`), its addresses (:data:`PLACES`), and from ``tail`` on the
kinds of its internal state variables, external state variables and material properties. The state holds the internal
state variables as the behaviour knows them, a tensor with six numbers, and behind them the total strain (6,),
compression positive.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.libraries.calls import DIFFERENCE, NUMBERS, SHARED, note_trouble, numbers_on_the_stack

__all__ = ["BESIDE", "MESSAGE_LENGTH", "MOST_STATE", "PLACES", "TROUBLES", "Places", "mfront_update"]


class Places(NamedTuple):
    """Where the constants hold what no other law in a library has."""

    address: int = SHARED.own
    """Of the function for six components; 0: none."""
    plane_address: int = SHARED.own + 1
    """Of the function for four components; 0: none."""
    message: int = SHARED.own + 2
    """Address of :data:`MESSAGE_LENGTH` bytes for the words of an error."""
    external_count: int = SHARED.own + 3
    """Number of external state variables."""
    tail: int = SHARED.own + 4
    """1 for each internal state variable that is a tensor, else 0; then external state variables; then properties."""


PLACES: Final = Places()

TROUBLES: Final = ("found no stress", "gave unreliable results", "gave numbers that are none")
"""Why a step has no stress, in words, in the order of the counters."""

BESIDE: Final = 6
"""State variables beside those of the behaviour: total strain."""

MESSAGE_LENGTH: Final = 512
MOST_STATE: Final = 120
"""Numbers in the internal state variables of a behaviour."""

_ROOT: Final = math.sqrt(2.0)
_CONSISTENT: Final = 4.0  # the request for the consistent tangent, in the first place of the stiffness

# Places in the work space, numbers of 8 bytes.
_K, _RATIO, _SPEED, _OLD_STRAIN, _NEW_STRAIN, _OLD_STRESS, _NEW_STRESS = 0, 36, 37, 38, 44, 50, 56
_DENSITY, _ENERGY, _OLD_STATE = 62, 63, 67
_NEW_STATE: Final = _OLD_STATE + MOST_STATE
_SIZE: Final = _NEW_STATE + MOST_STATE
_WORDS: Final = 21


# Numba has no types, and hands the arguments on.
@intrinsic
def _make_call(typing_context, address, message, step, work, constants, external, properties):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call the behaviour; its exit status. ``external`` and ``properties`` are places in the constants."""
    del typing_context

    def generate(_context, builder, _signature, values):  # type: ignore[no-untyped-def]  # Numba has no types
        address, message, step, work, constants, external, properties = values
        whole = ir.IntType(64)
        data = cgutils.alloca_once(builder, whole, size=_WORDS)  # type: ignore[no-untyped-call]  # Numba has no types

        def at(place: int) -> Any:
            return builder.ptrtoint(builder.gep(work, [ir.Constant(whole, place)]), whole)

        beyond = [builder.ptrtoint(builder.gep(constants, [place]), whole) for place in (properties, external)]
        words = [message, builder.bitcast(step, whole), at(_K), at(_RATIO), at(_SPEED)]
        for end in (0, 1):
            words += [
                *(at(_NEW_STRAIN if end else _OLD_STRAIN), at(_NEW_STRESS if end else _OLD_STRESS), at(_DENSITY)),
                *(beyond[0], at(_NEW_STATE if end else _OLD_STATE), at(_ENERGY + 2 * end), at(_ENERGY + 2 * end + 1)),
                beyond[1],
            ]
        for place, word in enumerate(words):
            builder.store(word, builder.gep(data, [ir.Constant(whole, place)]))
        kind = ir.FunctionType(ir.IntType(32), [whole.as_pointer()])
        status = builder.call(builder.inttoptr(address, kind.as_pointer()), [data])
        return builder.sext(status, whole)

    whole = types.int64
    return whole(whole, whole, types.float64, NUMBERS, NUMBERS, whole, whole), generate


# Numba's type of an intrinsic counts its first argument, which it hands over itself.
_work = numbers_on_the_stack(_SIZE)
_behaviour: Any = _make_call


@kernel
def _mandel(component: int) -> int:
    """Where the behaviour has a component (xx, yy, zz, xy, yz, zx)."""
    return component if component < 4 else 9 - component


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
) -> int:
    """One call of the behaviour, the strain component ``shift`` raised by the difference; the status.

    Pointers as in :mod:`geoswarm.solver.laws.binary`. The stiffness stays in the work space.
    """
    count, externals = int(constants[SHARED.state_count]), int(constants[PLACES.external_count])
    factor = constants[SHARED.stress_factor]
    length = 0
    for variable in range(count):
        length += 6 if constants[PLACES.tail + variable] > 0.0 else 1
    for i in range(_OLD_STATE):
        work[i] = 0.0
    work[_K], work[_RATIO], work[_DENSITY] = _CONSISTENT, 1.0, 1.0
    for i in range(components):
        at = _mandel(i)
        work[_OLD_STRAIN + at] = -state[length + i] / (1.0 if i < 3 else _ROOT)
        step = strain[i] + (DIFFERENCE if i == shift else 0.0)
        work[_NEW_STRAIN + at] = work[_OLD_STRAIN + at] - step / (1.0 if i < 3 else _ROOT)
        work[_OLD_STRESS + at] = -factor * stress[i] * (1.0 if i < 3 else _ROOT)
        work[_NEW_STRESS + at] = work[_OLD_STRESS + at]
    read, place = 0, 0
    for variable in range(count):
        size, used = (6, components) if constants[PLACES.tail + variable] > 0.0 else (1, 1)
        for i in range(used):
            work[_OLD_STATE + place + i] = state[read + i]
            work[_NEW_STATE + place + i] = state[read + i]
        read += size
        place += used
    least = constants[SHARED.least_log_time]
    duration = math.exp(log_time) if log_time > least else constants[SHARED.least_time]
    address = int(constants[PLACES.address if components == 6 else PLACES.plane_address])
    external = PLACES.tail + count
    status = _behaviour(
        address,
        int(constants[PLACES.message]),
        constants[SHARED.time_factor] * duration,
        work,
        constants,
        external,
        external + externals,
    )
    troubles = int(constants[SHARED.troubles])
    if status != 1:
        note_trouble(troubles, 1 if status == 0 else 0)
        return -1
    wrong = 0
    for i in range(components * components):
        wrong += 0 if abs(work[_K + i]) < math.inf else 1
    read, place = 0, 0
    for i in range(length + BESIDE):
        new_state[i] = state[i]
    for variable in range(count):
        size, used = (6, components) if constants[PLACES.tail + variable] > 0.0 else (1, 1)
        for i in range(used):
            new_state[read + i] = work[_NEW_STATE + place + i]
            wrong += 0 if abs(new_state[read + i]) < math.inf else 1
        read += size
        place += used
    for i in range(components):
        new_stress[i] = -work[_NEW_STRESS + _mandel(i)] / (factor if i < 3 else factor * _ROOT)
        new_state[length + i] += strain[i]
        wrong += 0 if abs(new_stress[i]) < math.inf else 1
    if wrong > 0:
        note_trouble(troubles, 2)
        return -1
    limit = int(constants[SHARED.limit])
    return 1 if limit >= 0 and new_state[limit] > state[limit] else 0


@NumbaUpdate
def mfront_update(components, log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    """Call a generic behaviour; the interface is that of :mod:`geoswarm.solver.laws.binary`."""
    work = _work()
    differences = constants[SHARED.numerical] > 0.0
    C = carray(tangent, (components, components))
    status = 0
    # The step itself comes last: what it gives stays.
    for j in range(0 if differences else components, components + 1):
        status = _call(components, log_time, strain, j, stress, state, constants, new_stress, new_state, work)
        if status < 0:
            return -1
        if j < components:
            for i in range(components):
                C[i, j] = new_stress[i]
    share = 1.0 / constants[SHARED.stress_factor]
    for i in range(components):
        for j in range(components):
            if differences:
                C[i, j] = (C[i, j] - new_stress[i]) / DIFFERENCE
            else:
                weight = share / ((1.0 if i < 3 else _ROOT) * (1.0 if j < 3 else _ROOT))
                C[i, j] = weight * work[_K + components * _mandel(i) + _mandel(j)]
    return status
