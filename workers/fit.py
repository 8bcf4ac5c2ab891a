"""Measured points of a job with what was calculated there, in the units that the user gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from geoswarm.records.evaluation import Evaluation
from geoswarm.solver.problem import FreeParameter, LinkedParameter, Problem, parse_problem
from geoswarm.solver.problem.units import convert
from geoswarm.solver.report.curves import SeriesShare, load_times, objective_unit, series_shares
from geoswarm.solver.report.labels import parameter_labels
from geoswarm.workers.service import JobService

__all__ = ["FitCurve", "FitParameter", "FitSeries", "FitView", "fit_of"]


@dataclass(frozen=True, slots=True)
class FitParameter:
    """A parameter as it stands in the problem; what does not belong to its form is None."""

    name: str
    symbol: str
    unit: str
    form: Literal["free", "fixed", "linked"]
    value: float | None = None
    expression: str | None = None
    lower: float | None = None
    upper: float | None = None
    scale: str | None = None
    initial: float | None = None


@dataclass(frozen=True, slots=True)
class FitSeries:
    """Measured points of one series, by rising x.

    Parameters
    ----------
    x, measured
        Shape (m,), in ``x_unit`` and ``y_unit``.
    breaks
        x at which a load is applied.
    """

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    weight: float
    x: list[float]
    measured: list[float]
    breaks: list[float]


@dataclass(frozen=True, slots=True)
class FitCurve:
    """What one evaluation gives at the measured points.

    Parameters
    ----------
    role
        initial: the first evaluation of the job; best; chosen: the one asked for.
    parameters
        All of them, by name.
    values
        Calculated values of each series, shape (m,), in its ``y_unit``; empty where the evaluation has none.
    """

    role: Literal["initial", "best", "chosen"]
    generation: int
    particle: int
    objective: float | None
    parameters: dict[str, float]
    shares: list[SeriesShare]
    values: dict[str, list[float]]


@dataclass(frozen=True, slots=True)
class FitView:
    """What a fit plot shows; ``objective_unit`` is empty where series of different units add up."""

    objective_unit: str
    parameters: list[FitParameter]
    series: list[FitSeries]
    curves: list[FitCurve]


def fit_of(service: JobService, job_id: str, chosen: tuple[int, int] | None = None) -> FitView:
    """Return the fit of a job, from stored responses: nothing is calculated anew.

    Parameters
    ----------
    chosen
        Generation and particle of one more evaluation to show.

    Raises
    ------
    JobNotFoundError
    EvaluationNotFoundError
        When there is no such evaluation.
    """
    problem = parse_problem(service.problem(job_id))
    first = service.evaluations(job_id, generation=0, state="finished", limit=1, responses=True).items
    best = service.best(job_id)
    found: list[tuple[Literal["initial", "best", "chosen"], Evaluation]] = [("initial", view) for view in first]
    if best is not None:
        found.append(("best", best))
    if chosen is not None:
        found.append(("chosen", service.evaluation(job_id, *chosen)))
    orders = {o.series: np.argsort(o.x, kind="stable") for o in problem.observations}
    return FitView(
        objective_unit=objective_unit(problem),
        parameters=_parameters(problem),
        series=_series(problem, orders),
        curves=[_curve(problem, orders, role, view) for role, view in found],
    )


def _parameters(problem: Problem) -> list[FitParameter]:
    labels = parameter_labels(problem)
    listed = []
    for name, parameter in problem.parameters.items():
        label = labels[name]
        unit = "" if label.unit == "-" else label.unit
        if isinstance(parameter, FreeParameter):
            own: dict[str, Any] = {
                "form": "free",
                "lower": parameter.lower,
                "upper": parameter.upper,
                "scale": parameter.scale,
                "initial": parameter.initial,
            }
        elif isinstance(parameter, LinkedParameter):
            own = {"form": "linked", "expression": parameter.expression.text}
        else:
            own = {"form": "fixed", "value": parameter.value}
        listed.append(FitParameter(name, label.symbol, unit, **own))
    return listed


def _series(problem: Problem, orders: Mapping[str, npt.NDArray[np.intp]]) -> list[FitSeries]:
    infos = {info.name: info for info in problem.model.series}
    listed = []
    for observation in problem.observations:
        info, order = infos[observation.series], orders[observation.series]
        x_unit, y_unit = observation.x_unit or info.x_unit, observation.y_unit or info.y_unit
        breaks = load_times(problem, observation.series)
        listed.append(
            FitSeries(
                series=observation.series,
                x_quantity=info.x_quantity,
                y_quantity=info.y_quantity,
                x_unit=x_unit,
                y_unit=y_unit,
                weight=observation.weight,
                x=convert(observation.x, info.x_unit, x_unit)[order].tolist(),
                measured=convert(observation.y, info.y_unit, y_unit)[order].tolist(),
                breaks=convert(breaks, info.x_unit, x_unit).tolist(),
            )
        )
    return listed


def _curve(
    problem: Problem,
    orders: Mapping[str, npt.NDArray[np.intp]],
    role: Literal["initial", "best", "chosen"],
    view: Evaluation,
) -> FitCurve:
    infos = {info.name: info for info in problem.model.series}
    values = {}
    for observation in problem.observations:
        if view.responses is not None and observation.series in view.responses:
            info = infos[observation.series]
            calculated = np.array(view.responses[observation.series].y, dtype=np.float64)
            y_unit = observation.y_unit or info.y_unit
            values[observation.series] = convert(calculated, info.y_unit, y_unit)[orders[observation.series]].tolist()
    misfits = {series: misfit for series, misfit in view.misfits.items() if misfit is not None}
    return FitCurve(
        role=role,
        generation=view.generation,
        particle=view.particle,
        objective=view.objective,
        parameters=problem.values([view.parameters[name] for name in problem.free_names]),
        shares=series_shares(problem, misfits) if misfits else [],
        values=values,
    )
