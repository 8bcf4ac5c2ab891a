"""Problems with a known covariance: standard errors within 5 %, 95 % intervals that cover 93 to 97 %."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import design, from_evaluations
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import parse_problem

X = np.linspace(0.0, 4.0, 15)
NOISE = 0.05
LINEAR = "a + b * x"
CURVED = "a * (1 - exp(-b * x))"  # mildly non-linear at this noise
TRUTH = {LINEAR: (1.0, 0.5), CURVED: (2.0, 0.8)}


def derivatives(expression: str) -> FloatArray:
    """Of the model at the truth, shape (m, 2)."""
    a, b = TRUTH[expression]
    if expression == LINEAR:
        return np.stack([np.ones_like(X), X], axis=1)
    return np.stack([1.0 - np.exp(-b * X), a * X * np.exp(-b * X)], axis=1)


def exact(expression: str) -> FloatArray:
    a, b = TRUTH[expression]
    return a + b * X if expression == LINEAR else a * (1.0 - np.exp(-b * X))


def document(expression: str, y: FloatArray, weights: FloatArray | None = None) -> dict[str, Any]:
    points: dict[str, Any] = {"x": X.tolist(), "y": y.tolist()}
    return {
        "forward_model": {"kind": "formula", "series": {"y": expression}},
        "parameters": {"a": {"lower": 0.1, "upper": 5.0}, "b": {"lower": 0.05, "upper": 5.0, "scale": "log"}},
        "observations": [
            {"series": "y", "points": points if weights is None else points | {"weight": weights.tolist()}}
        ],
        "stopping": {"max_evaluations": 10},
    }


def repeat(
    expression: str, times: int, *, known: bool = False, weights: FloatArray | None = None
) -> tuple[Any, Any, Any]:
    """Estimates (times, 2), standard errors (times, 2) and intervals (times, 2, 2) of repeated experiments."""
    random = np.random.default_rng(2024)
    deviation = NOISE if weights is None else NOISE / np.sqrt(weights)
    estimates, errors, intervals = [], [], []
    for _ in range(times):
        y = exact(expression) + random.normal(0.0, deviation, X.size)
        calibration = Calibration(parse_problem(document(expression, y, weights)), 1)
        found = polish(calibration, np.array(TRUTH[expression])).parameters
        plan = design(calibration, found, step=2e-3)
        linearised = from_evaluations(
            calibration, plan, [calibration.evaluate(x) for x in plan.positions], noise=NOISE if known else None
        )
        estimates.append(found)
        errors.append(linearised.standard_errors)
        intervals.append(linearised.intervals)
    return np.array(estimates), np.array(errors), np.array(intervals)


def check_coverage(expression: str, times: int, low: float, high: float, **options: Any) -> None:
    _, errors, intervals = repeat(expression, times, **options)
    weights = options.get("weights")
    jacobian = derivatives(expression) * (1.0 if weights is None else np.sqrt(weights)[:, None])
    expected = NOISE * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(np.sqrt(np.mean(errors**2, axis=0)), expected, rtol=0.05)
    truth = np.array(TRUTH[expression])
    covered = ((intervals[:, :, 0] <= truth) & (truth <= intervals[:, :, 1])).mean(axis=0)
    assert (covered >= low).all(), covered
    assert (covered <= high).all(), covered


@pytest.mark.parametrize("expression", [LINEAR, CURVED])
@pytest.mark.slow
def test_coverage_in_150_repeats(expression: str) -> None:
    check_coverage(expression, 150, 0.90, 0.995)


@pytest.mark.slow
@pytest.mark.parametrize("expression", [LINEAR, CURVED])
def test_coverage_in_1000_repeats(expression: str) -> None:
    check_coverage(expression, 1000, 0.93, 0.97)


@pytest.mark.slow
@pytest.mark.parametrize("expression", [LINEAR, CURVED])
def test_coverage_with_known_noise_and_graded_points(expression: str) -> None:
    weights = np.where(np.arange(X.size) % 3 == 0, 4.0, 0.5)
    check_coverage(expression, 1000, 0.93, 0.97, known=True, weights=weights)


@pytest.mark.slow
def test_coverage_with_two_series_of_different_noise() -> None:
    """Weights that do not follow the noise (the published w_g = 1) still give honest intervals."""
    random = np.random.default_rng(7)
    few, many = np.linspace(0.0, 4.0, 12), np.linspace(0.0, 4.0, 40)
    document: dict[str, Any] = {
        "forward_model": {"kind": "formula", "series": {"level": "a + b * x", "rate": "10 * b * x - a"}},
        "parameters": {"a": {"lower": 0.1, "upper": 5.0}, "b": {"lower": 0.05, "upper": 5.0}},
        "stopping": {"max_evaluations": 10},
    }
    covered = []
    for _ in range(1000):
        level = 1.0 + 0.5 * few + random.normal(0.0, 0.05, few.size)
        rate = 5.0 * many - 1.0 + random.normal(0.0, 1.0, many.size)
        document["observations"] = [
            {"series": "level", "points": {"x": few.tolist(), "y": level.tolist()}},
            {"series": "rate", "points": {"x": many.tolist(), "y": rate.tolist()}},
        ]
        calibration = Calibration(parse_problem(document), 1)
        found = polish(calibration, np.array([1.0, 0.5])).parameters
        plan = design(calibration, found)
        intervals = from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions]).intervals
        covered.append((intervals[:, 0] <= [1.0, 0.5]) & (intervals[:, 1] >= [1.0, 0.5]))
    share = np.mean(covered, axis=0)
    assert (share >= 0.93).all(), share
    # the usual intervals hold 96.8 and 93.9 % in these draws; those that are widened by chance, as a series looks
    # correlated or uneven (3 % of the draws), add up to 0.3 %
    assert (share <= 0.975).all(), share
