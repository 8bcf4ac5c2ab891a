"""A history of constant axial loads on a specimen, by error-controlled steps: the fast path of the laboratory tests.

Each stage is an instantaneous load (exact, :func:`geoswarm.solver.element_test.axial.confined_load`) and a hold. A hold
is stepped in the logarithmic time ``s = ln(1 + t/theta)``, theta = tau (p_eq/p_p)^-beta at the beginning of the step:
in it creep at constant stress is a straight line, whatever the creep exponent beta. A step is taken as one, two and
three implicit substeps of equal length in s, which are extrapolated to third order; the difference between the second
and third order is the error. Between the ends of a step, strain is the cubic through both values and rates; its
third-order part is kept below the tolerance as well. Compression positive; kPa, day, logarithmic strain.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, equivalent_pressure
from geoswarm.solver.element_test.axial import (
    confined_load,
    confined_step,
    creep_direction,
    lateral_limits,
    strain_increment,
)
from geoswarm.solver.kernels.jit import kernel

__all__ = ["DIVERGED", "FAILED_SOIL", "FINISHED", "constant_load_history"]

FINISHED: Final = 0
DIVERGED: Final = 1
FAILED_SOIL: Final = 2

# A hold passes beta ln(p_eq/p_p) logarithms of time, 1e4 and more where mu* is 1e-6, and steps where the stress ratio
# changes get shorter with the tolerance: mu* = 1e-5 with 1e-7 takes 2500 steps, 1e-6 with 1e-8 some 60 000.
_MAX_STEPS = 200_000  # of some 10 us
_KINK_SHARE = 0.1  # weight of the stress change in a step that reaches a limit
_LOCAL_SHARE = 0.1  # share of the tolerance granted to one step
_FIRST_SHARE = 0.1  # the first step of a stage is at least this share of it
_NO_CREEP = -30.0  # ln(dt/theta) below which the creep strain, mu* dt/theta, is nothing
_CUBIC_BULGE = 0.05  # largest value of the cubic part of Hermite's polynomial, 1/(12 sqrt 3), rounded up


@kernel
def _log_ratio(axial: float, lateral: float, log_pp: float, soil: SoftSoilCreep) -> float:
    """beta ln(p_eq/p_p): the logarithm of the creep rate over mu*/tau."""
    q = axial - lateral
    p_eq = equivalent_pressure((axial + 2.0 * lateral) / 3.0, q * q, soil)[0]
    return (soil.lambda_star - soil.kappa_star) / soil.mu_star * (math.log(p_eq) - log_pp)


@kernel
def _substeps(
    count: int,
    length: float,
    log_theta: float,
    axial: float,
    lateral: float,
    log_pp: float,
    guess: float,
    confined: bool,
    soil: SoftSoilCreep,
) -> tuple[float, float, float, float, bool]:
    """Hold in ``count`` implicit substeps over s = 0 .. length: lateral stress, ln p_p, both strains, converged.

    ``guess`` is the lateral stress expected at the end.
    """
    drift = (guess - lateral) / count
    piece = length / count
    log_piece = log_theta + math.log(-math.expm1(-piece))
    axial_strain, lateral_strain = 0.0, 0.0
    strength = soil.lambda_star - soil.kappa_star
    for step in range(1, count + 1):
        log_time = log_piece + step * piece
        if confined:
            lateral, strain, creep, converged = confined_step(
                axial, lateral, axial, log_time, log_pp, lateral + drift, soil
            )
            if not converged:
                return lateral, log_pp, axial_strain, lateral_strain, False
        else:
            strain, lateral_change, creep, _ = strain_increment(axial, lateral, axial, lateral, log_time, log_pp, soil)
            lateral_strain += lateral_change
        axial_strain += strain
        log_pp += creep / strength
    return lateral, log_pp, axial_strain, lateral_strain, True


@kernel
def _state_after(
    length: float,
    log_theta: float,
    axial: float,
    lateral: float,
    log_pp: float,
    confined: bool,
    soil: SoftSoilCreep,
) -> tuple[float, float]:
    """Lateral stress and ln p_p after a hold over s = 0 .. length, as accurate as a step."""
    one = int(np.int64(1))  # numbers that are written out would have the substeps compiled for each of them
    one_lat, one_pp, _, _, _ = _substeps(one, length, log_theta, axial, lateral, log_pp, lateral, confined, soil)
    if not confined:
        return one_lat, one_pp
    two_lat, two_pp, _, _, _ = _substeps(one + 1, length, log_theta, axial, lateral, log_pp, one_lat, confined, soil)
    three_lat, three_pp, _, _, _ = _substeps(
        one + 2, length, log_theta, axial, lateral, log_pp, two_lat, confined, soil
    )
    return 4.5 * three_lat - 4.0 * two_lat + 0.5 * one_lat, 4.5 * three_pp - 4.0 * two_pp + 0.5 * one_pp


@kernel
def _end_speeds(
    unit: float, now: float, pace: float, new_pace: float, direction: float, new_direction: float, change: float
) -> tuple[float, float, float]:
    """Creep speeds at both ends of a step that make the smoothest cubic, and the largest cubic part of it."""
    best = (unit, unit * now, math.inf)
    for start in (1.0, pace):
        for end in (now, new_pace):
            bulge = abs(unit * (start * direction + end * new_direction) - 2.0 * change) * _CUBIC_BULGE
            if bulge < best[2]:
                best = (unit * start, unit * end, bulge)
    return best


@kernel
def constant_load_history(
    soil: SoftSoilCreep,
    stresses: FloatArray,
    durations: FloatArray,
    lateral_ratio: float,
    initial_axial: float,
    initial_lateral: float,
    initial_log_pp: float,
    tolerance: float,
    times: FloatArray,
    firsts: IntArray,
    states: FloatArray,
    end_states: FloatArray,
) -> tuple[int, int, float, FloatArray, FloatArray]:
    """Strains of a specimen under constant axial loads.

    Parameters
    ----------
    soil
        Constants of the material.
    stresses, durations
        Shape (n,). Axial stress, kPa, and duration, day, of each stage.
    lateral_ratio
        Lateral over axial stress of a specimen that is free to strain (1: isotropic compression); negative for a
        specimen without lateral strain (oedometer).
    initial_axial, initial_lateral, initial_log_pp
        State before the first stage: stresses, kPa; ln p_p.
    tolerance
        Error admitted in strain.
    times
        Shape (m,). Times from the beginning of their stage, day, at most its duration, increasing in each stage.
    firsts
        Shape (n + 1,). The times of stage i are ``times[firsts[i]:firsts[i + 1]]``.
    states, end_states
        Filled with lateral stress, kPa, and ln p_p at the times (m, 2) and at the ends of the stages (n, 2), where they
        are wanted; otherwise without rows.

    Returns
    -------
    status, stage, time, output, ends
        :data:`FINISHED`, :data:`DIVERGED` (no solution) or :data:`FAILED_SOIL` (the load is above the strength); the
        stage and the time in it at which the calculation ended; axial and lateral strain since the initial state at
        the times, shape (m, 2), and at the ends of the stages, shape (n, 2).
    """
    confined = lateral_ratio < 0.0
    output = np.empty((times.shape[0], 2))
    ends = np.empty((stresses.shape[0], 2))
    axial, lateral, log_pp = initial_axial, initial_lateral, initial_log_pp
    axial_strain, lateral_strain = 0.0, 0.0
    stiffness = soil.lambda_star - soil.kappa_star
    local = _LOCAL_SHARE * tolerance
    length = 2.0
    one = int(np.int64(1))  # as above
    for stage in range(stresses.shape[0]):
        load = stresses[stage]
        if confined:
            lateral, change, completed = confined_load(axial, lateral, load, log_pp, soil)
            if not completed:
                return DIVERGED, stage, 0.0, output, ends
            axial_strain += change
        else:
            new_lateral = lateral_ratio * load
            lower, upper, _, _ = lateral_limits(load, soil)
            if not lower <= new_lateral <= upper:
                return FAILED_SOIL, stage, 0.0, output, ends
            change, lateral_change, _, _ = strain_increment(axial, lateral, load, new_lateral, -math.inf, log_pp, soil)
            axial_strain += change
            lateral_strain += lateral_change
            lateral = new_lateral
        axial = load
        duration = durations[stage]
        now = 0.0
        point, last = firsts[stage], firsts[stage + 1]
        log_rate = _log_ratio(axial, lateral, log_pp, soil)
        direction, lateral_direction, pace, held = creep_direction(axial, lateral, confined, soil)
        steps = 0
        while now < duration:
            log_theta = math.log(soil.tau) - log_rate
            remaining = duration - now
            x = math.log(remaining) - log_theta
            if x < _NO_CREEP:
                for rest in range(point, last):
                    output[rest, 0] = axial_strain
                    output[rest, 1] = lateral_strain
                    if end_states.shape[0] > 0:
                        states[rest, 0], states[rest, 1] = lateral, log_pp
                break
            whole = x + math.log1p(math.exp(-x)) if x > 0.0 else math.log1p(math.exp(x))
            if steps == 0:
                length = max(length, _FIRST_SHARE * whole)
            if length > 0.999 * whole or not confined:
                length = whole
            elif length > 0.5 * whole:
                length = 0.5 * whole
            scale = soil.kappa_star / ((axial + 2.0 * lateral) / 3.0 + soil.shift + soil.pressure_floor)
            while True:
                steps += 1
                if steps > _MAX_STEPS or not length > 1.0e-14 * whole:
                    return DIVERGED, stage, now, output, ends
                one_lat, one_pp, one_ax, one_ls, ok1 = _substeps(
                    one, length, log_theta, axial, lateral, log_pp, lateral, confined, soil
                )
                if not confined:
                    # Constant stress: one step is exact.
                    new_lat, new_pp, new_ax, new_ls = one_lat, one_pp, one_ax, one_ls
                    error = 0.0
                else:
                    two_lat, two_pp, two_ax, _, ok2 = _substeps(
                        one + 1, length, log_theta, axial, lateral, log_pp, one_lat, confined, soil
                    )
                    three_lat, three_pp, three_ax, _, ok3 = _substeps(
                        one + 2, length, log_theta, axial, lateral, log_pp, two_lat, confined, soil
                    )
                    if not (ok1 and ok2 and ok3):
                        length *= 0.25
                        continue
                    new_lat = 4.5 * three_lat - 4.0 * two_lat + 0.5 * one_lat
                    new_pp = 4.5 * three_pp - 4.0 * two_pp + 0.5 * one_pp
                    new_ax = 4.5 * three_ax - 4.0 * two_ax + 0.5 * one_ax
                    new_ls = 0.0
                    error = abs(new_ax - 3.0 * three_ax + 2.0 * two_ax)
                    error = max(error, scale * abs(new_lat - 3.0 * three_lat + 2.0 * two_lat))
                    error = max(error, stiffness * abs(new_pp - 3.0 * three_pp + 2.0 * two_pp))
                new_rate = _log_ratio(axial, new_lat, new_pp, soil)
                new_direction, new_lateral_direction, new_pace, new_held = creep_direction(
                    axial, new_lat, confined, soil
                )
                if new_held != held:
                    # A limit was reached within the step: too late for the extrapolation to see. What happened must
                    # be small itself.
                    error = max(error, _KINK_SHARE * scale * abs(new_lat - lateral))
                factor = 0.9 * (local / error) ** (1.0 / 3.0) if error > 0.0 else 5.0
                # d strain/d s at both ends, times the length of the step: at this very state, or under way. Long steps
                # in s (large beta) pass the transient between the two at once; the smoother cubic shows which holds.
                speed, end_speed, bulge = _end_speeds(
                    soil.mu_star * length,
                    math.exp(new_rate - log_rate + length),
                    pace,
                    new_pace,
                    direction,
                    new_direction,
                    new_ax,
                )
                if confined and bulge > 0.0:
                    factor = min(factor, 0.9 * (local / bulge) ** (1.0 / 3.0))
                if (error <= local and bulge <= local) or not confined:
                    break
                length *= max(0.2, min(factor, 0.9))
            final = length >= whole
            end = duration if final else now + math.exp(log_theta + length + math.log(-math.expm1(-length)))
            while point < last and (times[point] <= end or final):
                at = length
                if final and times[point] >= duration:
                    fraction = 1.0
                else:
                    x = math.log(times[point] - now) - log_theta
                    at = x + math.log1p(math.exp(-x)) if x > 0.0 else math.log1p(math.exp(x))
                    fraction = min(at / length, 1.0)
                left, right = fraction, 1.0 - fraction
                value = left * left * (3.0 - 2.0 * left)
                start_part, end_part = left * right * right, left * left * right
                output[point, 0] = (
                    axial_strain
                    + value * new_ax
                    + start_part * speed * direction
                    - end_part * end_speed * new_direction
                )
                output[point, 1] = (
                    lateral_strain
                    + value * new_ls
                    + start_part * speed * lateral_direction
                    - end_part * end_speed * new_lateral_direction
                )
                if end_states.shape[0] > 0:
                    states[point, 0], states[point, 1] = _state_after(
                        min(at, length), log_theta, axial, lateral, log_pp, confined, soil
                    )
                point += 1
            now = end
            lateral, log_pp = new_lat, new_pp
            axial_strain += new_ax
            lateral_strain += new_ls
            log_rate, direction, pace, held = new_rate, new_direction, new_pace, new_held
            lateral_direction = new_lateral_direction
            if confined:
                length *= min(factor, 4.0)
        ends[stage, 0] = axial_strain
        ends[stage, 1] = lateral_strain
        if end_states.shape[0] > 0:
            end_states[stage, 0], end_states[stage, 1] = lateral, log_pp
    return FINISHED, stresses.shape[0], 0.0, output, ends
