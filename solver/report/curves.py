"""Measured and calculated series in the units that the user gave."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.errors import ForwardError
from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.problem import Observation, Problem
from geoswarm.solver.problem.stages import stage_times
from geoswarm.solver.residuals import OUTLYING
from geoswarm.solver.units import convert, convert_difference

__all__ = [
    "MOST_SHOWN",
    "SeriesCurve",
    "initial_values",
    "load_times",
    "objective_unit",
    "residuals_in",
    "series_curves",
    "shown",
]


MOST_SHOWN = 4000
"""Points of a curve that a figure draws: more than it has pixels."""


@dataclass(frozen=True, slots=True)
class SeriesCurve:
    """One observed series with its calculated curve.

    Parameters
    ----------
    series
        Name.
    x_quantity, y_quantity
        What the axes show.
    x_unit, y_unit
        Units that the user gave for the observation, else the base units; all numbers here are in them.
    measured_x, measured_y
        Measured points, shape (m,).
    x, y
        Calculated curve, shape (n,): the model's own grid up to the last measured point together with the measured
        points.
    at_points, residuals
        Calculated values and residuals at the measured points, shape (m,).
    distances
        Whether the residuals are distances from the calculated curve.
    initial
        Curve of the estimate to start from, shape (n,); None without one.
    gross_x, gross_y
        Readings marked as gross errors, shape (q,); they take no part.
    breaks
        x at which a load is applied, of a test with loads in stages over time, shape (k,); empty for other series.
    loss_weights
        Weights that a robust loss gives the measured points, shape (m,); None without a loss.
    x_integer
        Whether x counts something, such as stages.
    """

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    measured_x: FloatArray
    measured_y: FloatArray
    x: FloatArray
    y: FloatArray
    at_points: FloatArray
    residuals: FloatArray
    distances: bool = False
    initial: FloatArray | None = None
    breaks: FloatArray = field(default_factory=lambda: np.empty(0))
    gross_x: FloatArray = field(default_factory=lambda: np.empty(0))
    gross_y: FloatArray = field(default_factory=lambda: np.empty(0))
    loss_weights: FloatArray | None = None
    x_integer: bool = False

    def thinned(self) -> SeriesCurve:
        """Return the curve with as many points as a figure can show."""
        if max(len(self.x), len(self.measured_x)) <= MOST_SHOWN:
            return self
        line = shown(self.y) if self.initial is None else shown(self.y, self.initial)
        points = shown(self.measured_y, self.residuals)
        return replace(
            self,
            x=self.x[line],
            y=self.y[line],
            initial=None if self.initial is None else self.initial[line],
            measured_x=self.measured_x[points],
            measured_y=self.measured_y[points],
            at_points=self.at_points[points],
            residuals=self.residuals[points],
            loss_weights=None if self.loss_weights is None else self.loss_weights[points],
        )

    @property
    def outliers(self) -> BoolArray:
        """Measured points that a robust loss all but sets aside, shape (m,); none without a loss."""
        none = np.zeros(self.measured_y.shape, dtype=np.bool_)
        return none if self.loss_weights is None else np.asarray(self.loss_weights < OUTLYING)


def series_curves(
    problem: Problem,
    responses: Mapping[str, FloatArray],
    values: Mapping[str, float],
    initial: Mapping[str, float] | None = None,
) -> list[SeriesCurve]:
    """Return every observed series with its calculated curve, in the order of the problem.

    Parameters
    ----------
    problem
        Gives measured points and units.
    responses
        Calculated values at the measured points, shape (m_g,), base units.
    values
        Value of every parameter; the curve between the points is calculated with them. Where that calculation fails,
        the curve joins the calculated points, as it does for the user's programs, which are not watched here.
    initial
        Value of every parameter of the estimate to start from; a second curve where that calculation succeeds.
    """
    outside = problem.forward_model.runs_outside and not problem.forward_model.only_here
    grids = {o.series: o.x if outside else _grid(problem, o) for o in problem.observations}
    known_there = all(grids[o.series] is o.x for o in problem.observations)
    dense = dict(responses) if known_there else _calculate(problem, grids, values)
    if dense is None:
        grids, dense = {o.series: o.x for o in problem.observations}, dict(responses)
    first = None if initial is None or outside else _calculate(problem, grids, initial)
    known = {info.name: info for info in problem.model.series}
    return [
        _curve(
            o,
            known[o.series],
            grids[o.series],
            (dense[o.series], responses[o.series], None if first is None else first[o.series]),
            load_times(problem, o.series),
        )
        for o in problem.observations
    ]


def initial_values(problem: Problem) -> dict[str, float] | None:
    """Return the estimate to start from, all parameters; None when the problem gives no ``initial`` value at all.

    A free parameter without one is in the middle of its bounds, in its search coordinate.
    """
    if all(p.initial is None for p in problem.free):
        return None
    middle = [math.sqrt(p.lower * p.upper) if p.scale == "log" else (p.lower + p.upper) / 2.0 for p in problem.free]
    return problem.values([m if p.initial is None else p.initial for p, m in zip(problem.free, middle, strict=True)])


def load_times(problem: Problem, series: str) -> FloatArray:
    """Return the times [day] at which loads are applied, shape (k,), where a series runs over the time of such a test.

    Empty for every other series. Times count from the series' zero; loads before it are left out.
    """
    starts = stage_times(problem.forward_model, series)
    return np.asarray(starts[starts >= 0.0])


def _calculate(
    problem: Problem, grids: Mapping[str, FloatArray], values: Mapping[str, float]
) -> dict[str, FloatArray] | None:
    try:
        with np.errstate(all="ignore"):
            return problem.model.prepare(grids)(values)
    except ForwardError:
        return None


def objective_unit(problem: Problem) -> str:
    """Return the unit of the objective, for example ``m²``; empty when the series differ in unit or have none."""
    known = {info.name: info.y_unit for info in problem.model.series}
    units = {known[o.series] for o in problem.observations}
    if len(units) != 1 or units & {"", "dimensionless"}:
        return ""
    return f"{units.pop()}²"


def _grid(problem: Problem, observation: Observation) -> FloatArray:
    grid = problem.model.grid(observation.series)
    if problem.forward_model.runs_outside and not grid.size:
        return observation.x  # in this order: a function answers for the points that it knows
    within = grid[grid <= observation.x.max()]
    return np.union1d(within, observation.x)


def _curve(
    observation: Observation,
    info: SeriesInfo,
    x: FloatArray,
    calculated: tuple[FloatArray, FloatArray, FloatArray | None],
    breaks: FloatArray,
) -> SeriesCurve:
    y, at_points, initial = calculated
    x_unit, y_unit = observation.x_unit or info.x_unit, observation.y_unit or info.y_unit

    def to_x(values: FloatArray) -> FloatArray:
        return convert(values, info.x_unit, x_unit)

    def to_y(values: FloatArray) -> FloatArray:
        return convert(values, info.y_unit, y_unit)

    order = np.argsort(observation.x, kind="stable")
    weights = None
    if observation.loss is not None:
        z = np.sqrt(observation.point_weights) * (observation.residuals(at_points) / observation.loss.scale)
        weights = observation.loss.weight(z)
    along = np.argsort(x, kind="stable")
    return SeriesCurve(
        series=observation.series,
        x_quantity=info.x_quantity,
        y_quantity=info.y_quantity,
        x_unit=x_unit,
        y_unit=y_unit,
        measured_x=to_x(observation.x)[order],
        measured_y=to_y(observation.y)[order],
        x=to_x(x)[along],
        y=to_y(np.asarray(y, dtype=np.float64))[along],
        at_points=to_y(np.asarray(at_points, dtype=np.float64))[order],
        residuals=residuals_in(y_unit, observation, info, np.asarray(at_points, dtype=np.float64))[order],
        distances=observation.along is not None,
        initial=None if initial is None else to_y(np.asarray(initial, dtype=np.float64))[along],
        breaks=to_x(breaks),
        gross_x=to_x(observation.gross_x),
        gross_y=to_y(observation.gross_y),
        loss_weights=None if weights is None else weights[order],
        x_integer=info.x_integer,
    )


def residuals_in(unit: str, observation: Observation, info: SeriesInfo, calculated: FloatArray) -> FloatArray:
    """Residuals of calculated values, base unit, at the points in their order, shape (m,), in ``unit``."""
    if observation.along is None:
        return convert(calculated, info.y_unit, unit) - convert(observation.y, info.y_unit, unit)
    return observation.residuals(calculated) * convert_difference(1.0, info.y_unit, unit)


def shown(*curves: FloatArray) -> IntArray:
    """Return which points to draw, rising.

    Parameters
    ----------
    curves
        Values over one x, each of shape (n,).

    Returns
    -------
    All n if they are not too many; else of every group of neighbours the first, the last, and for each of the curves
    the lowest and the highest, so that lines and clouds of points look as if all were drawn.
    """
    count = len(curves[0])
    if count <= MOST_SHOWN:
        return np.arange(count)
    groups = MOST_SHOWN // (2 + 2 * len(curves))
    edges = np.linspace(0, count, groups + 1).astype(np.int64)
    chosen = [edges[:-1], edges[1:] - 1]
    for curve in curves:
        for pick in (np.argmin, np.argmax):
            chosen += [np.array([a + int(pick(curve[a:b])) for a, b in pairwise(edges)])]
    return np.unique(np.concatenate(chosen))
