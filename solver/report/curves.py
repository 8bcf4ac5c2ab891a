"""Measured and calculated series in the units that the user gave, and the share of each in the objective."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from solver.arrays import FloatArray
from solver.errors import ForwardError
from solver.forward.base import SeriesInfo
from solver.problem import Observation, Problem
from solver.problem.units import convert

__all__ = ["SeriesCurve", "SeriesShare", "objective_unit", "series_curves", "series_shares"]


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
    at_points
        Calculated values at the measured points, shape (m,).
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


@dataclass(frozen=True, slots=True)
class SeriesShare:
    """Part of one series in the objective.

    Parameters
    ----------
    series
        Name.
    weight, misfit
        w_g and f'_g of equations (1) and (2), (base unit)^2.
    share
        w_g f'_g / f, between 0 and 1; 0 when the objective is 0.
    """

    series: str
    weight: float
    misfit: float
    share: float


def series_curves(
    problem: Problem, responses: Mapping[str, FloatArray], values: Mapping[str, float]
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
        the curve joins the calculated points.
    """
    grids = {o.series: _grid(problem, o) for o in problem.observations}
    try:
        with np.errstate(all="ignore"):
            dense: Mapping[str, FloatArray] = problem.model.prepare(grids)(values)
    except ForwardError:
        grids, dense = {o.series: o.x for o in problem.observations}, responses
    known = {info.name: info for info in problem.model.series}
    return [
        _curve(o, known[o.series], grids[o.series], dense[o.series], responses[o.series]) for o in problem.observations
    ]


def series_shares(problem: Problem, misfits: Mapping[str, float]) -> list[SeriesShare]:
    """Return the share of every series in the objective, in the order of the problem."""
    parts = [(o.series, o.weight, misfits[o.series]) for o in problem.observations]
    objective = sum(weight * misfit for _, weight, misfit in parts)
    return [
        SeriesShare(series, weight, misfit, weight * misfit / objective if objective > 0.0 else 0.0)
        for series, weight, misfit in parts
    ]


def objective_unit(problem: Problem) -> str:
    """Return the unit of the objective, for example ``m²``; empty when the series differ in unit or have none."""
    known = {info.name: info.y_unit for info in problem.model.series}
    units = {known[o.series] for o in problem.observations}
    if len(units) != 1 or units & {"", "dimensionless"}:
        return ""
    return f"{units.pop()}²"


def _grid(problem: Problem, observation: Observation) -> FloatArray:
    grid = problem.model.grid(observation.series)
    within = grid[grid <= observation.x.max()]
    return np.union1d(within, observation.x)


def _curve(
    observation: Observation, info: SeriesInfo, x: FloatArray, y: FloatArray, at_points: FloatArray
) -> SeriesCurve:
    x_unit, y_unit = observation.x_unit or info.x_unit, observation.y_unit or info.y_unit

    def to_x(values: FloatArray) -> FloatArray:
        return convert(values, info.x_unit, x_unit)

    def to_y(values: FloatArray) -> FloatArray:
        return convert(values, info.y_unit, y_unit)

    order = np.argsort(observation.x, kind="stable")
    return SeriesCurve(
        series=observation.series,
        x_quantity=info.x_quantity,
        y_quantity=info.y_quantity,
        x_unit=x_unit,
        y_unit=y_unit,
        measured_x=to_x(observation.x)[order],
        measured_y=to_y(observation.y)[order],
        x=to_x(x),
        y=to_y(np.asarray(y, dtype=np.float64)),
        at_points=to_y(np.asarray(at_points, dtype=np.float64))[order],
    )
