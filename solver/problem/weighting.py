"""Weighting schemes: weights w_g of the series that follow from their readings."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["WEIGHTINGS", "Weighting", "scheme_factors"]

Weighting: TypeAlias = Literal["by_error", "by_count", "by_range"]

WEIGHTINGS: tuple[Weighting, ...] = ("by_error", "by_count", "by_range")


def scheme_factors(
    weighting: Weighting, measured: Mapping[str, FloatArray], readings: Mapping[str, float], errors: Mapping[str, float]
) -> dict[str, float]:
    """Weights w_g that a scheme gives, scaled so that the largest is 1.

    ``by_error``
        m_g / sigma_g^2: every point counts by its precision, which makes the estimate the most likely one for normal
        errors.
    ``by_count``
        Number of readings: each counts alike, also those behind a point that is their mean, where eq. (2) of Meier et
        al. (2008) lets every *series* count alike.
    ``by_range``
        1 / (max y - min y)^2: misfits relative to the range of each series, for series of different units. A series of
        constant readings takes their magnitude.

    Parameters
    ----------
    measured
        y of each series, shape (m_g,), base units.
    readings
        Number of readings behind the points of each series.
    errors
        Standard deviation sigma_g of a point of weight 1 of each series, base units; only ``by_error`` looks at them.
    """
    if weighting == "by_error":
        scaled = _scaled({series: errors[series] for series in measured})
        weights = {series: y.size / scaled[series] ** 2 for series, y in measured.items()}
    elif weighting == "by_count":
        weights = dict(readings)
    else:
        weights = {series: 1.0 / extent**2 for series, extent in _scaled(_extents(measured)).items()}
    largest = max(weights.values())
    return {series: weight / largest for series, weight in weights.items()}


def _extents(measured: Mapping[str, FloatArray]) -> dict[str, float]:
    with np.errstate(over="ignore"):
        found = {series: float(np.ptp(y)) or float(np.abs(y).max()) or 1.0 for series, y in measured.items()}
    return {series: min(extent, sys.float_info.max) for series, extent in found.items()}


def _scaled(sizes: Mapping[str, float]) -> dict[str, float]:
    """Sizes by a common power of two, which is exact, so that the smallest is about 1 and has a square."""
    power = -math.frexp(min(sizes.values()))[1]
    largest = math.sqrt(sys.float_info.max) / 2.0  # what is that much larger counts for nothing
    with np.errstate(over="ignore"):
        return {series: min(float(np.ldexp(size, power)), largest) for series, size in sizes.items()}
