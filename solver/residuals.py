"""Residuals: calculated less measured values, or distances of the readings from the calculated curve.

A peak that the model reaches at another x is missed twice by differences of y: once where it was measured, once where
it was calculated, and a shift by more than its width changes neither. The distance from the curve falls with the shift.

With x and y in parts of their ranges, the distance of a reading is that from the nearest point of the calculated curve
(orthogonal distance regression: Boggs and Rogers 1990), times the range of y, with the sign of y_calc - y_meas: the
difference of y where the curve is level, and less where it is steep. Between the readings the curve is straight, and it
ends with them.

Robust losses give what a reading far from the curve counts.

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

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["CurveScale", "Distance", "Loss", "LossKind", "OUTLYING", "TUNING", "residuals_of"]

Distance: TypeAlias = Literal["vertical", "orthogonal"]


@dataclass(frozen=True, slots=True)
class CurveScale:
    """Ranges of x and y, base units, above 0: what counts as the same distance along both axes."""

    x: float
    y: float


def residuals_of(x: FloatArray, y: FloatArray, calculated: FloatArray, along: CurveScale | None) -> FloatArray:
    """Return the residuals of readings, shape (..., m), in the unit of y.

    Parameters
    ----------
    x, y
        Readings, shape (m,).
    calculated
        Values at their x, shape (..., m).
    along
        Ranges for distances from the curve; None for differences of y.
    """
    if along is None:
        return calculated - y
    order = np.argsort(x, kind="stable")
    across = x[order] / along.x
    curve, measured = calculated[..., order] / along.y, y[order] / along.y
    with np.errstate(over="ignore", invalid="ignore"):
        vertical = curve - measured
        nearest = vertical * vertical
        for side in (1, -1):
            _approach(nearest, across, measured, curve, side)
    found = np.empty(calculated.shape)
    found[..., order] = np.copysign(np.sqrt(nearest), vertical) * along.y
    return found


def _approach(nearest: FloatArray, x: FloatArray, y: FloatArray, curve: FloatArray, side: int) -> None:
    """Lower the squared distances (..., m) to those from the curve on one side of each reading, segment by segment.

    A segment that begins farther away by x alone than the nearest point so far cannot be nearer, nor can those behind.
    """
    places: IntArray = np.arange(x.size)
    begin = places
    while True:
        end = begin + side
        inside = (end >= 0) & (end < x.size)
        gap = x[begin] - x[places]
        near = (gap * gap < nearest[..., places]).reshape(-1, places.size).any(axis=0)
        kept = inside & near
        if not kept.any():
            return
        places, begin, end, gap = places[kept], begin[kept], end[kept], gap[kept]
        run, rise = x[end] - x[begin], curve[..., end] - curve[..., begin]
        height = curve[..., begin] - y[places]
        length = run * run + rise * rise
        share = np.clip(-(gap * run + height * rise) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
        width, height = gap + share * run, height + share * rise
        nearest[..., places] = np.fmin(nearest[..., places], width * width + height * height)
        begin = end


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
