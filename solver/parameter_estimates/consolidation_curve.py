"""Coefficient of consolidation and of secondary compression from the readings of one stage.

Terzaghi's theory: ``U = 1 - sum 2/M^2 exp(-M^2 T)``, ``M = pi (2 m + 1)/2``, ``T = c_v t/h^2``; h is the drainage path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.parameter_estimates.values import NoEvaluationError, straight_line

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

__all__ = ["Consolidation", "log_time", "root_time"]

T_90, T_50 = 0.848, 0.197
"""Time factors of 90 % and 50 % (Taylor 1948; to three digits, as everywhere)."""
_FACTOR = math.sqrt(T_90) / (0.9 * math.sqrt(0.25 * math.pi))
"""Abscissa of the curve at 90 % over that of its first straight part, 1.155; Taylor rounds it to 1.15."""
_STRAIGHT = 0.55
"""Degree of consolidation up to which U is straight over the root of time."""
_FINAL, _FINAL_READINGS = 0.5, 2
"""Decades of time before the last reading that are taken for secondary compression, and readings at least."""
_FLAT = 0.5
"""Largest share of the steepest slope that the final one may have: else primary consolidation is not over."""
_LEAST = 8
_ROUNDS = 50
_FINE = 2001


@dataclass(frozen=True, slots=True)
class Consolidation:
    """Results of one stage.

    Parameters
    ----------
    c_v
        Coefficient of consolidation, m^2/day.
    time
        t_90 by the root of time, t_50 by its logarithm, day.
    start, end
        Readings at the beginning and the end of primary consolidation, in the unit of the readings.
    secondary
        Increase of the reading in a decade of time at the end; None by the root of time.
    lines
        The two lines of the construction: slope and reading at x = 0. By the root of time x is that root, in root of
        days: the first part, and the one with abscissas 1.155 times as large. By the logarithm x is log10(time/day):
        the steepest tangent, and the line through the end.
    """

    c_v: float
    time: float
    start: float
    end: float
    secondary: float | None
    lines: tuple[tuple[float, float], tuple[float, float]]


def root_time(time: npt.ArrayLike, reading: npt.ArrayLike, path: float) -> Consolidation:
    """Evaluate over the root of time (Taylor 1942, Research on Consolidation of Clays, MIT Serial 82).

    The line through the first part, up to 55 % of consolidation, is drawn again with abscissas 1.155 times as large; it
    meets the curve at 90 %. ``c_v = 0.848 path^2/t_90``.

    Parameters
    ----------
    time, reading
        Time since the load, day, at least 0, increasing, and settlement, positive downwards, any unit, shape (n,).
    path
        Drainage path, m: half the height of a specimen that drains to both sides.

    Raises
    ------
    NoEvaluationError
        The readings do not have these parts.
    """
    t, d = _readings(time, reading, path)
    x = np.sqrt(t)
    fine = np.linspace(x[0], x[-1], _FINE)
    smooth = _interpolated(x, d)(fine)
    part = d <= d[0] + _STRAIGHT * (d[-1] - d[0])
    for _ in range(_ROUNDS):
        if part.sum() < 3:
            raise NoEvaluationError(
                f"{int(part.sum())} readings before half of the consolidation; at least 3 are needed"
            )
        slope, start, _ = straight_line(x[part], d[part])
        if not slope > 0.0:
            raise NoEvaluationError("the settlement does not grow at the beginning")
        at = _crossing(fine, smooth - (start + slope * fine / _FACTOR))
        d_90 = start + slope * at / _FACTOR
        end = start + (d_90 - start) / 0.9
        new = d <= start + _STRAIGHT * (end - start)
        if (new == part).all():
            break
        part = new
    return Consolidation(T_90 * path**2 / at**2, at**2, start, end, None, ((slope, start), (slope / _FACTOR, start)))


def log_time(time: npt.ArrayLike, reading: npt.ArrayLike, path: float) -> Consolidation:
    """Evaluate over the logarithm of time (Casagrande & Fadum 1940, Harvard Soil Mechanics Series 8).

    The beginning follows from the parabola, ``d_0 = 2 d(t_1) - d(4 t_1)``; the end is where the steepest tangent meets
    the line through the last half decade, at least the last two readings. ``c_v = 0.197 path^2/t_50``.

    Parameters and errors are those of :func:`root_time`; a reading at time 0 is not looked at.
    """
    t, d = _readings(time, reading, path)
    t, d = t[t > 0.0], d[t > 0.0]
    x = np.log10(t)
    if x[-1] - x[0] < 2.0:
        raise NoEvaluationError(f"readings over {x[-1] - x[0]:.2g} decades of time; at least 2 are needed")
    curve = _interpolated(x, d)
    last = x >= min(x[-1] - _FINAL - 1e-9, x[-_FINAL_READINGS])
    secondary, offset, _ = straight_line(x[last], d[last])
    fine = np.linspace(x[0], x[-1], _FINE)
    slopes = curve(fine, 1)
    steep = int(np.argmax(slopes))
    steepest = float(slopes[steep])
    if not (steepest > 0.0 and secondary <= _FLAT * steepest and fine[steep] < x[last][0]):
        raise NoEvaluationError("the curve does not become flat at the end: primary consolidation is not over")
    tangent = float(curve(fine[steep])) - steepest * float(fine[steep])
    meet = (offset - tangent) / (steepest - secondary)
    end = offset + secondary * meet
    start = _parabola(x, d, curve, end)
    t_50 = 10.0 ** _crossing(fine, 0.5 * (start + end) - curve(fine))
    lines = ((steepest, tangent), (secondary, offset))
    return Consolidation(T_50 * path**2 / t_50, t_50, start, end, secondary, lines)


def _interpolated(x: FloatArray, d: FloatArray) -> PchipInterpolator:
    from scipy.interpolate import PchipInterpolator  # takes most of a second to import

    return PchipInterpolator(x, d)


def _parabola(x: FloatArray, d: FloatArray, curve: PchipInterpolator, end: float) -> float:
    """Reading at time 0: mean of the parabolas from pairs of times 1 : 4 in the first half of consolidation."""
    later = x + math.log10(4.0)
    after = np.where(later <= x[-1], curve(np.minimum(later, x[-1])), math.inf)
    found = []
    for now, then in zip(d.tolist(), after.tolist(), strict=True):
        start = 2.0 * now - then
        if not then <= start + _STRAIGHT * (end - start):
            break
        found.append(start)
    if not found:
        raise NoEvaluationError("no two readings at t and 4 t before half of the consolidation")
    return float(np.mean(found))


def _crossing(x: FloatArray, gap: FloatArray) -> float:
    """Place where a gap, positive before, becomes negative, between the points x on a straight line."""
    positive = np.flatnonzero(gap > 0.0)
    below = np.flatnonzero((gap <= 0.0) & (np.arange(gap.size) > (positive[0] if positive.size else gap.size)))
    if not below.size:
        raise NoEvaluationError("the readings end before the degree of consolidation that the evaluation needs")
    i = int(below[0])
    return float(x[i - 1] + (x[i] - x[i - 1]) * gap[i - 1] / (gap[i - 1] - gap[i]))


def _readings(time: npt.ArrayLike, reading: npt.ArrayLike, path: float) -> tuple[FloatArray, FloatArray]:
    t, d = np.asarray(time, float), np.asarray(reading, float)
    if t.ndim != 1 or t.shape != d.shape or t.size < _LEAST:
        raise NoEvaluationError(
            f"{t.size} readings of one stage; at least {_LEAST} times and as many settlements are needed"
        )
    if not (np.isfinite(t).all() and np.isfinite(d).all() and t[0] >= 0.0 and (np.diff(t) > 0.0).all()):
        raise NoEvaluationError("times must be at least 0 and increase, and times and settlements be finite")
    if not path > 0.0:
        raise NoEvaluationError(f"the drainage path must be above 0 m, got {path:g}")
    if not d[-1] > d[0]:
        raise NoEvaluationError("the settlement does not grow; swelling is evaluated with its sign changed")
    return t, d
