"""Intervals where the model is nonlinear: by likelihood where it can be evaluated, and no plain word otherwise."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
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
from tests.solver.identifiability.cases import free, problem_of

X = np.linspace(0.0, 3.0, 12)
DECAY = "exp(-k * x)"
Y = np.exp(-0.7 * X) + 0.2 * np.cos(5.0 * np.arange(12.0))


def decay() -> Problem:
    return problem_of(DECAY, {"k": free(0.01, 20.0)}, Y, X)


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


def test_a_line_keeps_its_linearised_interval() -> None:
    y = 1.0 - 0.2 * X + 0.2 * np.cos(5.0 * np.arange(12.0))
    problem = problem_of("a + k * x", {"a": free(-5.0, 5.0), "k": free(-5.0, 5.0)}, y, X)
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
    assert found.linearisation.bent("k")
    assert found.linearisation.to_json()["parameters"]["k"]["bent"]
    assert found.objective is not None
    samples = Samples.from_arrays(problem, found.linearisation.optimum[None], np.array([found.objective]))
    verdict = analyse(Calibration(problem, 1), samples, linearisation=found.linearisation).verdict("k")
    assert verdict.kind == "undecided"
    assert "the model is nonlinear there" in verdict.sentence
    assert "geoswarm profile" in verdict.sentence
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
    assert found.interval_in_words("k") == "its 95% interval by linearisation"
    assert likelihood_intervals(calibration, found).interval_in_words("k") == "its 95% interval by likelihood"
