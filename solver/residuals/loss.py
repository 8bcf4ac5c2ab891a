"""Robust losses: what a reading far from the curve counts.

With z = sqrt(w_h) (y_calc - y_meas) / c and the scale c, a reading counts c^2 rho(z^2) instead of w_h (y_calc -
y_meas)^2, so that small residuals count as they always do:

==========  ==========================================  =========================
kind        rho(s)                                      weight rho'(s)
==========  ==========================================  =========================
``soft_l1``  2 (sqrt(1 + s) - 1)                         1 / sqrt(1 + s)
``huber``   s up to 1, 2 sqrt(s) - 1 beyond             1 up to 1, 1 / sqrt(s)
``cauchy``  ln(1 + s)                                   1 / (1 + s)
==========  ==========================================  =========================

Sources: Huber (1964) for ``huber``; Triggs et al. (2000) for the form, in which SciPy's ``least_squares`` names them.
A search sees t(z) = sign(z) c sqrt(rho(z^2)), whose square is what the reading counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["OUTLYING", "TUNING", "Loss", "LossKind"]

LossKind: TypeAlias = Literal["soft_l1", "huber", "cauchy"]

TUNING: dict[LossKind, float] = {"soft_l1": 1.287, "huber": 1.345, "cauchy": 2.385}
"""Scale over the standard deviation of normal noise, with which an estimate is 95 % as precise as that of least squares
(Holland and Welsch 1977; soft_l1 by the same condition, (E psi')^2 / E psi^2 = 0.95)."""

OUTLYING = 1.0 / 3.0
"""A reading with a smaller weight is shown as an outlier: with the scales above, one 3.4 (soft_l1, cauchy) or 4.0
(huber) standard deviations away."""


@dataclass(frozen=True, slots=True)
class Loss:
    """A loss and its scale c, in the base unit of the series."""

    kind: LossKind
    scale: float

    def rho(self, z: FloatArray) -> FloatArray:
        """rho(z^2) of scaled residuals z."""
        size = np.abs(z)
        if self.kind == "huber":
            return np.where(size <= 1.0, np.minimum(size, 1.0) ** 2, 2.0 * size - 1.0)
        if self.kind == "cauchy":  # ln(1 + z^2), without the overflow of z^2
            return np.where(size < 1e8, np.log1p(np.minimum(size, 1e8) ** 2), 2.0 * np.log(np.maximum(size, 1.0)))
        return np.asarray(2.0 * size * (size / (np.hypot(1.0, size) + 1.0)))

    def weight(self, z: FloatArray) -> FloatArray:
        """rho'(z^2): 1 for small residuals, and less the farther a reading lies off."""
        size = np.abs(z)
        if self.kind == "huber":
            return np.asarray(1.0 / np.maximum(size, 1.0))
        root = 1.0 / np.hypot(1.0, size)
        return np.asarray(root * root if self.kind == "cauchy" else root)

    def slope(self, z: FloatArray) -> FloatArray:
        """Derivative of psi(z) = z rho'(z^2); that of cauchy is negative beyond 1."""
        size = np.abs(z)
        if self.kind == "huber":
            return np.where(size <= 1.0, 1.0, 0.0)
        root = 1.0 / np.hypot(1.0, size)
        if self.kind == "cauchy":
            return np.asarray((2.0 * root * root - 1.0) * root * root)
        return np.asarray(root**3)

    def root(self, z: FloatArray) -> FloatArray:
        """sign(z) sqrt(rho(z^2)): what a search takes for z."""
        return np.asarray(np.sign(z) * np.sqrt(self.rho(z)))

    def root_slope(self, z: FloatArray) -> FloatArray:
        """Derivative of :meth:`root`: z rho'(z^2) / sqrt(rho(z^2)), 1 at 0."""
        size = np.maximum(np.abs(z), 1e-6)
        return np.asarray(size * self.weight(size) / np.sqrt(self.rho(size)))
