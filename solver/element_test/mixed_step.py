"""One time step of a material point of any law under mixed stress and strain control."""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.constitutive.tensors import solve_dense
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update

__all__ = ["Room", "mixed_step"]

_ITERATIONS: Final = 40
_HALVINGS: Final = 8
_RESIDUAL: Final = 1.0e-10

Room = tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]
"""Memory for a step: shapes (n,), (n,), (n, 1), (n, n), (n, n)."""


@kernel
def _residual(
    stress_rows: FloatArray,
    strain_rows: FloatArray,
    of_stress: BoolArray,
    target: FloatArray,
    stress: FloatArray,
    strain: FloatArray,
    size: float,
    residual: FloatArray,
) -> float:
    """Fill the difference of every control from its target, those of stress divided by ``size``; the largest one."""
    worst = 0.0
    for i in range(target.shape[0]):
        value = 0.0
        for k in range(target.shape[0]):
            value += stress_rows[i, k] * stress[k] + strain_rows[i, k] * strain[k]
        residual[i] = (value - target[i]) / (size if of_stress[i] else 1.0)
        if not abs(residual[i]) < math.inf:
            return math.inf
        worst = max(worst, abs(residual[i]))
    return worst


@kernel
def mixed_step(
    stress_rows: FloatArray,
    strain_rows: FloatArray,
    of_stress: BoolArray,
    target: FloatArray,
    stress: FloatArray,
    log_time: float,
    state: FloatArray,
    address: int,
    constants: FloatArray,
    strain: FloatArray,
    new: FloatArray,
    new_state: FloatArray,
    room: Room,
) -> int:
    """Strain increment for which all controls meet their targets, by Newton's method with line search.

    Parameters
    ----------
    stress_rows, strain_rows
        Shapes (n, n), n of 4 or 6: each control is a combination of the new stress plus one of the strain increment.
    of_stress, target
        Shapes (n,): whether a control has a part of stress, so that it is in kPa; and its value at the end of the step.
    stress, log_time, state, address, constants
        As for :func:`geoswarm.solver.laws.binary.call_update`.
    strain
        (n,): strain increment to start from; becomes the solution.
    new, new_state
        Filled: stress (n,) and state at the end.
    room
        Memory, its content does not matter.

    Returns
    -------
    int
        As the law's, or -1 when no solution was found.
    """
    count = target.shape[0]
    residual, trial, right, tangent, matrix = room
    size = 1.0
    for k in range(3):
        size = max(size, abs(stress[k]))
    status: int = call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
    if status < 0:
        for i in range(count):
            strain[i] = 0.0
        status = call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
        if status < 0:
            return -1
    worst = _residual(stress_rows, strain_rows, of_stress, target, new, strain, size, residual)
    from_none = True
    for i in range(count):
        from_none = from_none and strain[i] == 0.0
    blind, left = False, _ITERATIONS
    while left > 0:
        left -= 1
        if worst <= _RESIDUAL:
            return status
        for i in range(count):
            right[i, 0] = -residual[i]
            scale = 1.0 / size if of_stress[i] else 1.0
            for k in range(count):
                value = strain_rows[i, k]
                if of_stress[i]:
                    for m in range(count):
                        value += stress_rows[i, m] * tangent[m, k]
                matrix[i, k] = scale * value
        if not solve_dense(matrix, right):
            return -1
        step = 1.0
        accepted = False
        before = status
        for _ in range(_HALVINGS):
            for i in range(count):
                trial[i] = strain[i] + step * right[i, 0]
            status = call_update(address, log_time, trial, stress, state, constants, new, new_state, tangent)
            if status >= 0:
                now = _residual(stress_rows, strain_rows, of_stress, target, new, trial, size, residual)
                if blind or now < (1.0 - 1.0e-4 * step) * worst or now <= _RESIDUAL:
                    worst = now
                    accepted = True
                    break
            step *= 0.5
        blind = False
        if from_none and worst > 100.0 * _RESIDUAL and (left == 0 or not accepted):
            # Controls of strain may hold back those of stress: once more, with a first step that meets the former.
            from_none, blind, left = False, True, _ITERATIONS
            for i in range(count):
                strain[i] = 0.0
            status = call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
            worst = _residual(stress_rows, strain_rows, of_stress, target, new, strain, size, residual)
            continue
        if not accepted:
            # Rounding may stop the descent close to the solution.
            call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
            return before if worst <= 100.0 * _RESIDUAL else -1
        for i in range(count):
            strain[i] = trial[i]
    return -1
