"""Intervals where the model is nonlinear: by likelihood where it can be evaluated, and no plain word otherwise."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares
from scipy.stats import t

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, analyse, from_evaluations
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.stored.findings import findings_of, join_findings
from geoswarm.solver.identifiability.stored.follow_ups import profile_problem, sensitivity_problem
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import WHITE, free, problem_of

X = np.linspace(0.0, 3.0, 12)
DECAY = "exp(-k * x)"
Y = np.exp(-0.7 * X) + 0.2 * np.cos(5.0 * np.arange(12.0))


def decay() -> Problem:
    return problem_of(DECAY, {"k": free(0.01, 20.0)}, Y, X, noise=WHITE)


def exact_interval() -> FloatArray:
    """Where the sum of squares of one parameter reaches S (1 + t^2 / (n - 1)), by root finding on the formula."""

    def squares(k: float) -> float:
        return float(np.sum((np.exp(-k * X) - Y) ** 2))

    rates = np.linspace(0.05, 5.0, 100_001)
    best = rates[np.argmin([squares(k) for k in rates])]
    limit = squares(best) * (1.0 + float(t.ppf(0.975, 11)) ** 2 / 11)
    return np.array(
        [brentq(lambda k: squares(k) - limit, *ends) for ends in ((0.01, best), (best, 20.0))], dtype=np.float64
    )


def linearised(problem: Problem, start: list[float]) -> tuple[Calibration, Linearisation]:
    calibration = Calibration(problem, 1)
    best = polish(calibration, np.array(start)).parameters
    return calibration, from_evaluations(calibration, *evaluate_differences(calibration, best))


def test_the_interval_by_likelihood_is_that_of_the_sum_of_squares() -> None:
    calibration, found = linearised(decay(), [0.7])
    expected = exact_interval()
    half = found.intervals[0] - found.optimum
    apart = np.abs(np.log((expected - found.optimum) / half)).max()
    assert apart > 0.2  # the linearised one is not
    by_likelihood = likelihood_intervals(calibration, found)
    assert by_likelihood.bases == ("profile",)
    np.testing.assert_allclose(by_likelihood.intervals[0], expected, rtol=0.02)
    np.testing.assert_array_equal(by_likelihood.standard_errors, found.standard_errors)
    # the part of the range that it spans follows the ends
    assert by_likelihood.unit_width("k") == pytest.approx(np.ptp(expected) / 19.99, rel=0.02)
    # how much the model is nonlinear was told from one run at each end
    assert by_likelihood.bending_of("k") == pytest.approx(apart, rel=0.5)


@pytest.mark.parametrize("noise", [0.02, 0.03])
def test_a_slightly_bent_interval_is_moved_by_its_two_runs(noise: float) -> None:
    """Exact ends: y = exp(-k x) + c, c by linear regression at each k, from the formula alone."""
    moved = 0
    for seed in range(8):
        y = np.exp(-0.7 * X) + 0.1 + noise * np.random.default_rng(seed).standard_normal(X.size)
        problem = problem_of(f"{DECAY} + c", {"k": free(0.01, 20.0), "c": free(-2.0, 2.0)}, y, X, noise=WHITE)
        calibration, found = linearised(problem, [0.7, 0.1])
        by_likelihood = likelihood_intervals(calibration, found)
        if by_likelihood.bases[0] != "moved":
            continue
        moved += 1
        assert 0.1 < by_likelihood.bending_of("k") <= 0.2
        assert not by_likelihood.needs_profile("k")
        expected = regressed_interval(y, float(found.optimum[0]))
        np.testing.assert_allclose(by_likelihood.intervals[0], expected, atol=0.1 * np.ptp(expected) / 2.0)
        apart = np.abs(by_likelihood.intervals[0] - expected).max()
        assert apart < 0.5 * np.abs(found.intervals[0] - expected).max()
        assert by_likelihood.interval_in_words("k") == "its 95 % interval by likelihood"
        assert by_likelihood.to_json()["parameters"]["k"]["interval_basis"] == "moved"
        assert by_likelihood.unit_width("k") == pytest.approx(np.ptp(by_likelihood.intervals[0]) / 19.99)
    assert moved >= 2


def regressed_interval(y: FloatArray, best: float) -> FloatArray:
    def squares(k: float) -> float:
        left = y - np.exp(-k * X)
        return float(np.sum((left - left.mean()) ** 2))

    limit = squares(best) * (1.0 + float(t.ppf(0.975, 10)) ** 2 / 10)
    return np.array([brentq(lambda k: squares(k) - limit, *ends) for ends in ((0.01, best), (best, 20.0))])


FORMULAS: list[tuple[str, dict[str, tuple[float, float, float]]]] = [
    ("a * exp(-k * x)", {"a": (0.01, 10.0, 1.0), "k": (0.01, 20.0, 0.7)}),
    ("a * x / (b + x)", {"a": (0.01, 20.0, 1.0), "b": (0.01, 20.0, 1.0)}),
    ("a * (1 - exp(-b * x))", {"a": (0.01, 20.0, 1.0), "b": (0.01, 20.0, 0.6)}),
    ("a * (x + 0.1)**b + c", {"a": (0.01, 10.0, 1.0), "b": (0.1, 4.0, 0.6), "c": (-3.0, 3.0, 0.2)}),
    ("a * cos(w * x + p)", {"a": (0.1, 5.0, 1.0), "w": (0.5, 4.0, 1.5), "p": (-2.0, 2.0, 0.3)}),
    ("a * x + 10 * (b - a**2) * exp(-x)", {"a": (-3.0, 3.0, 1.0), "b": (-3.0, 3.0, 1.0)}),
]


@pytest.mark.slow
def test_moved_ends_are_near_those_of_profiles() -> None:
    """Profiles by SciPy from the formula; misses in parts of the exact length on that side."""
    names = {"exp": np.exp, "cos": np.cos, "x": X}
    misses, unmoved = [], []
    for (formula, ranges), noise, seed in itertools.product(FORMULAS, (0.02, 0.05, 0.1), range(10)):
        curve = compile(formula, "formula", "eval")
        truth = {name: value for name, (_, _, value) in ranges.items()}
        errors = noise * np.random.default_rng(seed).standard_normal(X.size)
        y = eval(curve, names | truth) + errors  # noqa: S307  a formula of this file
        free_parameters = {name: free(low, high) for name, (low, high, _) in ranges.items()}
        calibration, found = linearised(problem_of(formula, free_parameters, y, X, noise=WHITE), [*truth.values()])
        by_likelihood = likelihood_intervals(calibration, found)

        def residuals(values: FloatArray, curve: Any = curve, y: FloatArray = y, ranges: Any = ranges) -> FloatArray:
            return np.asarray(eval(curve, names | dict(zip(ranges, values, strict=True))) - y)  # noqa: S307

        lowest = float(np.sum(residuals(found.optimum) ** 2))
        free_readings = X.size - len(ranges)
        limit = lowest * (1.0 + float(t.ppf(0.975, free_readings)) ** 2 / free_readings)
        for index, name in enumerate(ranges):
            if by_likelihood.basis(name) != "moved":
                continue
            for end, before in zip(by_likelihood.intervals[index], found.intervals[index], strict=True):
                bounds = np.array([(low, high) for low, high, _ in ranges.values()])
                exact = profile_end(residuals, found.optimum, index, float(before), limit, bounds)
                misses.append(abs(end - exact) / abs(exact - found.optimum[index]))
                unmoved.append(abs(before - exact) / abs(exact - found.optimum[index]))
    assert len(misses) > 50
    assert np.quantile(misses, 0.9) < 0.1
    assert np.median(misses) < 0.5 * np.median(unmoved)


def profile_end(
    residuals: Callable[[FloatArray], FloatArray],
    optimum: FloatArray,
    index: int,
    near: float,
    limit: float,
    bounds: FloatArray,
) -> float:
    """Where the sum of squares, the other parameters fitted, reaches the limit."""

    def above(value: float) -> float:
        def of_others(others: FloatArray) -> FloatArray:
            return residuals(np.insert(others, index, value))

        inside = np.delete(bounds, index, axis=0).T
        return 2.0 * float(least_squares(of_others, np.delete(optimum, index), bounds=inside).cost) - limit

    centre = float(optimum[index])
    far = float(np.clip(centre + 2.5 * (near - centre), *bounds[index]))
    return float(brentq(above, centre, far, rtol=1e-8))


def test_a_line_keeps_its_linearised_interval() -> None:
    y = 1.0 - 0.2 * X + 0.2 * np.cos(5.0 * np.arange(12.0))
    problem = problem_of("a + k * x", {"a": free(-5.0, 5.0), "k": free(-5.0, 5.0)}, y, X, noise=WHITE)
    calibration, found = linearised(problem, [1.0, 0.0])
    by_likelihood = likelihood_intervals(calibration, found)
    assert by_likelihood.bases == ("linearised", "linearised")
    np.testing.assert_allclose(by_likelihood.bending, 0.0, atol=1e-6)
    np.testing.assert_array_equal(by_likelihood.intervals, found.intervals)


def test_without_a_profile_a_bent_interval_is_no_plain_one() -> None:
    problem = decay()
    follow_up = sensitivity_problem(problem, np.array([0.7]), seed=1, polish=True)
    found = findings_of(follow_up, 1, [record.evaluation for record in calibrate(follow_up).history])
    assert found.linearisation is not None
    assert found.linearisation.needs_profile("k")
    assert found.linearisation.to_json()["parameters"]["k"]["needs_profile"]
    assert found.objective is not None
    samples = Samples.from_arrays(problem, found.linearisation.optimum[None], np.array([found.objective]))
    verdict = analyse(Calibration(problem, 1), samples, linearisation=found.linearisation).verdict("k")
    assert verdict.kind == "undecided"
    assert "the model is nonlinear there" in verdict.sentence
    assert [remedy.kind for remedy in verdict.remedies] == ["profile"]
    # a profile of the same job takes its place
    asked = profile_problem(problem, found.linearisation, seed=1)
    profiles = findings_of(asked, 1, [record.evaluation for record in calibrate(asked).history])
    joined = join_findings([found, profiles]).linearisation
    assert joined is not None
    assert joined.bases == ("profile",)
    np.testing.assert_allclose(joined.intervals[0], exact_interval(), rtol=0.02)
    verdict = analyse(Calibration(problem, 1), samples, linearisation=joined).verdict("k")
    assert verdict.kind == "identified"
    assert "interval by likelihood" in verdict.sentence


def test_intervals_that_nobody_looked_at_say_so() -> None:
    calibration, found = linearised(decay(), [0.7])
    assert np.isnan(found.bending).all()
    assert found.interval_in_words("k") == "its 95 % interval by linearisation"
    assert likelihood_intervals(calibration, found).interval_in_words("k") == "its 95 % interval by likelihood"
