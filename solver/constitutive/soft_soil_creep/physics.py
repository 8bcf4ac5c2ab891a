"""Soft soil creep: parameters and the scalar physics that every update of the model shares.

Compression positive; kPa, day. Notation: p mean stress, s deviator, q = sqrt(3/2 s:s), a = c cot(phi) attraction,
beta = (lambda* - kappa*)/mu*. Sources: Vermeer & Neher (1999); Stolle, Vermeer & Bonnier (1999); Brinkgreve (1994).

Two formulations differ in the pressure x that enters stiffness and equivalent pressure, with P = p + a in both:

- *translated* (default): x = p + a;
- *untranslated*: x = p.

::

    p_eq = x + q^2 / (M^2 P)                         equivalent pressure (an ellipse through the attraction)
    d eps_v^e = kappa* dx / x                        elastic volume change, G/K constant
    d eps_v^c / dt = (mu*/tau) (p_eq/p_p)^beta       creep volume change
    p_p = p_p0 exp(eps_v^c / (lambda* - kappa*))     preconsolidation pressure
    d eps^c = d eps_v^c / alpha * d p_eq/d sigma     flow, alpha = d p_eq/d p = 1 - q^2/(M P)^2

In one time step the creep volume change is ``mu* ln(1 + (dt/tau) (p_eq/p_p)^beta)`` with p_eq at the end and p_p at the
beginning of the step: exact where stress is constant, unconditionally stable otherwise.

Without creep (mu* = 0, the soft soil model) it is the limit of that, ``(lambda* - kappa*) ln(p_eq/p_p)`` where p_eq is
above p_p and 0 elsewhere: p_p is never below p_eq, which is a yield surface with hardening.

Two guards keep the equations defined. ``x`` in stiffness and equivalent pressure is never below ``pressure_floor``
(translated 0.001 kPa, untranslated 1 kPa); elastic strain continues linearly below it. ``alpha`` in the denominator of
the flow rule is replaced below g = :data:`ALPHA_GUARD` by the smooth, always positive ``g^2/(2 g - alpha)``: deviatoric
flow is defined where q reaches M P, and volume change stays exact. The Mohr-Coulomb limit keeps most soils away from
there.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, TypeAlias

from geoswarm.solver.constitutive.cam_clay import log_ratio
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.kernels.jit import kernel, kernel_in_place

__all__ = [
    "ALPHA_GUARD",
    "Formulation",
    "SoftSoilCreep",
    "creep_increment",
    "elastic_strain",
    "equivalent_pressure",
    "friction_constant",
    "secant_compliance",
    "soft_soil",
    "soft_soil_creep",
]

Formulation: TypeAlias = Literal["translated", "untranslated"]

ALPHA_GUARD = 0.05
"""Value of alpha below which the flow rule uses the guarded alpha."""


class SoftSoilCreep(NamedTuple):
    """Constants of one soil as the kernels use them; made by :func:`soft_soil_creep`. Angles as sine and cosine."""

    lambda_star: float
    kappa_star: float
    mu_star: float  # 0: no creep
    M: float
    K0nc: float
    nu_ur: float
    shear_ratio: float  # G/K
    cohesion: float  # kPa
    sin_phi: float
    cos_phi: float
    sin_psi: float
    shift: float  # kPa, x = p + shift
    extra: float  # kPa, P = x + extra
    pressure_floor: float  # kPa
    tension: float  # kPa, largest admissible tension (inf: no cut-off)
    tau: float  # day

    @property
    def attraction(self) -> float:
        """c cot(phi), kPa."""
        return self.shift + self.extra


def friction_constant(K0nc: float, nu_ur: float, stiffness_ratio: float) -> float:
    """Slope M of the ellipse's top that gives K0nc in steady one-dimensional compression.

    Parameters
    ----------
    K0nc, nu_ur
        Normally consolidated stress ratio and Poisson's ratio.
    stiffness_ratio
        lambda*/kappa*, more than 1.

    Raises
    ------
    InfeasibleError
        No M gives this K0nc (the elastic ratio nu_ur/(1 - nu_ur) is already higher, or nearly so).

    Notes
    -----
    Brinkgreve (1994); PLAXIS Material Models Manual, soft soil model.
    """
    lateral, mean = 1.0 - K0nc, 1.0 + 2.0 * K0nc
    numerator = lateral * (1.0 - 2.0 * nu_ur) * (stiffness_ratio - 1.0)
    denominator = mean * (1.0 - 2.0 * nu_ur) * stiffness_ratio - lateral * (1.0 + nu_ur)
    if not denominator > 0.0:
        raise InfeasibleError(
            f"K0nc = {K0nc:g} with nu_ur = {nu_ur:g} and lambda_star/kappa_star = {stiffness_ratio:g} gives no M; "
            "a higher K0nc, a lower nu_ur, a larger lambda_star/kappa_star, or M itself would be accepted"
        )
    return 3.0 * math.sqrt((lateral / mean) ** 2 + numerator / denominator)


def soft_soil_creep(
    lambda_star: float,
    kappa_star: float,
    mu_star: float,
    c: float,
    phi: float,
    psi: float = 0.0,
    nu_ur: float = 0.15,
    K0nc: float | None = None,
    M: float | None = None,
    *,
    formulation: Formulation = "translated",
    tension_cutoff: float | None = 0.0,
    tau: float = 1.0,
) -> SoftSoilCreep:
    """Constants of a soft soil from its usual parameters.

    Parameters
    ----------
    lambda_star, kappa_star, mu_star
        Modified compression, swelling and creep index; lambda_star > kappa_star > 0, mu_star > 0.
    c, phi, psi
        Cohesion, kPa, at least 0; friction angle, degree, between 0 and 90; dilatancy angle, degree, from 0 to phi.
    nu_ur
        Poisson's ratio for unloading and reloading, from 0 to below 0.5.
    K0nc, M
        At most one of them. Without either, K0nc = 1 - sin(phi); M then follows from :func:`friction_constant`.
        With M given, K0nc = 1 - sin(phi) serves for initial stresses only.
    formulation
        "translated" or "untranslated", see the module.
    tension_cutoff
        Largest admissible tension, kPa, at least 0; None for no cut-off (the Mohr-Coulomb apex remains).
    tau
        Reference time of creep, day.

    Raises
    ------
    InfeasibleError
        A parameter is outside its range; the message names it, its value and what is accepted.
    """
    message = _inadmissible(lambda_star, kappa_star, mu_star, c, phi, psi, nu_ur, K0nc, M, tension_cutoff, tau)
    if message is not None:
        raise InfeasibleError(message)
    sine, cosine = math.sin(math.radians(phi)), math.cos(math.radians(phi))
    attraction = c * cosine / sine
    ratio = 1.0 - sine if K0nc is None else K0nc
    if M is None:
        M = friction_constant(ratio, nu_ur, lambda_star / kappa_star)
    translated = formulation == "translated"
    return SoftSoilCreep(
        lambda_star,
        kappa_star,
        mu_star,
        M,
        ratio,
        nu_ur,
        1.5 * (1.0 - 2.0 * nu_ur) / (1.0 + nu_ur),
        float(c),
        sine,
        cosine,
        math.sin(math.radians(psi)),
        attraction if translated else 0.0,
        0.0 if translated else attraction,
        1.0e-3 if translated else 1.0,
        math.inf if tension_cutoff is None else float(tension_cutoff),
        tau,
    )


def soft_soil(
    lambda_star: float,
    kappa_star: float,
    c: float,
    phi: float,
    psi: float = 0.0,
    nu_ur: float = 0.15,
    K0nc: float | None = None,
    M: float | None = None,
    *,
    formulation: Formulation = "translated",
    tension_cutoff: float | None = 0.0,
) -> SoftSoilCreep:
    """Constants of a soft soil without creep; arguments and errors as of :func:`soft_soil_creep`."""
    creeping = soft_soil_creep(
        lambda_star,
        kappa_star,
        1.0,
        c,
        phi,
        psi,
        nu_ur,
        K0nc,
        M,
        formulation=formulation,
        tension_cutoff=tension_cutoff,
    )
    return creeping._replace(mu_star=0.0)


def _inadmissible(
    lambda_star: float,
    kappa_star: float,
    mu_star: float,
    c: float,
    phi: float,
    psi: float,
    nu_ur: float,
    K0nc: float | None,
    M: float | None,
    tension_cutoff: float | None,
    tau: float,
) -> str | None:
    """First parameter outside its range, in words; written so that NaN is refused too."""
    if not 0.0 < kappa_star < math.inf:
        return f"kappa_star must be above 0, got {kappa_star:g}"
    if not kappa_star < lambda_star < math.inf:
        return f"lambda_star must be above kappa_star = {kappa_star:g}, got {lambda_star:g}"
    if not 0.0 < mu_star < math.inf:
        return f"mu_star must be above 0, got {mu_star:g}"
    if not 0.0 <= c < math.inf:
        return f"c must be at least 0, got {c:g} kPa"
    if phi == 0.0:
        return "phi must be above 0 and below 90 degree, got 0 degree: soft soil needs friction"
    if not 0.0 < phi < 90.0:
        return f"phi must be above 0 and below 90 degree, got {phi:g} degree"
    if not 0.0 <= psi <= phi:
        return f"psi must be from 0 to phi = {phi:g} degree, got {psi:g} degree"
    if not 0.0 <= nu_ur < 0.5:
        return f"nu_ur must be from 0 to below 0.5, got {nu_ur:g}"
    if K0nc is not None and M is not None:
        return f"K0nc = {K0nc:g} and M = {M:g} are both given; give only one, the other follows from it"
    if K0nc is not None and not 0.0 < K0nc < 1.0:
        return f"K0nc must be above 0 and below 1, got {K0nc:g}"
    if M is not None and not 0.0 < M < math.inf:
        return f"M must be above 0, got {M:g}"
    if tension_cutoff is not None and not tension_cutoff >= 0.0:
        return f"tension_cutoff must be at least 0, got {tension_cutoff:g} kPa"
    if not 0.0 < tau < math.inf:
        return f"tau must be above 0, got {tau:g} day"
    return None


@kernel
def equivalent_pressure(p: float, q2: float, soil: SoftSoilCreep) -> tuple[float, float, float, float, float]:
    """Equivalent pressure of a stress with mean p and squared deviatoric stress q2.

    Returns
    -------
    p_eq, d p_eq/d p, d p_eq/d q2, P, d P/d p
        P is p + a (floored); its derivative is 1 above the floor and 0 below.
    """
    x = p + soil.shift
    slope = 1.0
    if x < soil.pressure_floor:
        x = soil.pressure_floor
        slope = 0.0
    P = x + soil.extra
    width = 1.0 / (soil.M * soil.M * P)
    return x + q2 * width, (1.0 - q2 * width / P) * slope, width, P, slope


@kernel
def elastic_strain(p: float, soil: SoftSoilCreep) -> tuple[float, float]:
    """Elastic volume strain kappa* ln(x), linear below the pressure floor, and its derivative 1/K by p."""
    x = p + soil.shift
    floor = soil.pressure_floor
    if x >= floor:
        return soil.kappa_star * math.log(x), soil.kappa_star / x
    return soil.kappa_star * (math.log(floor) + x / floor - 1.0), soil.kappa_star / floor


@kernel
def secant_compliance(p_old: float, p: float, soil: SoftSoilCreep) -> tuple[float, float, float]:
    """Exact elastic volume change between two mean stresses.

    Returns
    -------
    strain, compliance, derivative
        Elastic volume strain from p_old to p; strain/(p - p_old), the inverse secant bulk modulus; its derivative by p.
    """
    floor = soil.pressure_floor
    x_old, x = p_old + soil.shift, p + soil.shift
    if x_old >= floor and x >= floor:
        scale = soil.kappa_star / x_old
        ratio, slope = log_ratio((x - x_old) / x_old)
        return scale * ratio * (x - x_old), scale * ratio, scale * slope / x_old
    old = elastic_strain(p_old, soil)[0]
    new, tangent = elastic_strain(p, soil)
    if abs(p - p_old) < 1.0e-6 * floor:
        return tangent * (p - p_old), tangent, 0.0
    compliance = (new - old) / (p - p_old)
    return new - old, compliance, (tangent - compliance) / (p - p_old)


@kernel_in_place
def creep_increment(
    p: float, q2: float, log_time: float, log_pp: float, soil: SoftSoilCreep
) -> tuple[float, float, float, float, float, float]:
    """Creep of one time step at end-of-step stress.

    Parameters
    ----------
    p, q2
        Mean stress and squared deviatoric stress at the end of the step.
    log_time
        ln(dt/tau); -inf for an instantaneous step.
    log_pp
        ln p_p at the beginning of the step.

    Returns
    -------
    volume, d volume/d p, d volume/d q2, factor, d factor/d p, d factor/d q2
        Creep volume strain, and the factor g of the deviatoric creep strain g s.
    """
    p_eq, dp_eq_dp, dp_eq_dq2, P, slope = equivalent_pressure(p, q2, soil)
    strength = soil.lambda_star - soil.kappa_star
    z = log_time + strength / soil.mu_star * (math.log(p_eq) - log_pp)
    if soil.mu_star == 0.0:
        volume, weight = strength * (math.log(p_eq) - log_pp), 1.0
        if not volume > 0.0:
            volume, weight = 0.0, 0.0
    elif z > 0.0:
        tail = math.exp(-z)
        volume = soil.mu_star * (z + math.log1p(tail))
        weight = 1.0 / (1.0 + tail)
    else:
        tail = math.exp(z)
        volume = soil.mu_star * math.log1p(tail)
        weight = tail / (1.0 + tail)
    rate = strength * weight / p_eq
    volume_p, volume_q2 = rate * dp_eq_dp, rate * dp_eq_dq2
    alpha = 1.0 - q2 * dp_eq_dq2 / P
    guarded, bend = alpha, 1.0
    if alpha < ALPHA_GUARD:
        reach = 2.0 * ALPHA_GUARD - alpha
        guarded = ALPHA_GUARD * ALPHA_GUARD / reach
        bend = guarded / reach
    flow = 3.0 * dp_eq_dq2 / guarded
    alpha_p = 2.0 * q2 * dp_eq_dq2 / (P * P) * slope
    alpha_q2 = -dp_eq_dq2 / P
    factor = volume * flow
    factor_p = volume_p * flow - factor * (slope / P + bend * alpha_p / guarded)
    factor_q2 = volume_q2 * flow - factor * bend * alpha_q2 / guarded
    return volume, volume_p, volume_q2, factor, factor_p, factor_q2
