"""One time step of a material point of any law under mixed stress and strain control."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.constitutive.tensors import solve_dense
from geoswarm.solver.kernels.jit import kernel
from geoswarm.solver.laws.binary import call_update

__all__ = ["mixed_step", "three_ways"]

_ITERATIONS: Final = 40
_HALVINGS: Final = 8
_RESIDUAL: Final = 1.0e-12


@kernel
def _residual(
    rows: FloatArray,
    of_stress: BoolArray,
    target: FloatArray,
    stress: FloatArray,
    strain: FloatArray,
    size: float,
    residual: FloatArray,
) -> float:
    """Fill the difference of every control from its target, stresses divided by ``size``; the largest one."""
    worst = 0.0
    for i in range(6):
        value = 0.0
        for k in range(6):
            value += rows[i, k] * (stress[k] if of_stress[i] else strain[k])
        residual[i] = (value - target[i]) / (size if of_stress[i] else 1.0)
        worst = max(worst, abs(residual[i]))
    return worst if worst == worst else math.inf


@kernel
def _copy(source: FloatArray, target: FloatArray) -> None:
    """Copy an array (n,); in a loop, as assigning arrays takes seconds to compile."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@kernel
def mixed_step(
    rows: FloatArray,
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
) -> int:
    """Strain increment for which all controls meet their targets, by Newton's method with line search.

    Parameters
    ----------
    rows, of_stress, target
        Shapes (6, 6), (6,), (6,): combinations, whether they are of stress or of the strain increment, and their values
        at the end of the step.
    stress, log_time, state, address, constants
        As for :func:`geoswarm.solver.laws.binary.call_update`.
    strain
        (6,): strain increment to start from; becomes the solution.
    new, new_state
        Filled: stress (6,) and state at the end.

    Returns
    -------
    int
        As the law's, or -1 when no solution was found.
    """
    size = 1.0
    for k in range(3):
        size = max(size, abs(stress[k]))
    residual, tangent, trial = np.empty(6), np.empty((6, 6)), np.empty(6)
    matrix, right = np.empty((6, 6)), np.empty((6, 1))
    status: int = call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
    if status < 0:
        strain[:] = 0.0
        status = call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
        if status < 0:
            return -1
    worst = _residual(rows, of_stress, target, new, strain, size, residual)
    for _ in range(_ITERATIONS):
        if worst <= _RESIDUAL:
            return status
        for i in range(6):
            right[i, 0] = -residual[i]
            for k in range(6):
                matrix[i, k] = 0.0 if of_stress[i] else rows[i, k]
            if of_stress[i]:
                for k in range(6):
                    for m in range(6):
                        matrix[i, m] += rows[i, k] * tangent[k, m] / size
        if not solve_dense(matrix, right):
            return -1
        step = 1.0
        accepted = False
        before = status
        for _ in range(_HALVINGS):
            for i in range(6):
                trial[i] = strain[i] + step * right[i, 0]
            status = call_update(address, log_time, trial, stress, state, constants, new, new_state, tangent)
            if status >= 0:
                now = _residual(rows, of_stress, target, new, trial, size, residual)
                if now < (1.0 - 1.0e-4 * step) * worst or now <= _RESIDUAL:
                    worst = now
                    accepted = True
                    break
            step *= 0.5
        if not accepted:
            # Rounding may stop the descent close to the solution.
            call_update(address, log_time, strain, stress, state, constants, new, new_state, tangent)
            return before if worst <= 100.0 * _RESIDUAL else -1
        _copy(trial, strain)
    return -1


@kernel
def three_ways(
    rows: FloatArray,
    of_stress: BoolArray,
    goal: FloatArray,
    start: FloatArray,
    begin: float,
    end: float,
    log_time: float,
    log_length: float,
    stress: FloatArray,
    state: FloatArray,
    guess: FloatArray,
    address: int,
    constants: FloatArray,
    stresses: FloatArray,
    strains: FloatArray,
    states: FloatArray,
) -> int:
    """Go between two fractions of the controls' way in one, in two and in three implicit substeps.

    Parameters
    ----------
    goal, start
        (6,): values of the controls at the end and, for those of stress, at the beginning of the whole way.
    begin, end
        Fractions of the way.
    log_time, log_length
        Substeps are equal in time, ``log_time`` being ln(time/day) of all; or, for ``log_length`` above 0, equal in
        logarithmic time s = 0 .. ``log_length``, ``log_time`` then being ln(theta/day).
    stress, state, address, constants
        As for :func:`mixed_step`.
    guess
        (6,): expected strain increment.
    stresses, strains, states
        Filled: stress (3, 6), strain increment (3, 6) and state (3, s) at the end of each way.

    Returns
    -------
    int
        As the law's in the last substep, or -1 when no solution was found.
    """
    status = -1
    target, piece = np.empty(6), np.empty(6)
    now, reached = np.empty(6), np.empty(6)
    internal, kept = np.empty(state.shape[0]), np.empty(state.shape[0])
    for way in range(3):
        count = way + 1
        _copy(stress, now)
        _copy(state, internal)
        for i in range(6):
            piece[i] = (guess[i] if way == 0 else strains[way - 1, i]) / count
            strains[way, i] = 0.0
        for step in range(1, count + 1):
            fraction = begin + (end - begin) * step / count
            for i in range(6):
                if of_stress[i]:
                    target[i] = start[i] + (goal[i] - start[i]) * fraction
                else:
                    target[i] = goal[i] * (end - begin) / count
            share = log_time - math.log(count)
            if log_length > 0.0:
                s = log_length / count
                share = log_time + step * s + math.log(-math.expm1(-s))
            status = mixed_step(rows, of_stress, target, now, share, internal, address, constants, piece, reached, kept)
            if status < 0:
                return -1
            _copy(reached, now)
            _copy(kept, internal)
            for i in range(6):
                strains[way, i] += piece[i]
        for i in range(6):
            stresses[way, i] = now[i]
        for i in range(state.shape[0]):
            states[way, i] = internal[i]
    return status
