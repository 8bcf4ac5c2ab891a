"""Compression and swelling index, and preconsolidation stress, of void ratios over the logarithm of the stress."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.parameter_estimates.values import NoEvaluationError, straight_line

__all__ = [
    "Casagrande",
    "LogLog",
    "VirginLine",
    "casagrande",
    "compression_index",
    "first_loading",
    "log_log",
    "swelling_index",
    "virgin_line",
]

_FEWEST = 3
"""Points of first loading that a virgin line needs."""
_VIRGIN = 2.0
"""Least ratio of the slope of first loading to that of unloading where all of it is virgin."""
_STEEP = 0.9
"""Share of the steepest slope that belongs to the virgin line."""
_STEEPENS = 1.3
"""Least ratio of the steepest slope to that of the first interval, without which there is no virgin line to be seen."""


@dataclass(frozen=True, slots=True)
class VirginLine:
    """``e = start - index log10(stress)``, stress in kPa; ``points`` is how many points it was laid through."""

    index: float
    start: float
    points: int


def first_loading(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return log10(stress) and void ratio where the stress is larger than all before, shape (m,).

    Parameters
    ----------
    stress, void_ratio
        Vertical effective stress, kPa, above 0, and void ratio (or minus the strain) at the ends of the stages in their
        order, shape (n,).

    Raises
    ------
    NoEvaluationError
        They are not as many, not finite, or a stress is not above 0.
    """
    log, e = _curve(stress, void_ratio)
    before = np.concatenate([[-np.inf], np.maximum.accumulate(log)[:-1]])
    return log[log > before], e[log > before]


def virgin_line(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> VirginLine:
    """Lay a line through the steepest part of the first loading.

    It goes through all neighbouring intervals with at least nine tenths of the steepest slope (Terzaghi, Peck & Mesri
    1996, Soil Mechanics in Engineering Practice, article 16: Cc is the slope of the straight part).

    Raises
    ------
    NoEvaluationError
        There are fewer than three points of first loading, or it does not become steeper.
    """
    x, e = first_loading(stress, void_ratio)
    if x.size < _FEWEST:
        raise NoEvaluationError(f"{x.size} points of first loading; at least {_FEWEST} are needed")
    slopes = -np.diff(e) / np.diff(x)
    steepest = int(np.argmax(slopes))
    if not slopes[steepest] > 0.0:
        raise NoEvaluationError("the void ratio does not fall with the stress")
    if not slopes[steepest] >= _STEEPENS * slopes[0]:
        raise NoEvaluationError("the curve does not become steeper; the virgin line cannot be told from reloading")
    first = last = steepest
    while first > 0 and slopes[first - 1] >= _STEEP * slopes[steepest]:
        first -= 1
    while last < slopes.size - 1 and slopes[last + 1] >= _STEEP * slopes[steepest]:
        last += 1
    part = slice(first, last + 2)
    slope, start, _ = straight_line(x[part], e[part])
    return VirginLine(-slope, start, last + 2 - first)


def compression_index(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> float:
    """Compression index Cc, the slope of :func:`virgin_line`; of minus the strain it is Cc / (1 + e_0).

    First loading that does not become steeper is that of a normally consolidated specimen, and all of it counts, where
    it is at least twice as steep as unloading.

    Raises
    ------
    NoEvaluationError
        There are fewer than three points of first loading, or what of it is virgin cannot be told.

    Examples
    --------
    >>> stress = [10.0, 20.0, 40.0, 80.0, 160.0]
    >>> round(compression_index(stress, [1.00, 0.99, 0.98, 0.88, 0.78]), 4)  # 0.1 in log10(2) of a decade
    0.3322
    """
    try:
        return virgin_line(stress, void_ratio).index
    except NoEvaluationError:
        x, e = first_loading(stress, void_ratio)
        if x.size < _FEWEST:
            raise
        slope = -straight_line(x, e)[0]
        try:
            steep = slope >= _VIRGIN * swelling_index(stress, void_ratio) > 0.0
        except NoEvaluationError:
            steep = False
        if not steep:
            raise
        return slope


def swelling_index(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> float:
    """Swelling index Cs: one slope for all unloadings, each with a line of its own (least squares).

    Raises
    ------
    NoEvaluationError
        There is no unloading.
    """
    log, e = _curve(stress, void_ratio)
    top = bottom = 0.0
    begin = 0
    for i, (before, now) in enumerate(pairwise([*log.tolist(), np.inf])):
        if now < before:
            continue
        if i > begin:
            x, y = log[begin : i + 1], e[begin : i + 1]
            top += float((x - x.mean()) @ y)
            bottom += float((x - x.mean()) @ x)
        begin = i + 1
    if bottom == 0.0:
        raise NoEvaluationError("there is no unloading")
    return -top / bottom


def _curve(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    s, e = np.asarray(stress, float), np.asarray(void_ratio, float)
    if s.ndim != 1 or s.shape != e.shape or s.size == 0:
        raise NoEvaluationError(
            f"stresses of shape {s.shape} and void ratios of shape {e.shape}; as many of both are needed"
        )
    if not (np.isfinite(s).all() and np.isfinite(e).all() and (s > 0.0).all()):
        raise NoEvaluationError("stresses must be above 0 kPa, and stresses and void ratios finite")
    return np.log10(s), e


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


def casagrande(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> Casagrande:
    """Preconsolidation stress after Casagrande (1936, Proc. 1st ICSMFE, Cambridge, vol. 3, 60-64).

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


def log_log(stress: npt.ArrayLike, void_ratio: npt.ArrayLike) -> LogLog:
    """Preconsolidation stress: where two lines meet in ln(1 + e) over log(stress).

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
