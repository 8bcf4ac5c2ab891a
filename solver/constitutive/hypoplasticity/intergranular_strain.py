"""Intergranular strain of Niemunis and Herle along a straight path of strain, and what it makes of the strain rate.

With h the intergranular strain, rho = |h|/R, u = rho^beta_r, n = h/|h| and m = m_R + rho^chi (m_T - m_R)::

    n:d > 0:   h' = (1 - u n n) d,   sigma' = L:(m d + (1 - m_T) rho^chi n (n:d)) - N rho^chi (n:d)
    else:      h' = d,               sigma' = L:(m d + (m_R - m_T) rho^chi n (n:d))

A. Niemunis & I. Herle (1997), Hypoplastic model for cohesionless soils with elastic strain range, Mechanics of
Cohesive-Frictional Materials 2, 279-299, equations for h and for the stiffness M. Nothing of this depends on stress.

Where d keeps its direction, h stays in the plane of the old h and d, and only the way along d has to be integrated: of
the vector z n with z = rho (1 - u)^(-1/beta_r), the part across d stays as it is, and that along d, A, grows by

    dA/d(strain/R) = (1 + z^beta_r)^(1/beta_r)

which follows from the equation for h. As h nears its limit, A grows like exp(strain/R): its area hyperbolic sine q is
what is integrated, smooth and without the small steps that h itself would need. Before that, where n:d < 0, h moves
straight.
"""

from __future__ import annotations

import math
from typing import Final

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.kernels.jit import kernel

__all__ = ["LEAD", "WAY", "along_way", "begin_way", "end_of_way"]

WAY: Final = 9
LEAD: Final = 13
_LARGEST: Final = 690.0
"""Of ln z, half of it at the beginning of a path: beyond, h is at its limit and along the path to rounding."""

_SMALLEST: Final = 1.0e-30


@kernel
def _stretched(rho: float, beta: float) -> float:
    """z = rho (1 - rho^beta)^(-1/beta)."""
    if not rho > 0.0:
        return 0.0
    log_rho = math.log(rho)
    rest = max(-math.expm1(beta * log_rho), 1.0e-30)
    return math.exp(min(log_rho - math.log(rest) / beta, 0.5 * _LARGEST))


@kernel
def begin_way(x: float, y: float, length: float, beta: float, way: FloatArray) -> tuple[float, float]:
    """Prepare a straight path.

    Parameters
    ----------
    x, y
        Old h along the path and across it (at least 0), over R; at most 1 together.
    length, beta
        Strain of the whole path over R, above 0; beta_r.
    way
        (WAY,), filled: x, y, length, fraction up to which n:d < 0, part of z n across, its derivative by the angle of
        the old h, scale of A, and that part over y.

    Returns
    -------
    q, slope
        Where n:d > 0 begins: A = scale sinh(q), and the derivative of q by the angle of the old h.
    """
    size = math.hypot(x, y)
    way[0], way[1], way[2] = x, y, length
    if x < 0.0:
        way[3] = min(1.0, -x / length)
        across = _stretched(y, beta)
        growth = math.exp(math.log1p(across**beta) / beta)
        along, along_slope = 0.0, -growth * y
        way[5] = x * growth * (1.0 + across**beta)
        way[7] = across / y if y > 0.0 else 1.0
    else:
        way[3] = 0.0
        z = _stretched(size, beta)
        ratio = z / size if size > 0.0 else 1.0
        along, across = ratio * x, ratio * y
        along_slope, way[5] = -across, along
        way[7] = ratio
    way[4] = across
    scale = max(1.0, across)
    way[6] = scale
    q = math.asinh(along / scale)
    return q, along_slope / (scale * math.cosh(q))


@kernel
def _place(fraction: float, loading: bool, q: float, slope: float, beta: float, way: FloatArray) -> tuple[float, ...]:
    """rho, cosine and sine of the angle between h and path, u, and the derivatives of both by the old angle."""
    if not loading:
        # Rounding must not carry h past the point where it is across the path, or none.
        x, y = min(way[0] + fraction * way[2], -_SMALLEST), way[1]
        rho = math.hypot(x, y)
        turned = (x * way[0] + y * y) / (rho * rho)
        return rho, x / rho, y / rho, min(rho, 1.0) ** beta, (way[0] * y - x * y) / rho, turned, 0.0, 0.0
    along, across = max(way[6] * math.sinh(q), _SMALLEST), way[4]
    z = math.hypot(along, across)
    power = z**beta
    u = power / (1.0 + power)
    growth = math.exp(math.log1p(power) / beta)
    cosine, sine = along / z, across / z
    along_slope, across_slope = way[6] * math.cosh(q) * slope / z, way[5] / z
    rho = z / growth
    rho_slope = rho / (1.0 + power) * (cosine * along_slope + sine * across_slope)
    turned = cosine * across_slope - sine * along_slope
    return rho, cosine, sine, u, rho_slope, turned, growth, z


