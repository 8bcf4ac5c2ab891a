"""Polishing an optimum: Levenberg-Marquardt on the weighted residuals, from where a search ended.

A swarm stops in the neighbourhood of the optimum; a few least-squares steps bring the digits that standard errors need.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability.errors import StatisticsError

__all__ = ["Polished", "polish"]

_FAILED = 1e3  # residuals of a failed or infeasible place, in multiples of the largest at the start


@dataclass(frozen=True, slots=True)
class Polished:
    """Result of :func:`polish`.

    Parameters
    ----------
    parameters
        Shape (d,), natural values.
    objective, start_objective
        f there and at the start; never above it.
    evaluation
        Of the forward calculation at ``parameters``.
    evaluations
        Forward calculations that it took.
    converged
        Whether a stop tolerance was met.
    at_bounds
        Parameters that ended on a bound.
    """

    parameters: FloatArray
    objective: float
    start_objective: float
    evaluation: Evaluation
    evaluations: int
    converged: bool
    at_bounds: tuple[str, ...]


def polish(calibration: Calibration, start: FloatArray, *, step: float = 1e-5, max_evaluations: int = 2000) -> Polished:
    """Minimise the objective from ``start`` by bounded least squares.

    The trust-region reflective form of Levenberg-Marquardt (Branch, Coleman and Li 1999; ``scipy.optimize``) on
    the weighted residuals, whose squares sum up to f, in parts of the range in search coordinates, with
    central differences. Runs in sequence, in this process.

    Parameters
    ----------
    start
        Shape (d,), natural values inside the bounds.
    step
        Of the differences, in parts of the range. Take more for a rough forward model.
    max_evaluations
        Forward calculations at most, about.

    Raises
    ------
    StatisticsError
        When the evaluation of the start fails.
    """
    from scipy.optimize import least_squares

    space = calibration.space
    low, span = space.search_lower, space.search_upper - space.search_lower
    first = calibration.evaluate(np.asarray(start, dtype=np.float64))
    if first.objective is None:
        raise StatisticsError(f"the start of polishing fails ({first.reason}): {first.message}")
    begin = calibration.objective.weighted_residuals(first.responses)
    failed = np.full_like(begin, _FAILED * max(float(np.abs(begin).max()), 1e-300))
    count = 1

    def natural(unit: FloatArray) -> FloatArray:
        return space.to_natural(low + unit * span)

    def residuals(unit: FloatArray) -> FloatArray:
        nonlocal count
        point = natural(unit)
        if not space.feasible(point):
            return failed
        count += 1
        evaluation = calibration.evaluate(point)
        if evaluation.objective is None:
            return failed
        return calibration.objective.weighted_residuals(evaluation.responses)

    dimension = space.dimension
    inside = np.clip((space.to_search(first.parameters) - low) / span, 0.0, 1.0)
    tiny = 2.0 * float(np.finfo(np.float64).eps)
    found = least_squares(
        residuals,
        inside,
        bounds=(0.0, 1.0),
        jac="3-point",
        diff_step=step / np.maximum(inside, step),
        x_scale="jac",
        ftol=tiny,
        xtol=tiny,
        gtol=tiny,
        max_nfev=max(1, max_evaluations // (2 * dimension + 1)),
    )
    last = calibration.evaluate(natural(found.x))
    if last.objective is None or last.objective > first.objective:
        last = first
    unit = (space.to_search(last.parameters) - low) / span
    ends = (unit <= 1e-9) | (unit >= 1.0 - 1e-9)
    assert last.objective is not None
    return Polished(
        parameters=last.parameters,
        objective=last.objective,
        start_objective=first.objective,
        evaluation=last,
        evaluations=count + 1,
        converged=bool(found.status > 0),
        at_bounds=tuple(n for n, end in zip(calibration.free_names, ends, strict=True) if end),
    )
