"""Linearised uncertainty: no number where the data give none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability import (
    DifferenceDesign,
    Samples,
    StatisticsError,
    TooFewPointsError,
    design,
    differentiate,
    from_evaluations,
    linearise,
)
from geoswarm.solver.identifiability.optimum.combinations import find_directions
from geoswarm.solver.identifiability.stored.linearised import jacobian_from_samples
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import WHITE, X, free, linearised, problem_of

Y = 6.0 * X + 1.0 + np.random.default_rng(1).normal(0.0, 0.1, X.size)


@pytest.mark.parametrize("scale", ["linear", "log"])
def test_a_product_has_no_interval_but_its_neighbour_has(scale: str) -> None:
    parameters = {"a": free(scale=scale), "b": free(scale=scale), "d": free()}
    found = linearised(problem_of("a * b * x + d", parameters, Y), [2.0, 3.0, 1.0])
    assert found.interval("a") is None
    assert found.interval("b") is None
    assert np.isnan(found.standard_errors[:2]).all()
    assert found.tied_to("a") == ("b",)
    assert "only in combination with b" in found.why_no_interval("a")
    (opened,) = (c for c in found.combinations if c.open)
    assert set(opened.components) == {"a", "b"}
    # d is as certain as in the model without the product
    alone = linearised(problem_of("a * x + d", {"a": free(), "d": free()}, Y), [6.0, 1.0])
    np.testing.assert_allclose(found.standard_errors[2], alone.standard_errors[1], rtol=0.05)


def test_a_parameter_without_influence_is_named() -> None:
    found = linearised(problem_of("a * x + 0 * e", {"a": free(), "e": free()}, Y), [6.0, 5.0])
    assert found.without_influence == ("e",)
    assert found.influence("e") == 0.0
    assert found.interval("e") is None
    assert found.interval("a") is not None


def test_an_uncertain_derivative_leaves_the_other_parameters_alone() -> None:
    random = np.random.default_rng(3)
    weighted = np.column_stack([random.standard_normal(60) for _ in range(3)])
    weighted[:, 2] = weighted[:, 1] + 0.2 * weighted[:, 2]  # hard to tell apart, but possible
    errors = weighted * np.array([0.15, 1e-3, 1e-3])
    found = find_directions(("rough", "b", "c"), weighted, errors, np.ones(60))
    assert found.determined.all()
    assert found.derivative_error == pytest.approx(0.15)
    # as uncertain as the rough one, the two cannot be told apart any more
    found = find_directions(("rough", "b", "c"), weighted, weighted * 0.15, np.ones(60))
    assert found.determined.tolist() == [True, False, False]
    assert found.unclear(("rough", "b", "c"), 1e-3) == ("b", "c")


def test_an_interval_wider_than_the_range_is_none() -> None:
    found = linearised(problem_of("a * x + 1e-4 * b", {"a": free(), "b": free()}, Y), [6.0, 5.0])
    assert found.without_influence == ()
    assert found.interval("b") is None
    assert "wider than the searched range" in found.why_no_interval("b")


def test_two_free_parameters_and_one_point_are_refused() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0]), np.array([1.0]))
    with pytest.raises(TooFewPointsError, match=r"1 measured point cannot determine 2 free parameters \(a, b\)"):
        design(Calibration(problem, 1), np.array([1.0, 1.0]))


def test_as_many_points_as_parameters_need_a_known_noise() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0, 3.0]), np.array([1.0, 2.0]))
    unknown = linearised(problem, [1.0, 1.0])
    assert unknown.noise is None
    assert np.isnan(unknown.intervals).all()
    assert "noise cannot be estimated" in unknown.why_no_interval("a")
    known = linearised(problem, [1.0, 1.0], noise=0.01)
    # (J'J)^-1 of a line through x = 1, 2
    np.testing.assert_allclose(known.standard_errors, 0.01 * np.sqrt([2.0, 5.0]), rtol=1e-6)


def test_points_of_no_weight_do_not_count() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0, 3.0, 9.0]), np.array([1.0, 2.0, 3.0]))
    document = problem.document()
    document["observations"][0]["points"]["weight"] = [1.0, 0.0, 0.0]
    from geoswarm.solver.problem import parse_problem

    with pytest.raises(TooFewPointsError):
        design(Calibration(parse_problem(document), 1), np.array([1.0, 1.0]))


def test_intervals_match_the_textbook_line() -> None:
    from scipy.stats import linregress, t

    fitted = linregress(X, Y)
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, Y, noise=WHITE)
    found = linearised(problem, [fitted.slope, fitted.intercept])
    np.testing.assert_allclose(found.standard_errors, [fitted.stderr, fitted.intercept_stderr], rtol=1e-6)
    half = t.ppf(0.975, X.size - 2) * fitted.stderr
    np.testing.assert_allclose(found.interval("a"), [fitted.slope - half, fitted.slope + half], rtol=1e-6)
    assert found.at_optimum


def test_a_point_beside_the_minimum_is_reported() -> None:
    found = linearised(problem_of("a * x + b", {"a": free(), "b": free()}, Y), [6.5, 1.0])
    assert not found.at_optimum
    assert found.distance[0] > 1.0


@pytest.mark.parametrize("optimum", [[0.1, 1.0], [10.0, 10.0]])
def test_at_a_bound_differences_go_inside(optimum: list[float]) -> None:
    problem = problem_of("a * x ** 2 + exp(0.1 * b * x)", {"a": free(), "b": free()}, Y)
    calibration = Calibration(problem, 1)
    plan = design(calibration, np.array(optimum))
    assert (plan.positions >= 0.1).all()
    assert (plan.positions <= 10.0).all()
    assert len(plan.positions) == 9
    jacobian = differentiate(calibration, plan, [calibration.evaluate(x) for x in plan.positions])
    expected = np.stack([X**2, 0.1 * X * np.exp(0.1 * optimum[1] * X)], axis=1) * 9.9
    np.testing.assert_allclose(jacobian.derivatives["y"], expected, rtol=1e-6)


def test_failed_neighbours_are_left_out_and_a_failed_optimum_is_an_error() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, Y)
    calibration = Calibration(problem, 1)
    plan = DifferenceDesign.from_json(design(calibration, np.array([6.0, 1.0])).to_json())
    evaluations = [calibration.evaluate(x) for x in plan.positions]
    failed = Evaluation(plan.positions[1], None, {}, {}, "diverged", "no", 0.0)
    whole = from_evaluations(calibration, plan, evaluations)
    part = from_evaluations(calibration, plan, [*evaluations[:1], failed, *evaluations[2:]])
    np.testing.assert_allclose(part.standard_errors, whole.standard_errors, rtol=1e-6)
    with pytest.raises(StatisticsError, match="optimum failed"):
        from_evaluations(calibration, plan, [failed, *evaluations[1:]])
    with pytest.raises(StatisticsError, match="sensitivities to a"):
        from_evaluations(calibration, plan, [evaluations[0], *[failed] * 4, *evaluations[5:]])
    with pytest.raises(StatisticsError, match="the plan has 9"):
        from_evaluations(calibration, plan, evaluations[:-1])


def test_a_rough_model_widens_the_error_of_its_derivatives() -> None:
    smooth = problem_of("a * x + b", {"a": free(), "b": free()}, Y)
    rough: Any = problem_of("a * x + b + 1e-3 * sin(1e7 * a) + 1e-3 * cos(1e7 * b)", {"a": free(), "b": free()}, Y)
    assert linearised(smooth, [6.0, 1.0]).derivative_error < 1e-9
    error = linearised(rough, [6.0, 1.0]).derivative_error
    assert 1e-3 < error < 0.1


def test_stored_runs_serve_where_they_are_dense() -> None:
    problem = problem_of(
        "a * (1 - exp(-b * x))", {"a": free(), "b": free(0.1, 3.0)}, 4.0 * (1 - np.exp(-0.8 * X)) + 0.02 * np.sin(9 * X)
    )
    result = calibrate(problem)
    assert result.best is not None
    calibration = Calibration(problem, 1)
    samples = Samples.from_result(problem, result)
    stored = linearise(calibration, jacobian_from_samples(calibration, samples))
    fresh = linearised(problem, result.best.parameters.tolist())
    np.testing.assert_allclose(stored.standard_errors, fresh.standard_errors, rtol=0.02)
    with pytest.raises(StatisticsError, match="different evaluations"):
        jacobian_from_samples(calibration, samples.select(np.arange(10)))