@kernel
def along_way(
    fraction: float, loading: bool, q: float, slope: float, constants: FloatArray, way: FloatArray, lead: FloatArray
) -> None:
    """What the intergranular strain makes of the strain rate at a fraction of the path.

    Parameters
    ----------
    fraction, loading
        Of the path; whether n:d > 0.
    q, slope
        As of :func:`begin_way`; without effect unless loading.
    constants
        m_R, m_T, beta_r and chi at places 3 to 6.
    way
        Of :func:`begin_way`; and at place 8 the rho below which d(rho^chi)/d(rho), which has no bound for chi < 1 but
        for its integral, grows no more: some tenth of a substep over R.
    lead
        (LEAD,), filled. With unit vectors a along the path and b across it in the plane of the old h, and the strain
        rate D = |D| a: L acts on |D| (lead[0] a + lead[1] b), N on lead[2] |D|; the derivatives by D of the first are
        lead[7] 1 + a (lead[3] a + lead[4] b) + b (lead[5] a + lead[6] b), of the second lead[8] a + lead[9] b;
        lead[10], lead[11]: derivatives of q and slope by the fraction; lead[12]: error of h over R for one of q.
    """
    m_R, m_T, beta, chi = constants[3], constants[4], constants[5], constants[6]
    limit = _LARGEST - math.log(way[6])
    rho, cosine, sine, u, rho_angle, angle_angle, growth, z = _place(fraction, loading, min(q, limit), slope, beta, way)
    power = math.exp(chi * math.log(rho))
    steep = chi * math.exp((chi - 1.0) * math.log(rho if chi >= 1.0 else min(max(rho, way[8]), 1.0)))
    extra = 1.0 - m_T if loading else m_R - m_T
    m, mu = m_R + power * (m_T - m_R), power * extra
    # By the length of the path so far, times that length.
    gone = fraction * way[2]
    rho_length = gone * cosine * (1.0 - u if loading else 1.0)
    angle_length = -gone * sine / rho
    straight, turned = m + mu * cosine * cosine, mu * cosine * sine
    straight_rho, straight_angle = steep * (m_T - m_R + extra * cosine * cosine), -2.0 * mu * cosine * sine
    turned_rho, turned_angle = steep * extra * cosine * sine, mu * (cosine * cosine - sine * sine)
    lead[0], lead[1] = straight, turned
    lead[3] = straight + straight_rho * rho_length + straight_angle * angle_length
    lead[4] = -turned - straight_rho * rho_angle - straight_angle * angle_angle
    lead[5] = turned + turned_rho * rho_length + turned_angle * angle_length
    lead[6] = straight - turned_rho * rho_angle - turned_angle * angle_angle
    lead[2], lead[8], lead[9], lead[10], lead[11], lead[12] = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if not loading:
        lead[7] = straight - extra * steep / chi * cosine * way[0]
        return
    lead[7] = straight - extra * steep / chi * cosine * way[7] / growth * way[0]
    lead[2] = power * cosine
    lead[8] = lead[2] + steep * cosine * rho_length - power * sine * angle_length
    lead[9] = -steep * cosine * rho_angle + power * sine * angle_angle
    along = way[6] * math.cosh(min(q, limit))
    pace = growth / along
    lead[12] = (1.0 - u + sine) / pace
    if q < limit:
        lead[10] = pace * way[2]
        lead[11] = lead[10] * ((u * cosine * along / z - math.tanh(q)) * slope + u * sine * way[5] / z)


@kernel
def end_of_way(q: float, constants: FloatArray, way: FloatArray) -> tuple[float, float]:
    """New h along and across the path, over R."""
    if way[3] >= 1.0:
        return way[0] + way[2], way[1]
    rho, cosine, sine, _, _, _, _, _ = _place(1.0, True, min(q, _LARGEST - math.log(way[6])), 0.0, constants[5], way)
    rho = min(rho, 1.0)
    return rho * cosine, rho * sine
