"""Surfaces, flow and stiffness of the hardening soil model.

Compression positive, kPa. Principal stresses sorted, s1 the largest; a = c cot(phi); x = (s3 + a)/(p_ref + a). Sources:
Schanz, Vermeer & Bonnier (1999), "The hardening soil model: formulation and verification", in: Beyond 2000 in
computational geotechnics, Balkema, 281-296; PLAXIS, "Material models manual", chapter on the hardening soil model.

::

    E_ur = Eur_ref x^m, nu_ur                             elasticity
    q = s1 - s3,  q_f = 2 sin(phi)/(1 - sin(phi)) (s3 + a),  q_a = q_f/R_f
    gamma = q x^-m (2/(E_i (1 - q/q_a)) - 2/Eur_ref)      shear surface; E_i = 2 E50_ref/(2 - R_f)
    q <= q_f                                              strength of Mohr-Coulomb
    sin(psi_m) = (sin(phi_m) - sin(phi_cs))/(1 - sin(phi_m) sin(phi_cs))   Rowe's dilatancy, at most psi
    p_eq = sqrt(qc^2/alpha^2 + (p + a)^2) - a <= p_p      cap
    qc = s1 + (d - 1) s2 - d s3, d = (3 + sin(phi))/(3 - sin(phi))
    dp_p = H ((p_p + a)/(p_ref + a))^m deps_v             deps_v: plastic volume strain of the cap
    -s3 <= tension                                        tension cut-off

gamma is the plastic shear strain e1 - e2 - e3 of the shear surface. Flow of shear is that of (s1 - s3)/2 - (s1 +
s3)/2 sin(psi_m), of cap and cut-off associated. The hyperbola is solved for q, so that one surface, q <= min(q(gamma),
q_f), holds hardening and strength; at q_f gamma stays that of q_f.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel

__all__ = [
    "LEAST_STIFF",
    "HardeningSoil",
    "cap_pressure",
    "cap_rate",
    "elastic_modulus",
    "hardening_soil_of",
    "largest_shear",
    "mobilised_dilatancy",
    "shear_strain",
]

LEAST_STIFF: Final = 1.0
"""kPa: stiffness at s3 + a below it is that at it."""


class HardeningSoil(NamedTuple):
    """Constants of the kernels; moduli and pressures in kPa."""

    initial: float
    """E_i."""

    unloading: float
    """Eur_ref of the shear surface."""

    elastic: float
    """Modulus of elasticity at p_ref: Eur_ref, or what small strains make of it."""

    power: float
    poisson: float
    attraction: float
    """a."""

    reference: float
    """p_ref + a."""

    strength: float
    """2 sin(phi)/(1 - sin(phi))."""

    sin_phi: float
    sin_cs: float
    sin_psi: float
    least_dilatancy: float
    """Lower limit of sin(psi_m)."""

    failure_ratio: float
    delta: float
    alpha: float
    hardening: float
    """H."""

    tension: float
    stiffening: float
    """Growth of ln E_i and ln E_ur of the shear surface with that of the elastic modulus, at small strains; else 0."""

    scaled: bool
    """Whether derivatives by the elastic modulus are asked for."""


@kernel
def hardening_soil_of(constants: FloatArray) -> HardeningSoil:
    """Constants of the kernels.

    ``constants``: E_i, Eur_ref, m, nu_ur, p_ref, c, sin(phi), cos(phi), sin(psi), R_f, tension cut-off, 1 where plastic
    shear contracts below phi_cs and 0 where it does not, alpha, H. The cut-off is at the tip of the cone at most.
    """
    c = constants
    sine, psi = c[6], c[8]
    a = c[5] * c[7] / sine
    critical = (sine - psi) / (1.0 - sine * psi)
    return HardeningSoil(
        c[0],
        c[1],
        c[1],
        c[2],
        c[3],
        a,
        c[4] + a,
        2.0 * sine / (1.0 - sine),
        sine,
        critical,
        psi,
        -critical * c[11],
        c[9],
        (3.0 + sine) / (3.0 - sine),
        c[12],
        c[13],
        min(c[10], a),
        0.0,
        False,
    )


@kernel
def _stiffness(shifted: float, soil: HardeningSoil) -> float:
    """x^m of s3 + a above 0; quicker than a power of real numbers."""
    return math.exp(soil.power * math.log(shifted / soil.reference))


@kernel
def shear_strain(q: float, least: float, soil: HardeningSoil) -> float:
    """gamma of the shear surface through q at s3 = ``least``; q at most q_f."""
    shifted = least + soil.attraction
    if not (shifted > 0.0 and q > 0.0):
        return 0.0
    rest = 1.0 - q * soil.failure_ratio / (soil.strength * shifted)
    return 2.0 * q / _stiffness(shifted, soil) * (1.0 / (soil.initial * rest) - 1.0 / soil.unloading)


@kernel
def largest_shear(gamma: float, least: float, soil: HardeningSoil) -> tuple[float, float, float]:
    """min(q(gamma), q_f) and its derivatives by s3 and gamma.

    With y = q/q_a, r = E_i/E_ur, h = gamma x^m E_i/(2 q_a), the hyperbola is r y^2 + (1 - r + h) y - h = 0.
    """
    shifted = least + soil.attraction
    if shifted > 0.0:
        stiff = 0.5 * soil.initial * _stiffness(shifted, soil)
        asymptote = soil.strength / soil.failure_ratio
        h, r = gamma * stiff / (asymptote * shifted), soil.initial / soil.unloading
        y, y_h = h / (1.0 - r), 1.0 / (1.0 - r)  # its tangent, for gamma below 0
        if h > 0.0:
            b = 1.0 - r + h
            y = 2.0 * h / (b + math.sqrt(b * b + 4.0 * r * h))
            y_h = (1.0 - y) / (2.0 * r * y + b)
        if y < soil.failure_ratio:
            return asymptote * shifted * y, asymptote * (y - (1.0 - soil.power) * h * y_h), y_h * stiff
    return soil.strength * shifted, soil.strength, 0.0


@kernel
def cap_rate(pressure: float, soil: HardeningSoil) -> float:
    """((p_p + a)/(p_ref + a))^(m - 1) before a step."""
    rate: float = ((pressure + soil.attraction) / soil.reference) ** (soil.power - 1.0)
    return rate


@kernel
def cap_pressure(pressure: float, slow: float, volume: float, soil: HardeningSoil) -> tuple[float, float]:
    """p_p after a plastic volume strain and its derivative by it; exact. ``slow``: :func:`cap_rate` of the old p_p."""
    old = (pressure + soil.attraction) / soil.reference
    rate, rest = soil.hardening / soil.reference, 1.0 - soil.power
    growth, stiff = rate * volume * slow, old * slow
    if rest > 1.0e-9:
        grown = max(1.0 + rest * growth, 1.0e-6)
        growth = math.log1p(max(rest * growth, -0.999999)) / rest
        stiff /= grown
    factor = math.exp(min(growth, 500.0))
    return old * factor * soil.reference - soil.attraction, soil.hardening * stiff * factor


@kernel
def mobilised_dilatancy(high: float, low: float, soil: HardeningSoil) -> tuple[float, float, float]:
    """sin(psi_m) and its derivatives by s1 and s3."""
    total = high + low + 2.0 * soil.attraction
    mobilised = (high - low) / total if total > 0.0 else soil.sin_phi
    if not 0.0 < mobilised < soil.sin_phi:
        mobilised = soil.sin_phi if mobilised > 0.0 else 0.0
        total = math.inf
    rest = 1.0 - mobilised * soil.sin_cs
    sine = (mobilised - soil.sin_cs) / rest
    if sine <= soil.least_dilatancy:
        return soil.least_dilatancy, 0.0, 0.0
    by = (1.0 - soil.sin_cs * soil.sin_cs) / (rest * rest * total)
    return sine, by * (1.0 - mobilised), -by * (1.0 + mobilised)


@kernel
def elastic_modulus(least_old: float, least: float, soil: HardeningSoil) -> tuple[float, float]:
    """Elastic modulus of a step and its derivative by the new s3."""
    shifted = 0.5 * (least_old + least) + soil.attraction
    if shifted <= LEAST_STIFF:
        return soil.elastic * _stiffness(LEAST_STIFF, soil), 0.0
    modulus = soil.elastic * _stiffness(shifted, soil)
    return modulus, 0.5 * soil.power * modulus / shifted
