"""Measured points of a job with what was calculated there, in the units that the user gave."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from geoswarm.records.evaluation import Evaluation
from geoswarm.records.fit import Fit, FitCurve, FitDiagram, FitDiagrams, FitParameter, FitSeries
from geoswarm.records.statistics import SeriesShare
from geoswarm.solver.problem import FreeParameter, LinkedParameter, Problem
from geoswarm.solver.problem.weighting import series_shares
from geoswarm.solver.report.curves import load_times, objective_unit, residuals_in
from geoswarm.solver.report.figures.labels import parameter_labels
from geoswarm.solver.units import convert
from geoswarm.workers.service.job_service import JobService

if TYPE_CHECKING:
    from geoswarm.solver.report.compression import CompressionCurve
    from geoswarm.solver.report.diagrams import DiagramCurve

__all__ = ["diagrams_of", "fit_of"]

_OF_A_FORM = ("value", "expression", "lower", "upper", "scale", "initial")
"""What belongs to parameters of one form only; None in the others."""


def fit_of(service: JobService, job_id: str, chosen: tuple[int, int] | None = None) -> Fit:
    """Return the fit of a job from stored responses; nothing is recalculated.

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
    problem = service.parsed_problem(job_id)
    first = service.evaluations(job_id, generation=0, state="finished", limit=1, responses=True).items
    best = service.best(job_id)
    found: list[tuple[Literal["initial", "best", "chosen"], Evaluation]] = [("initial", view) for view in first]
    if best is not None:
        found.append(("best", best))
    if chosen is not None:
        found.append(("chosen", service.evaluation(job_id, *chosen)))
    orders = {o.series: np.argsort(o.x, kind="stable") for o in problem.observations}
    return Fit(
        objective_unit=objective_unit(problem),
        parameters=_parameters(problem),
        series=_series(problem, orders),
        curves=[_curve(problem, orders, role, view) for role, view in found],
    )


def diagrams_of(service: JobService, job_id: str) -> FitDiagrams:
    """Return the diagrams that the tests of a job declare, and compression curves; the model runs once for each.

    Raises
    ------
    JobNotFoundError
    """
    from geoswarm.solver.report.compression import compression_curves  # with Numba and SciPy
    from geoswarm.solver.report.diagrams import diagram_curves

    problem = service.parsed_problem(job_id)
    best = service.best(job_id)
    if best is None:
        return FitDiagrams(items=[])
    values = problem.values([best.parameters[name] for name in problem.free_names])
    compressed = [_compression(curve) for curve in compression_curves(problem, values, None)]
    return FitDiagrams(items=[*compressed, *(_diagram(curve) for curve in diagram_curves(problem, values))])


def _compression(curve: CompressionCurve) -> FitDiagram:
    (x_quantity, x_unit), (y_quantity, y_unit) = curve.axes
    return FitDiagram(
        name=f"compression.{curve.part}" if curve.part else "compression",
        heading="Compression curve",
        test=curve.part,
        x_quantity=x_quantity,
        y_quantity=y_quantity,
        x_unit=x_unit,
        y_unit=y_unit,
        log=True,
        downwards=not curve.void_ratio,
        x=curve.stress,
        y=curve.calculated,
        measured_x=curve.measured_stress,
        measured_y=curve.measured,
    )


def _diagram(curve: DiagramCurve) -> FitDiagram:
    return FitDiagram(
        name=f"{curve.diagram.name}.{curve.part}" if curve.part else curve.diagram.name,
        heading=curve.diagram.heading,
        test=curve.part,
        x_quantity=curve.x_info.y_quantity,
        y_quantity=curve.y_info.y_quantity,
        x_unit=curve.x_info.y_unit,
        y_unit=curve.y_info.y_unit,
        log=curve.diagram.log,
        downwards=curve.diagram.downwards,
        x=curve.x,
        y=curve.y,
        measured_x=curve.measured_x,
        measured_y=curve.measured_y,
    )


def _parameters(problem: Problem) -> list[FitParameter]:
    labels = parameter_labels(problem)
    usual = {info.name: info.typical for info in problem.model.parameters}
    listed = []
    for name, parameter in problem.parameters.items():
        label = labels[name]
        unit = "" if label.unit == "-" else label.unit
        own: dict[str, Any] = dict.fromkeys(_OF_A_FORM)
        if isinstance(parameter, FreeParameter):
            own |= {
                "form": "free",
                "lower": parameter.lower,
                "upper": parameter.upper,
                "scale": parameter.scale,
                "initial": parameter.initial,
            }
        elif isinstance(parameter, LinkedParameter):
            own |= {"form": "linked", "expression": parameter.expression.text}
        else:
            own |= {"form": "fixed", "value": parameter.value}
        low, high = usual.get(name) or (None, None)
        listed.append(
            FitParameter(name=name, symbol=label.symbol, unit=unit, typical_lower=low, typical_upper=high, **own)
        )
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
                x=convert(observation.x, info.x_unit, x_unit)[order],
                measured=convert(observation.y, info.y_unit, y_unit)[order],
                breaks=convert(breaks, info.x_unit, x_unit),
                gross_x=convert(observation.gross_x, info.x_unit, x_unit),
                gross_measured=convert(observation.gross_y, info.y_unit, y_unit),
                x_names=list(info.x_names),
                distance="vertical" if observation.along is None else "orthogonal",
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
    values, residuals = {}, {}
    for observation in problem.observations:
        if view.responses is not None and observation.series in view.responses:
            info = infos[observation.series]
            calculated = np.array(view.responses[observation.series].y, dtype=np.float64)
            y_unit = observation.y_unit or info.y_unit
            order = orders[observation.series]
            values[observation.series] = convert(calculated, info.y_unit, y_unit)[order]
            residuals[observation.series] = residuals_in(y_unit, observation, info, calculated)[order]
    misfits = {series: misfit for series, misfit in view.misfits.items() if misfit is not None}
    return FitCurve(
        role=role,
        generation=view.generation,
        particle=view.particle,
        objective=view.objective,
        parameters=problem.values([view.parameters[name] for name in problem.free_names]),
        shares=[SeriesShare(**asdict(share)) for share in series_shares(problem, misfits)] if misfits else [],
        values=values,
        residuals=residuals,
    )
