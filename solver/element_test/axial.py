"""One step of a specimen loaded along its axis: axial stress prescribed, lateral strain or lateral stress prescribed.

The principal axes never turn and the two lateral directions are equal, so a step is one scalar equation for the lateral
stress (confined specimen) or none at all (lateral stress prescribed). The physics is that of
:mod:`geoswarm.solver.constitutive.soft_soil_creep.physics`; the general update gives the same result (tested).
Compression positive.
"""

from __future__ import annotations

import math

from geoswarm.solver.constitutive.soft_soil_creep.physics import (
    ALPHA_GUARD,
    SoftSoilCreep,
    creep_increment,
    elastic_strain,
    equivalent_pressure,
    secant_compliance,
)
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = [
    "confined_load",
    "confined_step",
    "creep_direction",
    "equivalent_axial_pressure",
    "lateral_limits",
    "strain_increment",
]

_ITERATIONS = 60
_STRAIN_RESIDUAL = 1.0e-12
_PIECES = 8


def equivalent_axial_pressure(axial: float, lateral: float, soil: SoftSoilCreep) -> float:
    """Equivalent pressure, kPa, of an axial and a lateral stress."""
    q = axial - lateral
    return equivalent_pressure((axial + 2.0 * lateral) / 3.0, q * q, soil)[0]


@kernel
def lateral_limits(axial: float, soil: SoftSoilCreep) -> tuple[float, float, float, float]:
    """Admissible range of the lateral stress under an axial stress.

    Returns
    -------
    lower, upper, lower_flow, upper_flow
        Limits (Mohr-Coulomb and tension cut-off), kPa, and the axial plastic strain for each unit of lateral elastic
        and creep strain that flow at that limit takes back (dilatancy psi; tension cut-off: none).
    """
    weak, strong, cohesion = 1.0 - soil.sin_phi, 1.0 + soil.sin_phi, 2.0 * soil.cohesion * soil.cos_phi
    lower = (weak * axial - cohesion) / strong
    lower_flow = 2.0 * (1.0 - soil.sin_psi) / (1.0 + soil.sin_psi)
    if lower < -soil.tension:
        lower = -soil.tension
        lower_flow = 0.0
    return lower, (strong * axial + cohesion) / weak, lower_flow, 2.0 * (1.0 + soil.sin_psi) / (1.0 - soil.sin_psi)


@kernel_in_place
def strain_increment(
    axial_old: float,
    lateral_old: float,
    axial: float,
    lateral: float,
    log_time: float,
    log_pp: float,
    soil: SoftSoilCreep,
) -> tuple[float, float, float, float]:
    """Elastic and creep strain of one step between two stresses.

    Returns
    -------
    axial_strain, lateral_strain, creep_volume, derivative
        ``derivative`` is that of the lateral strain by the new lateral stress at constant axial stress, 1/kPa.
    """
    p_old, q_old = (axial_old + 2.0 * lateral_old) / 3.0, axial_old - lateral_old
    p, q = (axial + 2.0 * lateral) / 3.0, axial - lateral
    elastic, compliance, compliance_p = secant_compliance(p_old, p, soil)
    tangent = compliance + compliance_p * (p - p_old)
    creep, creep_p, creep_q2, factor, factor_p, factor_q2 = creep_increment(p, q * q, log_time, log_pp, soil)
    shear = 0.5 / soil.shear_ratio
    volume = elastic + creep
    deviator = shear * compliance * (q - q_old) + factor * q
    volume_slope = 2.0 / 3.0 * (tangent + creep_p) - 2.0 * q * creep_q2
    deviator_slope = (
        2.0 / 3.0 * (shear * compliance_p * (q - q_old) + factor_p * q)
        - shear * compliance
        - factor
        - 2.0 * q * q * factor_q2
    )
    return (
        (volume + 2.0 * deviator) / 3.0,
        (volume - deviator) / 3.0,
        creep,
        (volume_slope - deviator_slope) / 3.0,
    )


@kernel
def confined_step(
    axial_old: float,
    lateral_old: float,
    axial: float,
    log_time: float,
    log_pp: float,
    guess: float,
    soil: SoftSoilCreep,
) -> tuple[float, float, float, bool]:
    """One step without lateral strain.

    Returns
    -------
    lateral, axial_strain, creep_volume, converged
        New lateral stress, kPa; strain increments. Safeguarded Newton iteration inside the limits of
        :func:`lateral_limits`; at a limit, plastic flow takes the lateral strain back.
    """
    lower, upper, lower_flow, upper_flow = lateral_limits(axial, soil)
    low, high = lower, upper
    lateral = min(max(guess, lower), upper)
    axial_strain, creep = 0.0, 0.0
    for _ in range(_ITERATIONS):
        axial_strain, lateral_strain, creep, slope = strain_increment(
            axial_old, lateral_old, axial, lateral, log_time, log_pp, soil
        )
        if lateral <= lower and lateral_strain >= 0.0:
            return lower, axial_strain + lower_flow * lateral_strain, creep, True
        if lateral >= upper and lateral_strain <= 0.0:
            return upper, axial_strain + upper_flow * lateral_strain, creep, True
        if lateral_strain > 0.0:
            high = lateral
        else:
            low = lateral
        change = -lateral_strain / slope
        trial = lateral + change
        if not (low <= trial <= high and slope > 0.0):
            bound = low if lateral_strain > 0.0 else high
            # A limit itself is a candidate solution; anything else inside the bracket is found by bisection.
            trial = bound if bound in (lower, upper) else 0.5 * (low + high)
            if trial == lateral:
                trial = 0.5 * (low + high)
        elif abs(lateral_strain) <= _STRAIN_RESIDUAL:
            return lateral, axial_strain, creep, True
        if abs(high - low) <= 1.0e-13 * (abs(high) + abs(low)):
            return lateral, axial_strain, creep, True
        lateral = trial
    return lateral, axial_strain, creep, False


