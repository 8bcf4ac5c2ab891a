"""Weighted least-squares objective over several data series, equations (1) and (2) of Meier et al. (2008)."""

from __future__ import annotations

from geoswarm.solver.objective.least_squares import (
    LEAST_SLOPE,
    LeastSquares,
    ObservedSeries,
    PseudoReadings,
    counted_in_order,
)

__all__ = [
    "LEAST_SLOPE",
    "LeastSquares",
    "ObservedSeries",
    "PseudoReadings",
    "counted_in_order",
]
