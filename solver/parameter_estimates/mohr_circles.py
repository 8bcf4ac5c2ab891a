"""Cohesion and friction angle from Mohr circles at failure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geoswarm.solver.parameter_estimates.values import NoEvaluationError

__all__ = ["FailureLine", "mohr_circles"]

_ALIKE = 0.02
"""Least range of the centres, over their mean, needed for a slope."""


@dataclass(frozen=True, slots=True)
class FailureLine:
    """Cohesion, kPa, friction angle, degree, and the root mean square of the gaps between circles and line, kPa."""

    cohesion: float
    friction_angle: float
    gap: float
    through_origin: bool
    """Whether the line was laid through the origin."""


def mohr_circles(largest: npt.ArrayLike, smallest: npt.ArrayLike) -> FailureLine:
    """Lay the line ``tau = c + sigma tan(phi)`` along Mohr circles at failure.

    With the centre s = (sigma_1 + sigma_3)/2 and the radius t = (sigma_1 - sigma_3)/2, the distance between circle and
    line is ``c cos(phi) + s sin(phi) - t``: least squares of the distances are a linear regression of t on s, the K_f
    line ``t = a + s tan(alpha)`` with ``sin(phi) = tan(alpha)``, ``c = a / cos(phi)`` (Lambe & Whitman 1969, Soil
    Mechanics, chapter 11). Where c would be negative, or there is one circle, the line goes through the origin:
    ``sin(phi) = sum(s t)/sum(s^2)``.

    Parameters
    ----------
    largest, smallest
        Principal stresses at failure sigma_1 and sigma_3, kPa, compression positive, shape (n,).

    Raises
    ------
    NoEvaluationError
        There is no such line.

    Examples
    --------
    >>> found = mohr_circles([300.0, 600.0], [100.0, 200.0])
    >>> round(found.friction_angle, 9), round(abs(found.cohesion), 9)
    (30.0, 0.0)
    """
    first, third = np.atleast_1d(np.asarray(largest, float)), np.atleast_1d(np.asarray(smallest, float))
    if first.shape != third.shape or first.ndim != 1 or first.size == 0:
        raise NoEvaluationError("as many largest as smallest principal stresses, at least one, are needed")
    if not (np.isfinite(first).all() and np.isfinite(third).all() and (first > third).all()):
        raise NoEvaluationError("the largest principal stress must be above the smallest one in each circle")
    s, t = 0.5 * (first + third), 0.5 * (first - third)
    if (s <= 0.0).any():
        raise NoEvaluationError(f"the centre of a circle is at {float(s.min()):g} kPa; above 0 is needed")
    alike = float(np.ptp(s)) < _ALIKE * float(s.mean())
    slope, start = math.nan, -1.0
    if not alike:
        ds = s - s.mean()
        slope = float(ds @ t / (ds @ ds))
        start = float(t.mean() - slope * s.mean())
    through_origin = not start > 0.0
    if through_origin:
        slope, start = float(s @ t / (s @ s)), 0.0
    if not 0.0 <= slope < 1.0:
        raise NoEvaluationError(
            f"the radii change by {slope:.3g} of the change of the centres; 0 to below 1 (the sine of a friction "
            "angle) is needed"
        )
    gap = math.sqrt(float(np.mean((start + slope * s - t) ** 2)))
    return FailureLine(start / math.sqrt(1.0 - slope * slope), math.degrees(math.asin(slope)), gap, through_origin)
