"""Compression and swelling index: slopes of the void ratio over the decimal logarithm of the stress."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.classical.curves import NoEvaluationError, straight_line

__all__ = ["VirginLine", "compression_index", "first_loading", "swelling_index", "virgin_line"]

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
