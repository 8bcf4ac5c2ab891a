"""Residuals: calculated less measured values, or distances of the readings from the calculated curve.

A peak that the model reaches at another x is missed twice by differences of y: once where it was measured, once where
it was calculated, and a shift by more than its width changes neither. The distance from the curve falls with the shift.

With x and y in parts of their ranges, the distance of a reading is that from the nearest point of the calculated curve
(orthogonal distance regression: Boggs and Rogers 1990), times the range of y, with the sign of y_calc - y_meas: the
difference of y where the curve is level, and less where it is steep. Between the readings the curve is straight, and it
ends with them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray

__all__ = ["CurveScale", "Distance", "residuals_of"]

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
