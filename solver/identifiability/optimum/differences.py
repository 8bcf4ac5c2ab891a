"""Sensitivities of the responses by finite differences, as one generation that can be evaluated in parallel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError, TooFewPointsError
from geoswarm.solver.search.descent.differences import DifferenceDesign, derivative, plan_differences
from geoswarm.solver.search.descent.steps import FIRST_STEP, StepSearch

__all__ = [
    "DifferenceDesign",
    "Jacobian",
    "design",
    "differentiate",
    "evaluate_differences",
    "residual_rows",
]


@dataclass(frozen=True, slots=True)
class Jacobian:
    """Derivatives of the residuals: where these are differences of y, those of the responses.

    Parameters
    ----------
    optimum
        Where, shape (d,), natural values.
    responses
        Calculated values at the optimum, shape (m_g,) a series, base units.
    derivatives
        Of each series, shape (m_g, d), in its base unit per *range*: the change over the whole range between the bounds
        in search coordinates, extrapolated linearly.
    error
        Estimate of their errors, same shapes.
    origin
        ``differences`` or ``samples``.
    """

    optimum: FloatArray
    responses: dict[str, FloatArray]
    derivatives: dict[str, FloatArray]
    error: dict[str, FloatArray]
    origin: str


def check_points(calibration: Calibration) -> None:
    """Refuse problems with fewer points than free parameters.

    Raises
    ------
    TooFewPointsError
        Says how many there are and are needed.
    """
    points, free = calibration.problem.counted_points, calibration.space.dimension
    if points < free:
        raise TooFewPointsError(
            f"{points} measured point{'' if points == 1 else 's'} cannot determine {free} free parameters "
            f"({', '.join(calibration.free_names)}); fix or link some of them, or add measurements"
        )


def design(calibration: Calibration, optimum: FloatArray, *, step: float = FIRST_STEP) -> DifferenceDesign:
    """Plan the evaluations for the sensitivities: the optimum and four places along each parameter, 4 d + 1 in all.

    Central places where both sides are inside the bounds and feasible, otherwise all on one side.

    Parameters
    ----------
    optimum
        Shape (d,), natural values of the free parameters, inside the bounds.
    step
        Largest offset in parts of the range in search coordinates, the same for all parameters. Take more for a rough
        forward model, less where the response bends fast; :func:`evaluate_differences` finds it.

    Raises
    ------
    TooFewPointsError
        When there are fewer measured points than free parameters.
    """
    check_points(calibration)
    return plan_differences(calibration.space, optimum, step)


def evaluate_differences(calibration: Calibration, optimum: FloatArray) -> tuple[DifferenceDesign, list[Evaluation]]:
    """Evaluate the neighbours of an optimum in this process, with steps found for each parameter.

    Returns
    -------
    plan, evaluations
        Those with the best step of each parameter, for :func:`differentiate`.

    Raises
    ------
    TooFewPointsError
        When there are fewer measured points than free parameters.
    """
    check_points(calibration)
    search: StepSearch | None = StepSearch(calibration.space, optimum)
    evaluations: list[Evaluation] = []
    while search is not None:
        last = search
        evaluations += [calibration.evaluate(position) for position in search.positions]
        residuals = residual_rows(calibration, evaluations)
        search = search.next(residuals)
    plan, rows = last.chosen(residuals)
    return plan, [evaluations[row] for row in rows]


def residual_rows(calibration: Calibration, evaluations: Sequence[Evaluation]) -> FloatArray:
    """Weighted residuals of evaluations, shape (n, m); nan where one failed."""
    objective = calibration.objective
    failed = np.full(sum(o.y.size for o in objective.observed), np.nan)
    return np.array([objective.weighted_residuals(e.responses) if e.reason is None else failed for e in evaluations])


def differentiate(calibration: Calibration, plan: DifferenceDesign, evaluations: Sequence[Evaluation]) -> Jacobian:
    """Differentiate residuals, of differences of y the responses, from evaluations of a plan; failed ones are left out.

    Raises
    ------
    StatisticsError
        When the optimum itself failed, or too few evaluations along a parameter succeeded.
    """
    if len(evaluations) != len(plan.positions):
        raise StatisticsError(f"{len(evaluations)} evaluations are given; the plan has {len(plan.positions)}")
    centre = evaluations[0]
    if centre.reason is not None:
        raise StatisticsError(f"the evaluation of the optimum failed ({centre.reason}): {centre.message}")
    observed = calibration.objective.observed
    derivatives = {o.series: np.empty((o.y.size, len(plan.optimum))) for o in observed}
    errors = {s: np.empty_like(array) for s, array in derivatives.items()}
    for index, name in enumerate(calibration.free_names):
        chosen = [i for i in np.flatnonzero(plan.parameter == index).tolist() if evaluations[i].reason is None]
        if len(chosen) < 2:
            raise StatisticsError(
                f"sensitivities to {name} cannot be calculated: only {len(chosen)} neighbouring evaluations succeeded"
            )
        offsets = np.array([0.0, *plan.offset[chosen]])
        for o in observed:
            values = np.stack([evaluations[i].responses[o.series] for i in [0, *chosen]])
            values = values if o.along is None else o.residuals(values)
            derivatives[o.series][:, index], errors[o.series][:, index] = derivative(offsets, values)
    return Jacobian(plan.optimum, dict(centre.responses), derivatives, errors, "differences")
