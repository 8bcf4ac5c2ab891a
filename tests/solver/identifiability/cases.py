"""Small problems with known statistics, shared by the tests."""

from __future__ import annotations

from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, design, from_evaluations
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate

__all__ = ["WHITE", "X", "free", "linearised", "problem_of", "sampled"]

X = np.linspace(0.5, 4.0, 20)
WHITE = {"kind": "white"}
"""Noise of which textbooks speak: intervals make no allowance for correlation."""


def free(lower: float = 0.1, upper: float = 10.0, scale: str = "linear") -> dict[str, Any]:
    return {"lower": lower, "upper": upper, "scale": scale}


def problem_of(
    expression: str, parameters: dict[str, Any], y: FloatArray, x: FloatArray = X, **changes: Any
) -> Problem:
    """A formula with one series ``y``."""
    return parse_problem(
        {
            "forward_model": {"kind": "formula", "series": {"y": expression}},
            "parameters": parameters,
            "observations": [{"series": "y", "points": {"x": x.tolist(), "y": y.tolist()}}],
            "stopping": {"max_evaluations": 200},
            "seed": 5,
        }
        | changes
    )


def linearised(problem: Problem, optimum: list[float], **options: Any) -> Linearisation:
    calibration = Calibration(problem, 1)
    plan = design(calibration, np.array(optimum))
    return from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions], **options)


def sampled(expression: str, parameters: dict[str, Any], y: FloatArray, samples: int = 2000) -> tuple[Problem, Samples]:
    """A Monte Carlo sampling of a formula."""
    method = {"kind": "monte_carlo", "samples": samples, "batch": 1000}
    problem = problem_of(expression, parameters, y, method=method, stopping={})
    return problem, Samples.from_result(problem, calibrate(problem))