@kernel
def confined_load(
    axial: float, lateral: float, target: float, log_pp: float, soil: SoftSoilCreep
) -> tuple[float, float, bool]:
    """Exact instantaneous change of the axial stress without lateral strain.

    Both the elastic stress path and the limits are straight lines in (axial, lateral) stress, and the secant modulus is
    exact along a straight path: the change is taken in pieces from one corner of the path to the next.

    Returns
    -------
    lateral, axial_strain, completed
        New lateral stress, kPa, and the axial strain increment.
    """
    elastic_slope = soil.nu_ur / (1.0 - soil.nu_ur)
    weak, strong = 1.0 - soil.sin_phi, 1.0 + soil.sin_phi
    cohesion = 2.0 * soil.cohesion * soil.cos_phi
    strain = 0.0
    way = 1.0 if target > axial else -1.0
    for _ in range(_PIECES):
        if axial == target:
            return lateral, strain, True
        slope = elastic_slope
        tolerance = 1.0e-11 * (abs(axial) + abs(lateral) + soil.pressure_floor)
        distance = abs(target - axial)
        # Lines lateral = gradient * axial + offset; side +1 where the lateral stress must stay above, -1 below.
        for first in (True, False):
            for line in range(3):
                gradient, offset, side = weak / strong, -cohesion / strong, 1.0
                if line == 1:
                    gradient, offset = 0.0, -soil.tension
                elif line == 2:
                    gradient, offset, side = strong / weak, cohesion / weak, -1.0
                if math.isinf(offset):
                    continue
                gap = side * (lateral - gradient * axial - offset)
                closing = side * way * (gradient - slope)  # how fast the gap closes with the axial stress
                if first:
                    if gap <= tolerance and closing > 0.0:
                        slope = gradient
                elif gap > tolerance and closing > 0.0:
                    distance = min(distance, gap / closing)
        new_axial = target if distance >= abs(target - axial) else axial + way * distance
        new_lateral = lateral + slope * (new_axial - axial)
        _, _, lower_flow, upper_flow = lateral_limits(new_axial, soil)
        axial_strain, lateral_strain, _, _ = strain_increment(
            axial, lateral, new_axial, new_lateral, -math.inf, log_pp, soil
        )
        if slope != elastic_slope:
            axial_strain += lateral_strain * (lower_flow if lateral_strain > 0.0 else upper_flow)
        strain += axial_strain
        axial, lateral = new_axial, new_lateral
    return lateral, strain, axial == target


@kernel
def creep_direction(
    axial: float, lateral: float, confined: bool, soil: SoftSoilCreep
) -> tuple[float, float, float, bool]:
    """How a specimen under constant axial stress moves while it creeps.

    Returns
    -------
    axial_rate, lateral_rate, pace, held
        Strain rates for each unit of creep volume strain rate; and d(eps_v^c)/d(ln t) over mu* once creep is under way:
        1 where stress is constant, less where p_eq falls while the soil creeps. ``held``: the lateral stress is at a
        limit and stays there.
    """
    p, q = (axial + 2.0 * lateral) / 3.0, axial - lateral
    p_eq, dp_eq_dp, dp_eq_dq2, P, _ = equivalent_pressure(p, q * q, soil)
    alpha = 1.0 - q * q * dp_eq_dq2 / P
    if alpha < ALPHA_GUARD:
        alpha = ALPHA_GUARD * ALPHA_GUARD / (2.0 * ALPHA_GUARD - alpha)
    deviator = 3.0 * dp_eq_dq2 / alpha * q
    axial_rate, lateral_rate = (1.0 + 2.0 * deviator) / 3.0, (1.0 - deviator) / 3.0
    if not confined:
        return axial_rate, lateral_rate, 1.0, False
    lower, upper, lower_flow, upper_flow = lateral_limits(axial, soil)
    tolerance = 1.0e-11 * (abs(axial) + abs(lateral))
    if lateral <= lower + tolerance and lateral_rate > 0.0:
        return axial_rate + lower_flow * lateral_rate, 0.0, 1.0, True
    if lateral >= upper - tolerance and lateral_rate < 0.0:
        return axial_rate + upper_flow * lateral_rate, 0.0, 1.0, True
    # The lateral stress changes so that elastic strain cancels lateral creep.
    tangent = elastic_strain(p, soil)[1]
    shear = 0.5 / soil.shear_ratio * tangent
    stress_rate = -3.0 * lateral_rate / (2.0 / 3.0 * tangent + shear)
    log_rate = stress_rate * (2.0 / 3.0 * dp_eq_dp - 2.0 * q * dp_eq_dq2) / p_eq
    resistance = 1.0 - (soil.lambda_star - soil.kappa_star) * log_rate
    pace = 1.0 / resistance if resistance > 0.0 else 1.0
    return axial_rate + stress_rate * (2.0 / 3.0 * tangent - 2.0 * shear) / 3.0, 0.0, pace, False
