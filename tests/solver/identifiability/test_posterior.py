"""Posterior samples against the exact posterior of a line, and the check of the response surface."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.stored.posterior import sample_posterior
from geoswarm.solver.identifiability.stored.surface import fit_surface
from geoswarm.solver.problem import parse_problem
from tests.solver.identifiability.cases import X, free, linearised, problem_of, sampled

Y = 3.0 * X + 2.0 + np.random.default_rng(1).normal(0.0, 0.3, X.size)


@pytest.mark.parametrize("noise", [None, 0.3])
def test_a_line_has_students_or_the_normal_posterior(noise: float | None) -> None:
    parameters = {"a": free(1.5, 4.5), "b": free(-1.0, 5.0)}
    problem, samples = sampled("a * x + b", parameters, Y, 500)
    found = sample_posterior(Calibration(problem, 1), samples, noise=noise, seed=2)
    optimum = np.polyfit(X, Y, 1)
    exact = linearised(problem_of("a * x + b", parameters, Y), optimum.tolist(), noise=noise)
    assert found.trusted, found.warnings
    assert found.surface_error < 1e-3
    np.testing.assert_allclose(found.parameters.mean(axis=0), optimum, atol=0.15 * exact.standard_errors.max())
    widths, expected = np.ptp(found.intervals, axis=1), np.ptp(exact.intervals, axis=1)
    np.testing.assert_allclose(widths, expected, rtol=0.12)
    np.testing.assert_allclose(found.correlation[0, 1], exact.correlation()[0, 1], atol=0.05)
    json.dumps(found.to_json(), allow_nan=False)


def test_errors_that_are_taken_as_independent_are_named() -> None:
    parameters = {"a": free(1.5, 4.5), "b": free(-1.0, 5.0)}
    problem, samples = sampled("a * x + b", parameters, Y, 500)
    said = "the errors of the readings of y are taken as independent"
    found = sample_posterior(Calibration(problem, 1), samples, steps=100)
    assert any(said in one for one in found.warnings)
    white = parse_problem(problem.document() | {"noise": {"kind": "white", "series": ["y"]}})
    assert not any(said in one for one in sample_posterior(Calibration(white, 1), samples, steps=100).warnings)


def test_no_interval_where_the_sample_reaches_the_bounds() -> None:
    problem, samples = sampled("a * b * x", {"a": free(0.5, 4.0), "b": free(0.5, 4.0)}, 3.0 * X + 0.1 * np.sin(X), 500)
    found = sample_posterior(Calibration(problem, 1), samples, noise=1.0, steps=2000)
    assert np.isnan(found.intervals).all()
    assert any("edge of the sampled region" in warning for warning in found.warnings)


def test_a_surface_that_does_not_hold_is_reported() -> None:
    problem, samples = sampled("sin(40 * a) * x + sin(40 * b)", {"a": free(), "b": free()}, X, 300)
    calibration = Calibration(problem, 1)
    assert fit_surface(calibration, samples).objective_error > 0.5
    found = sample_posterior(calibration, samples, steps=1000)
    assert not found.trusted
    assert "response surface misses" in found.warnings[0]


def test_too_few_or_bare_evaluations_are_refused() -> None:
    problem, samples = sampled("a * x + b", {"a": free(), "b": free()}, Y, 20)
    with pytest.raises(StatisticsError, match="30 different evaluations, there are 20"):
        fit_surface(Calibration(problem, 1), samples)
    samples.responses.clear()
    with pytest.raises(StatisticsError, match="stored responses"):
        fit_surface(Calibration(problem, 1), samples)
