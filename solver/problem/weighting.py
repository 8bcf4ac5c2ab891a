"""Weighting schemes: weights w_g of the series that follow from their readings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["WEIGHTINGS", "Weighting", "scheme_factors"]

Weighting: TypeAlias = Literal["by_error", "by_count", "by_range"]

WEIGHTINGS: tuple[Weighting, ...] = ("by_error", "by_count", "by_range")


def scheme_factors(
    weighting: Weighting, readings: Mapping[str, FloatArray], errors: Mapping[str, float]
) -> dict[str, float]:
    """Weights w_g that a scheme gives, scaled so that the largest is 1.

    ``by_error``
        m_g / sigma_g^2: every reading counts by its precision, which makes the estimate the most likely one for normal
        errors.
    ``by_count``
        m_g: every reading counts alike, where eq. (2) of Meier et al. (2008) lets every *series* count alike.
    ``by_range``
        1 / (max y - min y)^2: misfits relative to the range of each series, for series of different units. A series of
        constant readings takes their magnitude.

    Parameters
    ----------
    readings
        y of each series, shape (m_g,), base units.
    errors
        Standard deviation sigma_g of a reading of each series, base units; only ``by_error`` looks at them.
    """
    if weighting == "by_error":
        weights = {series: y.size / errors[series] ** 2 for series, y in readings.items()}
    elif weighting == "by_count":
        weights = {series: float(y.size) for series, y in readings.items()}
    else:
        weights = {series: 1.0 / _extent(y) ** 2 for series, y in readings.items()}
    largest = max(weights.values())
    return {series: weight / largest for series, weight in weights.items()}


def _extent(y: FloatArray) -> float:
    return float(np.ptp(y)) or float(np.abs(y).max()) or 1.0
