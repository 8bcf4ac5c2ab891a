"""Polishing ends at the least-squares solution."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import parse_problem
from tests.solver.identifiability.cases import X, free, problem_of
from tests.verification.nist.archive import archive_set

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


def test_no_slope_is_left_by_its_derivatives_in_closed_form() -> None:
    """J'r = 0 with J by hand; the length of J'r against that of its parts is the cosine between r and each column."""
    y = 5.0 * (1.0 - np.exp(-0.8 * X)) + 0.1 * np.sin(5.0 * X)
    calibration = Calibration(problem_of("a * (1 - exp(-b * x))", {"a": free(), "b": free(0.05, 5.0, "log")}, y), 1)
    found = polish(calibration, np.array([9.0, 0.06]))
    assert found.converged
    a, b = found.parameters
    residuals = a * (1.0 - np.exp(-b * X)) - y
    columns = np.stack([1.0 - np.exp(-b * X), a * X * np.exp(-b * X)])
    cosines = columns @ residuals / np.linalg.norm(columns, axis=1) / np.linalg.norm(residuals)
    assert np.abs(cosines).max() < 1e-8


@pytest.mark.parametrize("name", ["MGH10", "Rat43", "Lanczos3", "Bennett5"])
def test_curved_valleys_end_at_the_certified_values(name: str) -> None:
    """From three standard deviations away, along valleys where a trust region takes a thousand runs, or stops."""
    case = archive_set(name)
    start = case.certified + 3.0 * case.deviations * np.random.default_rng(0).standard_normal(case.certified.size)
    calibration = Calibration(parse_problem(case.document()), 1)
    found = polish(calibration, np.clip(start, calibration.space.lower, calibration.space.upper))
    assert found.converged
    np.testing.assert_allclose(found.parameters, case.certified, rtol=1e-6)
    np.testing.assert_allclose(found.objective * len(case.x), case.residual_sum_of_squares, rtol=1e-9)


def test_it_ends_with_its_evaluations() -> None:
    calibration = Calibration(problem_of("a * exp(-b * x) + x", {"a": free(), "b": free()}, Y), 1)
    found = polish(calibration, np.array([0.5, 9.0]), max_evaluations=8)
    assert not found.converged
    assert found.evaluations <= 8
    assert found.objective <= found.start_objective


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
