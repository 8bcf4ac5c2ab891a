from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.check import check_problem
from geoswarm.solver.runs.local import calibrate


def line(**changes: Any) -> dict[str, Any]:
    document: dict[str, Any] = {
        "name": "line",
        "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
        "parameters": {"a": {"lower": 1, "upper": 100, "scale": "log"}, "b": {"lower": 0, "upper": 4}},
        "observations": [{"series": "y", "points": {"x": [0, 1], "y": [10, 12]}}],
        "method": {"kind": "particle_swarm", "particles": 6},
        "stopping": {"max_evaluations": 60},
        "seed": 7,
    }
    return document | changes


def check(**changes: Any) -> Any:
    return check_problem(parse_problem(line(**changes)))


def test_numba_and_scipy_are_not_loaded_before_something_needs_them() -> None:
    code = "import sys, geoswarm.solver.runs.check; print(sorted({'numba', 'scipy'} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_test_run_is_made_in_the_middle_of_the_search_coordinates() -> None:
    report = check()
    assert report.test_run.parameters == pytest.approx({"a": 10.0, "b": 2.0}, rel=1e-12)
    assert report.test_run.objective == pytest.approx(0.0, abs=1e-20)
    assert report.test_run.misfits == {"y": report.test_run.objective}
    assert (report.data_points, report.free_parameters) == (2, ("a", "b"))


def test_initial_values_are_taken() -> None:
    parameters = {"a": {"lower": 1, "upper": 100, "initial": 5}, "b": {"lower": 0, "upper": 4}}
    assert check(parameters=parameters).test_run.parameters == {"a": 5.0, "b": 2.0}


def test_a_middle_that_breaks_a_constraint_gives_way_to_a_proposal() -> None:
    run = check(constraints=["a < b"]).test_run
    assert run.parameters["a"] < run.parameters["b"]
    assert run.state == "finished"


def test_linked_and_fixed_parameters_are_reported() -> None:
    parameters = {"a": {"expression": "2 * b"}, "b": {"lower": 0, "upper": 4}, "spare": {"value": 3}}
    assert check(parameters=parameters).test_run.parameters == {"a": 4.0, "b": 2.0, "spare": 3.0}


def test_a_failed_run_is_reported() -> None:
    run = check(forward_model={"kind": "formula", "series": {"y": {"expression": "a * b + x / 0"}}}).test_run
    assert (run.state, run.objective, run.misfits, run.reason) == ("failed", None, {}, "not_finite")
    assert run.message


@pytest.mark.parametrize(
    ("method", "stopping", "planned", "answer"),
    [
        ("particle_swarm", {"max_evaluations": 60}, 60, 15),
        ("particle_swarm", {"max_evaluations": 400}, 400, 30),
        ("particle_swarm", {"target_objective": 1e-6}, None, None),
        ("monte_carlo", {}, 500, 0),
        ("monte_carlo", {"max_evaluations": 100}, 100, 0),
    ],
)
def test_planned_evaluations(method: str, stopping: dict[str, float], planned: int | None, answer: int | None) -> None:
    section = {"kind": "monte_carlo", "samples": 500} if method == "monte_carlo" else {"kind": method, "particles": 6}
    report = check(method=section, stopping=stopping)
    assert (report.planned_evaluations, report.left_to_answer) == (planned, answer)
    if planned is None:
        assert report.estimated_seconds is None
    elif method == "monte_carlo":
        assert report.estimated_seconds == pytest.approx(planned * report.test_run.seconds, rel=1e-12)
    else:
        assert report.estimated_seconds is not None
        assert report.estimated_seconds > planned * report.test_run.seconds  # the search itself takes time, too


def test_the_estimate_is_never_above_the_time_limit() -> None:
    report = check(stopping={"max_evaluations": 4 * 10**8, "max_seconds": 0.5})
    assert report.estimated_seconds == 0.5
    assert check(stopping={"max_seconds": 30}).estimated_seconds == 30.0


def test_a_search_leaves_what_the_check_has_said() -> None:
    changes = {"method": {"kind": "particle_swarm", "particles": 5, "acceleration": "none"}}
    answer = calibrate(parse_problem(line(**changes))).answer
    assert answer is not None
    assert 60 - answer.evaluations == check(**changes).left_to_answer == 15
