"""Limits in closed form: void ratios and stress ratios of hypoplasticity, strength of perfectly plastic laws."""

from __future__ import annotations

import math

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["DORTMUND", "HOCHSTETTEN", "TOYOURA", "bauer", "critical_slope", "davis", "plane_sine", "triaxial_axial"]

TOYOURA = {
    **{"phi_c": 30.0, "h_s": 2.6e6, "n": 0.27, "e_d0": 0.61, "e_c0": 0.98, "e_i0": 1.10, "alpha": 0.18, "beta": 1.1},
    "e0": 0.75,
}
"""Herle & Gudehus (1999), Determination of parameters of a hypoplastic constitutive model from properties of grain
assemblies, Mechanics of Cohesive-Frictional Materials 4, 461-486."""
HOCHSTETTEN = {
    **{"phi_c": 33.0, "h_s": 1.0e6, "n": 0.25, "e_d0": 0.55, "e_c0": 0.95, "e_i0": 1.05, "alpha": 0.25, "beta": 1.5},
    **{"m_R": 5.0, "m_T": 2.0, "R": 1.0e-4, "beta_r": 0.5, "chi": 6.0, "e0": 0.70},
}
"""Herle & Gudehus (1999) and Niemunis & Herle (1997)."""
DORTMUND = {"phi_c": 27.9, "lambda_star": 0.057, "kappa_star": 0.008, "N": 0.749, "nu": 0.38}
"""Masin (2013), Clay hypoplasticity with explicitly defined asymptotic states, Acta Geotechnica 8, 481-496."""


def bauer(e0: float, p: FloatArray | float, h_s: float, n: float) -> FloatArray:
    """Bauer (1996): a limiting void ratio at mean stresses p, kPa, e0 being that at zero stress."""
    return np.asarray(e0 * np.exp(-((3.0 * np.asarray(p) / h_s) ** n)))


def critical_slope(phi: float, way: float = 1.0) -> float:
    """q/p at failure of a friction angle, degree, in triaxial compression (``way`` 1) or extension (-1)."""
    sine = math.sin(math.radians(phi))
    return 6.0 * sine / (3.0 - way * sine)


def triaxial_axial(phi: float, c: float, cell: float, way: float) -> float:
    """Axial stress at failure in compression (``way`` 1) and extension (-1); Mohr-Coulomb and Matsuoka-Nakai."""
    sine = math.sin(math.radians(phi))
    N, a = (1.0 + sine) / (1.0 - sine), c / math.tan(math.radians(phi))
    return float((cell + a) * N**way - a)


def plane_sine(law: str, phi: float) -> float:
    """Sine of the friction angle in plane strain without dilatancy.

    Matsuoka-Nakai: the intermediate stress is the mean of the others, which makes sin^2 = 1 - 6/(K - 3).
    """
    if law == "matsuoka_nakai":
        return math.sqrt(1.0 - 6.0 / (6.0 + 8.0 * math.tan(math.radians(phi)) ** 2))
    return math.sin(math.radians(phi))


def davis(phi: float, psi: float) -> float:
    """Shear over normal stress on a plane that does not stretch at failure (Davis 1968), without cohesion."""
    sine, flow = math.sin(math.radians(phi)), math.sin(math.radians(psi))
    return sine * math.cos(math.radians(psi)) / (1.0 - sine * flow)
