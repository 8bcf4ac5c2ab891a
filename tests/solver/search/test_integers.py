"""Parameters that take whole numbers only."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate

X = np.linspace(0.0, 2.0, 9)
METHODS: dict[str, dict[str, Any]] = {
    "accelerated": {"kind": "particle_swarm"},
    "textbook": {"kind": "particle_swarm", "acceleration": "none"},
    "absorbing": {"kind": "particle_swarm", "acceleration": "none", "boundary": "absorb"},
    "random": {"kind": "monte_carlo", "samples": 200},
    "latin hypercube": {"kind": "monte_carlo", "samples": 200, "sampling": "latin_hypercube"},
    "sobol": {"kind": "monte_carlo", "samples": 200, "sampling": "sobol"},
}


def power(method: dict[str, Any], **changes: Any) -> Problem:
    """``a x^n`` with a = 2 and n = 3; n is a whole number from 1 to 6."""
    document = {
        "forward_model": {"kind": "formula", "series": {"y": "a * x**n"}},
        "parameters": {"a": {"lower": 0.1, "upper": 10.0}, "n": {"lower": 1, "upper": 6, "integer": True}},
        "observations": [{"series": "y", "points": {"x": X.tolist(), "y": (2.0 * X**3).tolist()}}],
        "method": method,
        "stopping": {"max_evaluations": 200},
    }
    return parse_problem(document | changes)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("scale", ["linear", "log"])
def test_only_whole_numbers_inside_the_bounds_are_run(method: str, scale: str) -> None:
    parameters = {"a": {"value": 2.0}, "n": {"lower": 1, "upper": 6, "integer": True, "scale": scale}}
    parameters["a"] = {"lower": 0.1, "upper": 10.0}
    result = calibrate(power(METHODS[method], parameters=parameters), seed=1)
    values = [float(record.evaluation.parameters[1]) for record in result.history]
    assert set(values) <= {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}


def test_a_sampling_gives_every_whole_number_the_same_chance() -> None:
    method = {"kind": "monte_carlo", "samples": 6000, "sampling": "latin_hypercube", "batch": 1000}
    history = calibrate(power(method, stopping={}), seed=1).history
    counts = Counter(float(record.evaluation.parameters[1]) for record in history)
    assert counts == {float(n): 1000 for n in range(1, 7)}


@pytest.mark.parametrize(("method", "least"), [("accelerated", 5), ("textbook", 3)])
def test_both_swarms_find_the_exponent(method: str, least: int) -> None:
    results = [calibrate(power(METHODS[method]), seed=seed) for seed in range(5)]
    found = [result.parameters["n"] for result in results if result.parameters is not None]
    assert found.count(3.0) >= least
    if method == "accelerated":
        assert max(result.objective or 0.0 for result in results) < 1e-8


def test_a_space_of_few_points_is_run_once_through() -> None:
    parameters = {"a": {"lower": 1, "upper": 5, "integer": True}, "n": {"lower": 1, "upper": 4, "integer": True}}
    result = calibrate(power(METHODS["accelerated"], parameters=parameters, stopping={"max_evaluations": 60}), seed=1)
    run = [tuple(r.evaluation.parameters) for r in result.history if r.evaluation.seconds > 0.0]
    assert len(run) == len(set(run)) == 20
    assert result.evaluations == 60
    assert result.objective == 0.0


def test_an_integer_parameter_needs_whole_bounds() -> None:
    broken = {"n": {"lower": 0.5, "upper": 6, "initial": 2.5, "integer": True}, "a": {"value": 1.0}}
    with pytest.raises(ProblemError) as caught:
        power(METHODS["textbook"], parameters=broken)
    messages = {issue.path: issue.message for issue in caught.value.issues}
    assert messages["parameters.n.lower"] == "must be a whole number, got 0.5"
    assert messages["parameters.n.initial"] == "must be a whole number, got 2.5"


def test_the_document_says_so() -> None:
    problem = power(METHODS["textbook"])
    assert problem.document()["parameters"]["n"]["integer"] is True
    assert parse_problem(problem.document()) == problem


def test_an_estimate_of_a_whole_number_is_particle_0() -> None:
    parameters = {"a": {"lower": 0.1, "upper": 10.0, "initial": 4.0}, "n": {"lower": 1, "upper": 6, "integer": True}}
    parameters["n"]["initial"] = 5
    for method in ("accelerated", "textbook"):
        first = Course(Calibration(power(METHODS[method], parameters=parameters), 1)).start().positions[0]
        np.testing.assert_allclose(first, [4.0, 5.0], rtol=1e-12)
