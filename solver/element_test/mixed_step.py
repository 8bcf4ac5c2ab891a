"""One time step of a material point under mixed stress and strain control, and its error-controlled sequence."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.constitutive.creep_update import creep_update
from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep, equivalent_pressure
from geoswarm.solver.constitutive.tensors import solve_dense
from geoswarm.solver.jit import kernel

__all__ = ["follow_stage", "mixed_step"]

_ITERATIONS: Final = 40
_HALVINGS: Final = 8
_RESIDUAL: Final = 1.0e-12
_MAX_STEPS: Final = 20000
_SMALLEST_STEP: Final = 1.0e-13
_FIRST_MOVE: Final = 1.0e-3  # of the movement
_FIRST_HOLD: Final = 0.02  # creep strain over kappa*
_LOCAL_SHARE: Final = 0.1
_KINK_SHARE: Final = 0.1


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
def mixed_step(
    rows: FloatArray,
    of_stress: BoolArray,
    target: FloatArray,
    stress: FloatArray,
    log_time: float,
    log_pp: float,
    guess: FloatArray,
    soil: SoftSoilCreep,
) -> tuple[FloatArray, FloatArray, float, int]:
    """Strain increment for which all controls meet their targets, by Newton's method with line search.

    Parameters
    ----------
    rows, of_stress, target
        Shapes (6, 6), (6,), (6,): combinations, whether they are of stress or of the strain increment, and their values
        at the end of the step.
    stress, log_time, log_pp, soil
        As for :func:`geoswarm.solver.constitutive.creep_update.creep_update`.
    guess
        Shape (6,), strain increment to start from.

    Returns
    -------
    stress, strain_increment, log_pp, active
        ``active`` as in the update; -1 when no solution was found.
    """
    size = 1.0
    for k in range(3):
        size = max(size, abs(stress[k]))
    strain = guess.copy()
    residual, trial_residual = np.empty(6), np.empty(6)
    new, tangent, new_pp, active = creep_update(stress, strain, log_time, log_pp, soil)
    if active < 0:
        strain[:] = 0.0
        new, tangent, new_pp, active = creep_update(stress, strain, log_time, log_pp, soil)
        if active < 0:
            return stress.copy(), strain, log_pp, -1
    worst = _residual(rows, of_stress, target, new, strain, size, residual)
    for _ in range(_ITERATIONS):
        if worst <= _RESIDUAL:
            return new, strain, new_pp, active
        matrix, right = np.zeros((6, 6)), np.empty((6, 1))
        for i in range(6):
            right[i, 0] = -residual[i]
            for k in range(6):
                if of_stress[i]:
                    for m in range(6):
                        matrix[i, m] += rows[i, k] * tangent[k, m] / size
                else:
                    matrix[i, k] = rows[i, k]
        if not solve_dense(matrix, right):
            return stress.copy(), strain, log_pp, -1
        step = 1.0
        accepted = False
        for _ in range(_HALVINGS):
            trial = strain + step * right[:, 0]
            trial_stress, trial_tangent, trial_pp, trial_active = creep_update(stress, trial, log_time, log_pp, soil)
            if trial_active >= 0:
                trial_worst = _residual(rows, of_stress, target, trial_stress, trial, size, trial_residual)
                if trial_worst < (1.0 - 1.0e-4 * step) * worst or trial_worst <= _RESIDUAL:
                    accepted = True
                    break
            step *= 0.5
        if not accepted:
            # Rounding may stop the descent close to the solution.
            return new, strain, new_pp, active if worst <= 100.0 * _RESIDUAL else -1
        strain, new, tangent, new_pp, worst = trial, trial_stress, trial_tangent, trial_pp, trial_worst
        active = trial_active
        for i in range(6):
            residual[i] = trial_residual[i]
    return new, strain, new_pp, -1


@kernel
def _substeps(
    count: int,
    rows: FloatArray,
    of_stress: BoolArray,
    values: FloatArray,
    start_values: FloatArray,
    begin: float,
    end: float,
    log_time: float,
    log_length: float,
    stress: FloatArray,
    log_pp: float,
    guess: FloatArray,
    soil: SoftSoilCreep,
) -> tuple[FloatArray, FloatArray, float, int]:
    """``count`` implicit substeps between two fractions of the controls' way; strain is the increment.

    Substeps are equal in time, ``log_time`` being ln(time/tau) of all; or, for ``log_length`` above 0, equal in
    logarithmic time s = 0 .. ``log_length``, ``log_time`` then being ln(theta/tau).
    """
    strain = np.zeros(6)
    active = -1
    share = log_time - math.log(count)
    s = log_length / count
    target = np.empty(6)
    piece = guess / count
    for step in range(1, count + 1):
        fraction = begin + (end - begin) * step / count
        for i in range(6):
            if of_stress[i]:
                target[i] = start_values[i] + (values[i] - start_values[i]) * fraction
            else:
                target[i] = values[i] * (end - begin) / count
        if log_length > 0.0:
            share = log_time + step * s + math.log(-math.expm1(-s))
        stress, piece, log_pp, active = mixed_step(rows, of_stress, target, stress, share, log_pp, piece, soil)
        if active < 0:
            return stress, strain, log_pp, active
        strain = strain + piece
    return stress, strain, log_pp, active


@kernel
def _log_rate(stress: FloatArray, log_pp: float, soil: SoftSoilCreep) -> float:
    """beta ln(p_eq/p_p): the logarithm of the creep rate over mu*/tau."""
    p = (stress[0] + stress[1] + stress[2]) / 3.0
    q2 = 0.0
    for k in range(3):
        q2 += 1.5 * (stress[k] - p) ** 2 + 3.0 * stress[k + 3] ** 2
    p_eq = equivalent_pressure(p, q2, soil)[0]
    return (soil.lambda_star - soil.kappa_star) / soil.mu_star * (math.log(p_eq) - log_pp)


@kernel
def _softplus(x: float) -> float:
    """ln(1 + exp(x)) without overflow."""
    return x + math.log1p(math.exp(-x)) if x > 0.0 else math.log1p(math.exp(x))


@kernel
def follow_stage(
    rows: FloatArray,
    of_stress: BoolArray,
    values: FloatArray,
    duration: float,
    moving: bool,
    times: FloatArray,
    tolerance: float,
    stress: FloatArray,
    strain: FloatArray,
    log_pp: float,
    soil: SoftSoilCreep,
) -> tuple[bool, float, FloatArray, FloatArray, FloatArray]:
    """Follow one movement of the controls, or one hold, with error-controlled steps.

    A hold is stepped in the logarithmic time of :mod:`geoswarm.solver.element_test.constant_load`. One, two and three
    implicit substeps a step are extrapolated to third order; the difference between second and third order, in strain
    (stress scaled by the elastic, ln p_p by the plastic compliance), is the error. Every requested time ends a step.

    Parameters
    ----------
    rows, of_stress, values
        The controls; ``values`` of strain rows are changes over the whole movement.
    duration
        Day; 0: an instantaneous movement.
    moving
        Whether the controls move to their values, linearly in time; otherwise all controls stay as they are.
    times
        Shape (m,), increasing, in (0, duration]; the last must be ``duration``. For an instantaneous movement [0].
    tolerance
        Error admitted in strain.
    stress, strain, log_pp, soil
        State at the beginning.

    Returns
    -------
    completed, fraction, stresses, strains, log_pps
        Fraction of the movement reached; states at the times, shapes (m, 6), (m, 6), (m,).
    """
    count = times.shape[0]
    stresses, strains, log_pps = np.empty((count, 6)), np.empty((count, 6)), np.empty(count)
    start_values, goal = np.zeros(6), np.zeros(6)
    for i in range(6):
        if of_stress[i]:
            for k in range(6):
                start_values[i] += rows[i, k] * stress[k]
            goal[i] = values[i] if moving else start_values[i]
        elif moving:
            goal[i] = values[i]
    local = _LOCAL_SHARE * tolerance
    hardening = soil.lambda_star - soil.kappa_star
    holding = duration > 0.0 and not moving
    length, now = (_FIRST_HOLD * soil.kappa_star / soil.mu_star if holding else _FIRST_MOVE), 0.0
    guess, guess_length = np.zeros(6), 1.0
    ends_stress, ends_strain, ends_pp = np.empty((3, 6)), np.empty((3, 6)), np.empty(3)
    steps, limit = 0, 0
    for point in range(count):
        until = times[point] / duration if duration > 0.0 else 1.0
        while now < until:
            # Length of a step: a fraction of the movement, or logarithmic time in a hold.
            whole, log_time, log_length = until - now, -math.inf, 0.0
            if holding:
                log_time = -_log_rate(stress, log_pp, soil)
                whole = _softplus(math.log((until - now) * duration / soil.tau) - log_time)
            steps += 1
            if steps > _MAX_STEPS or length < _SMALLEST_STEP * whole:
                return False, now, stresses, strains, log_pps
            cut = length >= 0.999999 * whole
            size = whole if cut else length
            end = until if cut else now + size
            if holding:
                log_length = size
                if not cut:
                    end = now + math.exp(log_time + size + math.log(-math.expm1(-size))) * soil.tau / duration
            elif duration > 0.0:
                log_time = math.log(duration * size / soil.tau)
            expected = guess * (size / guess_length)
            active = -1
            for substeps in range(1, 4):
                S, E, H, active = _substeps(
                    substeps,
                    rows,
                    of_stress,
                    goal,
                    start_values,
                    now,
                    end,
                    log_time,
                    log_length,
                    stress,
                    log_pp,
                    expected,
                    soil,
                )
                if active < 0:
                    break
                ends_stress[substeps - 1], ends_strain[substeps - 1], ends_pp[substeps - 1] = S, E, H
                expected = E
            if active < 0:
                length = 0.25 * size
                continue
            new_stress = 4.5 * ends_stress[2] - 4.0 * ends_stress[1] + 0.5 * ends_stress[0]
            new_strain = 4.5 * ends_strain[2] - 4.0 * ends_strain[1] + 0.5 * ends_strain[0]
            new_pp = 4.5 * ends_pp[2] - 4.0 * ends_pp[1] + 0.5 * ends_pp[0]
            low_stress = 3.0 * ends_stress[2] - 2.0 * ends_stress[1]
            low_strain = 3.0 * ends_strain[2] - 2.0 * ends_strain[1]
            low_pp = 3.0 * ends_pp[2] - 2.0 * ends_pp[1]
            error = hardening * abs(new_pp - low_pp)
            pressure = (stress[0] + stress[1] + stress[2]) / 3.0 + soil.shift
            compliance = soil.kappa_star / max(pressure, soil.pressure_floor)
            for k in range(6):
                error = max(error, abs(new_strain[k] - low_strain[k]))
                error = max(error, compliance * abs(new_stress[k] - low_stress[k]))
            if active != limit:
                # A limit was reached or left within the step: too late for the extrapolation to see. What happened
                # must be small itself.
                for k in range(6):
                    error = max(error, _KINK_SHARE * compliance * abs(new_stress[k] - stress[k]))
            factor = 5.0
            if error > 0.0:
                factor = min(5.0, max(0.1, 0.9 * (local / error) ** (1.0 / 3.0)))
            if not error <= local:
                length = size * min(factor, 0.9) if error < math.inf else 0.25 * size
                continue
            now = end
            stress, log_pp, limit = new_stress, new_pp, active
            strain = strain + new_strain
            guess, guess_length = new_strain, size
            # A step that was cut short to end at a time says nothing against the longer one planned.
            length = max(size * factor, length) if cut else size * factor
        stresses[point] = stress
        strains[point] = strain
        log_pps[point] = log_pp
    return True, now, stresses, strains, log_pps
