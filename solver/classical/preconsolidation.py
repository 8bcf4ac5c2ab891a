"""Preconsolidation stress from the first loading of a compression test."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.classical.compression import first_loading, virgin_line
from geoswarm.solver.classical.errors import NoEvaluationError
from geoswarm.solver.classical.straight import straight_line

__all__ = ["casagrande", "log_log"]

_LEAST = 5
_FINE = 4001


def casagrande(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> float:
    """Preconsolidation stress, kPa, after Casagrande (1936, Proc. 1st ICSMFE, Cambridge, vol. 3, 60-64).

    At the point of largest curvature of e over log10(stress), a cubic spline through the first loading, the bisector of
    the horizontal and the tangent meets the virgin line. Curvature and bisector depend on the scales of the diagram:
    here one void ratio is as long as one decade of stress.

    Parameters
    ----------
    stress, void_ratio
        At the ends of the stages in their order, shape (n,), kPa and 1.

    Raises
    ------
    NoEvaluationError
        There are fewer than five points of first loading, no bend, or the lines do not meet within the test.
    """
    x, e = first_loading(stress, void_ratio)
    if x.size < _LEAST:
        raise NoEvaluationError(f"{x.size} points of first loading; at least {_LEAST} are needed")
    line = virgin_line(stress, void_ratio)
    spline = CubicSpline(x, e, bc_type="natural")
    fine = np.linspace(x[0], x[-1], _FINE)
    first, second = spline(fine, 1), spline(fine, 2)
    bend = -second / (1.0 + first**2) ** 1.5
    at = int(np.argmax(bend))
    if not bend[at] > 0.0 or at in (0, _FINE - 1):
        raise NoEvaluationError("the curve has no bend towards a virgin line")
    slope = math.tan(0.5 * math.atan(float(first[at])))
    if not slope > -line.index:
        raise NoEvaluationError("the tangent at the largest curvature is as steep as the virgin line")
    place, height = float(fine[at]), float(spline(fine[at]))
    return _within((line.start - height + slope * place) / (line.index + slope), x)


def log_log(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> float:
    """Preconsolidation stress, kPa: where two lines meet in ln(1 + e) over log(stress).

    Butterfield (1979, Geotechnique 29, 469-480), Onitsuka, Hong, Hara & Yoshitake (1995, Soils and Foundations 35(4),
    77-83). The points are parted where the two lines through them have the least squares.

    Parameters
    ----------
    stress, void_ratio
        At the ends of the stages in their order, shape (n,), kPa and 1; a void ratio, not a strain.

    Raises
    ------
    NoEvaluationError
        There are fewer than five points of first loading, the second line is not steeper, or they do not meet within
        the test.
    """
    x, e = first_loading(stress, void_ratio)
    if x.size < _LEAST:
        raise NoEvaluationError(f"{x.size} points of first loading; at least {_LEAST} are needed")
    if not (e > -1.0).all():
        raise NoEvaluationError("void ratios must be above -1; strains are not accepted")
    y = np.log1p(e)
    best: tuple[float, float] | None = None
    for split in range(2, x.size - 1):
        slope_before, start_before, left_before = straight_line(x[:split], y[:split])
        slope_after, start_after, left_after = straight_line(x[split:], y[split:])
        if not slope_before > slope_after:
            continue
        squares = left_before + left_after
        meet = (start_after - start_before) / (slope_before - slope_after)
        if best is None or squares < best[0]:
            best = squares, meet
    if best is None:
        raise NoEvaluationError("the curve does not become steeper")
    return _within(best[1], x)


def _within(found: float, x: FloatArray) -> float:
    """Stress, kPa, where its logarithm is within the test."""
    if not x[0] <= found <= x[-1]:
        side = "below" if found < x[0] else "above"
        raise NoEvaluationError(f"the lines meet {side} the test's {10.0 ** x[0]:.4g} to {10.0 ** x[-1]:.4g} kPa")
    return float(10.0**found)
