"""Modified Cam clay: Roscoe & Burland (1968); Wood (1990), chapter 5. eta = q/p, Lambda = 1 - kappa/lambda."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq

from geoswarm.solver.arrays import FloatArray

__all__ = ["CamClay"]


@dataclass(frozen=True, slots=True)
class CamClay:
    """A clay by its constants: exactly one of ``nu`` and ``G``."""

    M: float
    lambda_: float
    kappa: float
    e0: float
    nu: float | None = None
    G: float | None = None

    @property
    def plastic(self) -> float:
        """Lambda."""
        return 1.0 - self.kappa / self.lambda_

    def undrained_p(self, eta: FloatArray, p0: float, OCR: float) -> FloatArray:
        """Mean stress over eta beyond yield, of undrained shearing from an isotropic stress p0 with p_c = OCR p0.

        p ((M^2 + eta^2)/M^2)^Lambda stays what it is, whatever elasticity is; before yield p is p0.
        """
        at_yield = self.M * math.sqrt(OCR - 1.0)
        found: FloatArray = p0 * ((self.M**2 + at_yield**2) / (self.M**2 + np.asarray(eta) ** 2)) ** self.plastic
        return found

    def drained_strains(self, p: float, p0: float, past: float) -> tuple[float, float]:
        """Volume and axial strain of drained compression from p0 at the mean stress p: quadrature of the rates."""
        v0, M = 1.0 + self.e0, self.M

        def pressures(p: float) -> tuple[float, float]:
            eta = 3.0 * (p - p0) / p
            return eta, p * (1.0 + (eta / M) ** 2)

        def specific(p: float) -> float:
            plastic = (self.lambda_ - self.kappa) * math.log(max(pressures(p)[1], past) / past)
            return v0 - self.kappa * math.log(p / p0) - plastic

        def elastic_rate(p: float) -> float:
            if self.G is not None:
                return 1.0 / self.G
            assert self.nu is not None
            return 1.0 / (1.5 * (1.0 - 2.0 * self.nu) / (1.0 + self.nu) * specific(p) * p / self.kappa)

        def plastic_rate(p: float) -> float:
            eta, now = pressures(p)
            growth = (1.0 + (eta / M) ** 2 + 2.0 * eta / M**2 * (3.0 - eta)) / now
            return (self.lambda_ - self.kappa) / specific(p) * growth * 2.0 * eta / (M**2 - eta**2)

        first = brentq(lambda x: pressures(x)[1] - past, p0, 3.0 * p0 / (3.0 - M)) if past > p0 else p0
        shear = float(quad(elastic_rate, p0, p, epsabs=1e-13)[0])
        shear += float(quad(plastic_rate, first, p, epsabs=1e-13)[0]) if p > first else 0.0
        change = math.log(v0 / specific(p))
        return change, shear + change / 3.0

    def eta_at_rest(self) -> float:
        """eta of steady one-dimensional compression: shear strain is 2/3 of volume strain, elastic and plastic."""
        assert self.nu is not None
        elastic = 1.5 * (1.0 - 2.0 * self.nu) / (1.0 + self.nu)

        def not_confined(eta: float) -> float:
            plastic = 2.0 * eta / (self.M**2 - eta**2) * self.plastic
            return plastic + eta * self.kappa / self.lambda_ / (3.0 * elastic) - 2.0 / 3.0

        return float(brentq(not_confined, 0.01, self.M - 0.01))
