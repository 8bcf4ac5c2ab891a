"""Sensitivities whose steps are found: never a claim from a derivative that is uncertain."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, analyse, from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.stored.findings import findings_of
from geoswarm.solver.identifiability.stored.follow_ups import sensitivity_problem
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.search.descent.steps import StepSearch
from geoswarm.solver.search.space import SearchSpace
from geoswarm.solver.words import per_cent
from tests.solver.identifiability.cases import X, free, linearised, problem_of

T = np.linspace(0.0, 16.0, 81)
NOISE = 0.02 * np.random.default_rng(3).standard_normal(T.size)


def vibration(upper: float = 40.0) -> Problem:
    """A free vibration over 16 s, whose frequency changes the phase at the end by 16 rad for each rad/s."""
    y = np.exp(-0.1 * T) * np.cos(6.0 * T) + NOISE
    return problem_of("exp(-delta * x) * cos(omega * x)", {"delta": free(0.01, 1.0), "omega": free(0.5, upper)}, y, T)


def found_at(problem: Problem, optimum: list[float]) -> Linearisation:
    calibration = Calibration(problem, 1)
    return from_evaluations(calibration, *evaluate_differences(calibration, np.array(optimum)))


def exact_errors(delta: float, omega: float) -> np.ndarray:
    decay = np.exp(-delta * T)
    columns = np.stack([-T * decay * np.cos(omega * T), -T * decay * np.sin(omega * T)], axis=1)
    residuals = decay * np.cos(omega * T) - (np.exp(-0.1 * T) * np.cos(6.0 * T) + NOISE)
    variance = residuals @ residuals / (T.size - 2)
    return np.asarray(np.sqrt(variance * np.diag(np.linalg.inv(columns.T @ columns))))


@pytest.mark.parametrize("upper", [40.0, 400.0])
def test_a_frequency_that_bends_fast_has_the_standard_error_of_the_closed_form(upper: float) -> None:
    problem = vibration(upper)
    found = found_at(problem, [0.1, 6.0])
    np.testing.assert_allclose(found.standard_errors, exact_errors(0.1, 6.0), rtol=1e-3)
    assert found.unclear == ()
    # a step that is too long is no proof of anything: neither an interval nor "no influence"
    blind = linearised(vibration(400.0), [0.1, 6.0])
    assert blind.without_influence == ()
    assert "omega" in blind.unclear
    assert "the forward model is rough there" in blind.why_no_interval("omega")
    assert np.isnan(blind.standard_errors).all()


def test_uncertain_sensitivities_leave_the_verdict_open() -> None:
    problem = vibration(400.0)
    samples = Samples.from_arrays(problem, np.array([[0.1, 6.0]]), np.array([4e-4]))
    blind = linearised(problem, [0.1, 6.0])
    verdict = analyse(Calibration(problem, 1), samples, linearisation=blind).verdict("omega")
    assert verdict.kind == "undecided"
    assert "rough there" in verdict.sentence


@pytest.mark.parametrize(("roughness", "left"), [(0.02, "tell it from a"), (1.0, "show how it acts")])
def test_roughness_is_said_with_its_size(roughness: float, left: str) -> None:
    model = f"a * x + b * (x + 0.03 * x ** 2) + {roughness} * (sin(1e7 * a) + cos(1e7 * b)) * x"
    problem = problem_of(model, {"a": free(), "b": free()}, 7.0 * X + 0.03 * X**2 + 0.1 * np.sin(7.0 * X))
    found = linearised(problem, [6.0, 1.0])
    why = found.why_no_interval("b")
    error = per_cent(found.derivative_errors[1])
    assert why == f"its sensitivity is uncertain by {error} (the forward model is rough there), too much to {left}"


@pytest.mark.parametrize("phase", range(5))
def test_a_rough_model_gets_longer_steps(phase: int) -> None:
    y = 6.0 * X + 1.0 + 0.1 * np.sin(7.0 * X)
    roughness = f"1e-2 * sin(1e7 * a + {phase}) + 1e-2 * cos(1e7 * b + {phase})"
    rough = problem_of(f"a * x + b + {roughness}", {"a": free(), "b": free()}, y)
    smooth = linearised(problem_of("a * x + b", {"a": free(), "b": free()}, y), [6.0, 1.0])
    found = found_at(rough, [6.0, 1.0])
    assert found.derivative_error <= linearised(rough, [6.0, 1.0]).derivative_error
    np.testing.assert_allclose(found.standard_errors, smooth.standard_errors, rtol=0.2)


def test_nothing_that_moves_is_said_to_have_no_influence() -> None:
    y = 6.0 * X
    step = problem_of("a * x + where0 * 0 + 1e-3 * e", {"a": free(), "e": free(), "where0": free()}, y)
    found = found_at(step, [6.0, 1.0, 1.0])
    assert found.without_influence == ("where0",)
    assert found.unclear == ()


def test_steps_go_on_from_their_state_and_the_follow_up_reads_them() -> None:
    problem = sensitivity_problem(vibration(400.0), np.array([0.1, 6.0]), seed=1)
    result = calibrate(problem)
    assert result.stop_reasons == ("design_completed",)
    assert result.generations > 1
    evaluations = [record.evaluation for record in result.history]
    found = findings_of(problem, 1, evaluations).linearisation
    assert found is not None
    np.testing.assert_allclose(found.standard_errors, exact_errors(0.1, 6.0), rtol=1e-3)
    # without the last generation, the ends of the intervals, nobody has looked whether the model is nonlinear
    unseen = findings_of(problem, 1, evaluations[:-1]).linearisation
    assert unseen is not None
    np.testing.assert_array_equal(unseen.standard_errors, found.standard_errors)
    assert np.isnan(unseen.bending).all()
    assert np.isfinite(found.bending).all()
    assert findings_of(problem, 1, evaluations[:-5]).notes == ("the sensitivities are not complete yet",)
    # a given step is one generation, as before
    fixed = calibrate(sensitivity_problem(vibration(), np.array([0.1, 6.0]), seed=1, step=1e-4))
    assert (fixed.generations, fixed.evaluations) == (1, 9)


def test_whole_numbers_are_moved_by_whole_numbers() -> None:
    space = SearchSpace(("n",), np.array([1.0]), np.array([400.0]), np.array([False]), lambda _: True, np.array([True]))
    assert StepSearch(space, np.array([7.0])).positions[:, 0].tolist() == [7.0, 5.0, 6.0, 8.0, 9.0]


def test_constraints_are_asked_once_for_each_place() -> None:
    asked: list[np.ndarray] = []
    ends = np.zeros(2), np.ones(2)
    space = SearchSpace(("a", "b"), *ends, np.zeros(2, dtype=bool), lambda at: asked.append(at) is None)
    steps = StepSearch(space, np.array([0.5, 0.5]), [[(0, step), (1, step)] for step in np.geomspace(1e-2, 1e-5, 8)])
    rows = np.exp(steps.every.positions @ np.ones((2, 5)))
    steps.chosen(rows)
    assert len(asked) == len(steps.every.positions) - 1
