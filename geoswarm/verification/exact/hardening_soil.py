"""Hardening soil in closed form, and the stiffness at small strains that Hardin and Drnevich found.

Schanz, Vermeer & Bonnier (1999): a = c cot(phi), x = (s3 + a)/(p_ref + a), E_i = 2 E50_ref/(2 - R_f). Benz (2007):
Gs/G0 = 1/(1 + 0.385 gamma/gamma_07) (Santos & Correia 2001); Masing's loop of that hyperbola.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.integrate import quad

from geoswarm.solver.arrays import FloatArray

__all__ = ["DECAY", "Drained", "HardeningSand", "backbone", "masing_damping"]

DECAY = 0.385


@dataclass(frozen=True, slots=True)
class HardeningSand:
    """Stiffnesses at the reference stress, kPa, Poisson's ratio and the failure ratio."""

    E50: float = 2.5e4
    Eur: float = 8.0e4
    p_ref: float = 100.0
    R_f: float = 0.9
    nu: float = 0.2

    @property
    def initial(self) -> float:
        """E_i at the reference stress, kPa."""
        return 2.0 * self.E50 / (2.0 - self.R_f)


class Drained:
    """The drained triaxial test without a cap, in closed form, over q."""

    def __init__(
        self,
        cell: float,
        *,
        m: float = 0.5,
        c: float = 0.0,
        phi: float = 34.0,
        psi: float = 0.0,
        sand: HardeningSand | None = None,
    ) -> None:
        self.sand = HardeningSand() if sand is None else sand
        sine = math.sin(math.radians(phi))
        self.cell, self.a = cell, c / math.tan(math.radians(phi))
        self.stiff = ((cell + self.a) / (self.sand.p_ref + self.a)) ** m
        self.strength = 2.0 * sine / (1.0 - sine) * (cell + self.a)
        self.psi = math.sin(math.radians(psi))
        self.critical = (sine - self.psi) / (1.0 - sine * self.psi)

    def _left(self, q: FloatArray) -> FloatArray:
        found: FloatArray = 1.0 - np.asarray(q) * self.sand.R_f / self.strength
        return found

    def axial(self, q: FloatArray) -> FloatArray:
        """Of soil that does not dilate: the hyperbola."""
        found: FloatArray = q / (self.stiff * self.sand.initial * self._left(q))
        return found

    def deviator(self, axial: FloatArray) -> FloatArray:
        """The hyperbola over the axial strain."""
        elastic = self.stiff * self.sand.initial * axial
        found: FloatArray = elastic / (1.0 + elastic * self.sand.R_f / self.strength)
        return found

    def sine(self, q: float, *, contracts: bool) -> float:
        """Rowe's sin(psi_m)."""
        mobilised = q / (q + 2.0 * self.cell + 2.0 * self.a)
        sine = (mobilised - self.critical) / (1.0 - mobilised * self.critical)
        return sine if contracts else max(sine, 0.0)

    def dilation(self, q: float, *, contracts: bool) -> float:
        """Plastic volume strain, by quadrature of sin(psi_m) d gamma."""

        def rate(q: float) -> float:
            left = 1.0 - q * self.sand.R_f / self.strength
            plastic = 2.0 / (self.sand.initial * left**2) - 2.0 / self.sand.Eur
            return float(-self.sine(q, contracts=contracts) * plastic / self.stiff)

        neutral = 2.0 * (self.cell + self.a) * self.critical / (1.0 - self.critical)
        parts = [0.0, min(neutral, q), q]
        return math.fsum(float(quad(rate, *part, epsabs=1.0e-14)[0]) for part in pairwise(parts))


def backbone(gamma: FloatArray | float, G0: float, threshold: float) -> FloatArray:
    """Shear stress of first loading, kPa, over 3/2 eps_q; ``threshold`` is gamma_07."""
    return np.asarray(G0 * gamma / (1.0 + DECAY * np.asarray(gamma) / threshold))


def masing_damping(gamma: FloatArray | float, threshold: float) -> FloatArray:
    """Damping ratio of a loop of this amplitude, Masing's doubled hyperbola integrated."""
    x = DECAY * np.asarray(gamma) / threshold
    return np.asarray(4.0 / math.pi * (1.0 + 1.0 / x) * (1.0 - np.log1p(x) / x) - 2.0 / math.pi)
