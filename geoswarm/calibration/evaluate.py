"""One forward calculation from Python."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.calibration.functions import refuse_while_imported
from geoswarm.calibration.problems import Model, Observations, options_of, problem_of
from geoswarm.calibration.sections import free
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.given import given_mistake, values_from, without_value

__all__ = ["Evaluated", "evaluate"]


@dataclass(frozen=True, slots=True)
class Evaluated:
    """One forward calculation.

    Parameters
    ----------
    parameters
        Values of all parameters by name.
    objective, misfits
        f and f'_g of every observed series, in base units squared.
    x, responses
        Observed points and calculated values by series, each of shape (m_g,), base units (kN, m, day, degree).

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> found = gs.evaluate(line, observations=gs.observed([0, 1], [1, 3]), a=1, b=2)
    >>> found.parameters, found.misfits
    ({'a': 1.0, 'b': 2.0}, {'y': 0.0})
    """

    parameters: dict[str, float]
    objective: float
    misfits: dict[str, float]
    x: dict[str, FloatArray]
    responses: dict[str, FloatArray]


def evaluate(model: Model, /, *, observations: Observations | None = None, **values: float) -> Evaluated:
    """Make one forward calculation with given parameters, in this process.

    Parameters
    ----------
    model
        A problem, or a function together with ``observations``.
    observations
        As for :func:`geoswarm.calibrate`; needed for a function.
    values
        Parameters by name. A free one of a problem that is not given takes its ``initial`` value. Values outside the
        bounds are accepted: the bounds apply to the search only.

    Raises
    ------
    ProblemError
        A parameter is unknown, linked, missing, or not a finite number.
    ForwardError
        The calculation failed; ``reason`` says why.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> found = gs.evaluate(line, observations=gs.observed([0, 1, 2], [1, 3, 6]), a=1, b=2)
    >>> print(f"{found.objective:.4f}")
    0.3333
    >>> found.responses["y"].tolist()
    [1.0, 3.0, 5.0]
    """
    refuse_while_imported("geoswarm.evaluate")
    numbers = {name: _number(name, value) for name, value in values.items()}
    given: dict[str, Any] = options_of(observations=observations)
    if callable(model) and not isinstance(model, Problem | Mapping):
        # The bounds are no one's: a problem has some.
        given["parameters"] = {name: free(v - abs(v) - 1.0, v + abs(v) + 1.0) for name, v in numbers.items()}
    problem, _ = problem_of(model, given)
    wrong = [(name, mistake) for name in numbers if (mistake := given_mistake(problem, name))]
    missing = without_value(problem, numbers)
    if wrong or missing:
        issues = [Issue(name, mistake) for name, mistake in wrong]
        raise ProblemError(issues + [Issue(name, "has no initial value: give it one") for name in missing])
    known = values_from(problem, numbers)
    found = Calibration(problem, problem.seed or 0).evaluate_values(known)
    if found.reason is not None or found.objective is None:
        raise RunFailedError(found.reason or "bad_output", found.message or "the calculation failed")
    return Evaluated(
        known,
        found.objective,
        found.misfits,
        {o.series: np.array(o.x) for o in problem.observations},
        found.responses,
    )


def _number(name: str, value: Any) -> float:
    try:
        number = math.nan if isinstance(value, bool | str) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise ProblemError([Issue(name, f"{str(value)[:60]!r} is not a finite number")])
    return number
