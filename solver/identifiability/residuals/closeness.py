"""How close calculated curves come to the readings, by quantity over all tests: what an engineer asks of a model.

No law describes real soil within the scatter of its readings. Whether it does is one question, which
:mod:`.lack_of_fit` answers; whether it comes close enough for its purpose is another, and the engineer's: peak strength
within 4 %, settlement within 0.2 mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from geoswarm.solver.identifiability.misfits import Closeness, unit_of
from geoswarm.solver.identifiability.residuals.readings import MeasuredResiduals
from geoswarm.solver.problem import Problem
from geoswarm.solver.units import convert_difference

__all__ = ["closeness_of"]

_STRENGTHS = ("q", "τ", "q/p'", "τ/σ'v")
"""Quantities whose largest value is a strength."""


def closeness_of(
    problem: Problem, series: Sequence[str], measured: Sequence[MeasuredResiduals]
) -> tuple[Closeness, ...]:
    """Return how close each quantity comes, in the order of the series.

    Parameters
    ----------
    series, measured
        Names, and residuals of the result there, of the series that count.
    """
    groups: dict[str, list[Closeness]] = {}
    for name, residuals in zip(series, measured, strict=True):
        info = next(one for one in problem.model.series if one.name == name)
        own = groups.setdefault(info.y_quantity, [])
        unit = own[0].unit if own else unit_of(problem, name)
        deviation, largest = (abs(convert_difference(size, info.y_unit, unit)) for size in residuals.size(None)[:2])
        own.append(Closeness(info.y_quantity, 1, largest, deviation, _peak(info.y_quantity, residuals), unit))
    return tuple(_together(own) for own in groups.values())


def _peak(quantity: str, residuals: MeasuredResiduals) -> float | None:
    """Relative difference between the largest calculated and the largest measured value."""
    measured = float(np.abs(residuals.y).max())
    if quantity not in _STRENGTHS or measured == 0.0:
        return None
    return abs(float(np.abs(residuals.calculated).max()) / measured - 1.0)


def _together(own: Sequence[Closeness]) -> Closeness:
    return replace(
        own[0],
        series=len(own),
        largest=max(one.largest for one in own),
        deviation=float(np.sqrt(np.mean([one.deviation**2 for one in own]))),
        peak=max((one.peak for one in own if one.peak is not None), default=None),
    )
