"""Repeated experiments with a known truth: how often the band of a prediction holds it.

Errors are independent, and the problem says so: else so few readings widen the band for a correlation that they cannot
exclude.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability.noise import problem_noise
from geoswarm.solver.identifiability.prediction.bands import Prediction
from geoswarm.solver.identifiability.prediction.draws import basins_of, draw_around
from geoswarm.solver.identifiability.prediction.question import predict_problem
from geoswarm.solver.identifiability.stored.findings import findings_of
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import WHITE, free, linearised, problem_of

__all__ = ["CASES", "Case", "coverage", "predicted"]


@dataclass(frozen=True)
class Case:
    """A model with its truth, where it was measured, and what is predicted of it.

    ``curve`` and ``other`` are the same expressions once more, in NumPy: the fit and the truth are not our own code's.
    """

    expression: str
    curve: Callable[[FloatArray, FloatArray], FloatArray]
    parameters: dict[str, Any]
    truth: tuple[float, ...]
    x: FloatArray
    sigma: float
    predicted: str
    other: Callable[[FloatArray, FloatArray], FloatArray]
    at: FloatArray
    known: bool = False


CASES = {
    "linear, a later time": Case(
        "a + b * x",
        lambda p, x: p[0] + p[1] * x,
        {"a": free(-10.0, 10.0), "b": free(-10.0, 10.0)},
        (1.0, 2.0),
        np.linspace(0.0, 1.0, 8),
        0.2,
        "a + b * x",
        lambda p, x: p[0] + p[1] * x,
        np.array([1.5, 3.0, 10.0]),
    ),
    "linear, known error": Case(
        "a + b * x",
        lambda p, x: p[0] + p[1] * x,
        {"a": free(-10.0, 10.0), "b": free(-10.0, 10.0)},
        (1.0, 2.0),
        np.linspace(0.0, 1.0, 8),
        0.2,
        "a - 3 * b + x",
        lambda p, x: p[0] - 3.0 * p[1] + x,
        np.array([0.0, 5.0]),
        known=True,
    ),
    "mildly curved, a later time": Case(
        "a * (1 - exp(-b * x))",
        lambda p, x: p[0] * (1.0 - np.exp(-p[1] * x)),
        {"a": free(1.0, 50.0, "log"), "b": free(0.05, 5.0, "log")},
        (10.0, 0.5),
        np.linspace(0.3, 3.0, 12),
        0.1,
        "a * (1 - exp(-b * x))",
        lambda p, x: p[0] * (1.0 - np.exp(-p[1] * x)),
        np.array([5.0, 10.0, 20.0]),
    ),
    "correlated parameters, another model": Case(
        "a * x**b",
        lambda p, x: p[0] * x ** p[1],
        {"a": free(0.1, 10.0), "b": free(0.1, 3.0)},
        (1.0, 1.2),
        np.linspace(6.0, 9.0, 15),  # a and b are correlated with -0.99
        0.1,
        "a * x**b / (1 + a)",
        lambda p, x: p[0] * x ** p[1] / (1.0 + p[0]),
        np.array([4.0, 12.0]),
    ),
}


def predicted(problem: Problem, best: FloatArray, case: Case, runs: int, level: float, seed: int) -> Prediction:
    """The band of a case with the sample drawn around a fit."""
    calibration = Calibration(problem, 1)
    objective = calibration.evaluate(best).objective
    assert objective is not None
    basins = basins_of(calibration, linearised(problem, best.tolist()), objective, (), (), problem_noise(problem))
    sample = draw_around(calibration, basins, runs, seed)
    other = {
        "forward_model": {"kind": "formula", "series": {"s": case.predicted}},
        "observations": [{"series": "s", "points": {"x": case.at.tolist()}}],
    }
    question = predict_problem(problem, other, sample, seed=seed, level=level)
    result = calibrate(question)
    (found,) = findings_of(question, seed, [record.evaluation for record in result.history]).predictions
    return found


def coverage(case: Case, repeats: int, *, runs: int = 100, level: float = 0.9, seed: int = 0) -> FloatArray:
    """Share of repeats whose band holds the truth, at each predicted x."""
    random = np.random.default_rng(seed)
    truth = np.array(case.truth)
    wanted = case.other(truth, case.at)
    lower = np.array([p["lower"] for p in case.parameters.values()])
    upper = np.array([p["upper"] for p in case.parameters.values()])
    held = np.zeros(case.at.size)
    for number in range(repeats):
        y = case.curve(truth, case.x) + case.sigma * random.standard_normal(case.x.size)
        fit = least_squares(
            lambda p, y=y: case.curve(p, case.x) - y,
            truth,
            bounds=(lower, upper),
            x_scale=truth,
            xtol=1e-12,
            ftol=1e-12,
        )
        points = {"x": case.x.tolist(), "y": y.tolist()}
        error = {"error": case.sigma} if case.known else {}
        observed = [{"series": "y", "points": points, **error}]
        problem = problem_of(case.expression, case.parameters, y, case.x, observations=observed, noise=WHITE)
        found = predicted(problem, fit.x, case, runs, level, number)["s"]
        held += (found.lower <= wanted) & (wanted <= found.upper)
    return np.asarray(held / repeats)
