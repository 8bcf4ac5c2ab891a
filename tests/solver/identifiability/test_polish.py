"""Polishing ends at the least-squares solution."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.optimum.polish import polish
from tests.solver.identifiability.cases import X, free, problem_of

Y = 6.0 * X + 1.0 + np.random.default_rng(1).normal(0.0, 0.1, X.size)


def test_a_line_is_found_from_anywhere() -> None:
    slope, intercept = np.polyfit(X, Y, 1)
    calibration = Calibration(problem_of("a * x + b", {"a": free(), "b": free(scale="log")}, Y), 1)
    found = polish(calibration, np.array([0.5, 9.0]))
    np.testing.assert_allclose(found.parameters, [slope, intercept], rtol=1e-7)
    assert found.converged
    assert found.at_bounds == ()
    assert found.objective < found.start_objective
    assert found.evaluation.objective == found.objective


def test_bounds_and_constraints_hold() -> None:
    document = problem_of("a * x + b", {"a": free(0.1, 5.0), "b": free()}, Y)
    found = polish(Calibration(document, 1), np.array([2.0, 2.0]))
    assert found.at_bounds == ("a",)
    np.testing.assert_allclose(found.parameters[0], 5.0, rtol=1e-9)
    tied = problem_of("a * x + b", {"a": free(), "b": free()}, Y, constraints=["a > 2 * b"])
    kept = polish(Calibration(tied, 1), np.array([9.0, 2.0]))
    assert kept.parameters[0] > 2 * kept.parameters[1]
    assert kept.objective <= kept.start_objective


def test_a_failing_start_is_an_error() -> None:
    problem = problem_of("a * x / (b - b)", {"a": free(), "b": free()}, Y)
    with pytest.raises(StatisticsError, match="start of polishing fails"):
        polish(Calibration(problem, 1), np.array([1.0, 1.0]))
