"""Small problems for the engine, with answers that are known."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.service.job_service import JobService

__all__ = ["History", "expected_history", "line", "predicted_tests", "recorded_history"]

History = list[tuple[int, int, tuple[float, ...], float | None, dict[str, float], dict[str, list[float]]]]


def line(**changes: Any) -> Problem:
    """A straight line y = 2 x + 1 through four points; ``changes`` replace sections of the document."""
    document: dict[str, Any] = {
        "name": "line",
        "forward_model": {"kind": "formula", "series": {"y": "a * x + b"}},
        "parameters": {"a": {"lower": 0, "upper": 5}, "b": {"lower": -5, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2, 3], "y": [1, 3, 5, 7]}}],
        "method": {"kind": "particle_swarm", "particles": 6, "acceleration": "none"},
        "stopping": {"max_evaluations": 120},
        "answer": {"max_evaluations": "off"},
        "seed": 7,
    }
    return parse_problem(document | changes)


def predicted_tests(fragile: str) -> Problem:
    """A prediction of two tests by twelve draws, one of them by an expression that may fail."""
    formulas = {"sound": "a * x + b", "fragile": fragile}
    draws = [0.1 * k for k in range(12)]
    return line(
        forward_model={
            "kind": "combined",
            "parts": {name: {"kind": "formula", "series": {"y": formula}} for name, formula in formulas.items()},
        },
        observations=[{"series": f"{name}.y", "points": {"x": [1, 2], "y": [0, 0]}} for name in formulas],
        method={
            "kind": "predict",
            "points": {"a": [1.0, *draws], "b": [0.0, *draws]},
            "shares": [1.0],
            "weights": [1.0] * 12,
            "basins": [0] * 12,
            "noise_factors": [1.0] * 12,
            "unmeasured": [f"{name}.y" for name in formulas],
        },
        stopping={},
    )


def expected_history(problem: Problem) -> History:
    """Every evaluation of the in-process run, in order."""
    return [
        (
            record.generation,
            record.particle,
            tuple(record.evaluation.parameters.tolist()),
            record.evaluation.objective,
            record.evaluation.misfits,
            {series: values.tolist() for series, values in record.evaluation.responses.items()},
        )
        for record in calibrate(problem).history
    ]


def recorded_history(service: JobService, job_id: str) -> History:
    """Every evaluation that the engine has stored, in order."""
    return [
        (
            view.generation,
            view.particle,
            tuple(view.parameters.values()),
            view.objective,
            view.misfits,
            {series: curve.y for series, curve in (view.responses or {}).items()},
        )
        for view in service.iterate_evaluations(job_id, responses=True)
    ]


def course(problem: Problem) -> Course:
    """The problem made ready, with its own seed."""
    assert problem.seed is not None
    return Course(Calibration(problem, problem.seed))
