"""Strength of Mohr-Coulomb, Drucker-Prager and Matsuoka-Nakai without dilatancy; stresses in kPa, compression positive.

With s = sin(phi): N = (1 + s)/(1 - s), a = c cot(phi), K = 9 + 8 tan(phi)^2. In plane strain a perfectly plastic body
fails with no plastic strain out of its plane.
"""

from __future__ import annotations

import math

__all__ = ["davis", "plane_sine", "triaxial_axial"]


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
