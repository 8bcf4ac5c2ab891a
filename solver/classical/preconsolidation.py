"""Preconsolidation stress from the first loading of a compression test."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.classical.compression import VirginLine, first_loading, virgin_line
from geoswarm.solver.classical.curves import NoEvaluationError, straight_line

__all__ = ["Casagrande", "LogLog", "casagrande", "casagrande_construction", "log_log", "log_log_lines"]

_LEAST = 5
_FINE = 4001


@dataclass(frozen=True, slots=True)
class Casagrande:
    """Casagrande's construction over log10(stress/kPa).

    Parameters
    ----------
    stress
        Preconsolidation stress, kPa.
    place, void_ratio
        Where the curvature is largest: log10 of the stress, and the void ratio there.
    tangent, bisector
        Slopes of the lines through that point, void ratio over a decade, negative.
    line
        The virgin line.
    """

    stress: float
    place: float
    void_ratio: float
    tangent: float
    bisector: float
    line: VirginLine


@dataclass(frozen=True, slots=True)
class LogLog:
    """Preconsolidation stress, kPa, and the two lines: slope and value at 1 kPa of ln(1 + e) over log10(stress/kPa)."""

    stress: float
    before: tuple[float, float]
    after: tuple[float, float]


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
    return casagrande_construction(stress, void_ratio).stress


def casagrande_construction(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> Casagrande:
    """The construction behind :func:`casagrande`; parameters and errors are the same."""
    from scipy.interpolate import CubicSpline  # takes most of a second to import

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
    found = _within((line.start - height + slope * place) / (line.index + slope), x)
    return Casagrande(found, place, height, float(first[at]), slope, line)


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
    return log_log_lines(stress, void_ratio).stress


def log_log_lines(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> LogLog:
    """The lines behind :func:`log_log`; parameters and errors are the same."""
    x, e = first_loading(stress, void_ratio)
    if x.size < _LEAST:
        raise NoEvaluationError(f"{x.size} points of first loading; at least {_LEAST} are needed")
    if not (e > -1.0).all():
        raise NoEvaluationError("void ratios must be above -1; strains are not accepted")
    y = np.log1p(e)
    best: tuple[float, float, tuple[float, float], tuple[float, float]] | None = None
    for split in range(2, x.size - 1):
        slope_before, start_before, left_before = straight_line(x[:split], y[:split])
        slope_after, start_after, left_after = straight_line(x[split:], y[split:])
        if not slope_before > slope_after:
            continue
        squares = left_before + left_after
        meet = (start_after - start_before) / (slope_before - slope_after)
        if best is None or squares < best[0]:
            best = squares, meet, (slope_before, start_before), (slope_after, start_after)
    if best is None:
        raise NoEvaluationError("the curve does not become steeper")
    return LogLog(_within(best[1], x), best[2], best[3])


def _within(found: float, x: FloatArray) -> float:
    """Stress, kPa, where its logarithm is within the test."""
    if not x[0] <= found <= x[-1]:
        side = "below" if found < x[0] else "above"
        raise NoEvaluationError(f"the lines meet {side} the test's {10.0 ** x[0]:.4g} to {10.0 ** x[-1]:.4g} kPa")
    return float(10.0**found)
