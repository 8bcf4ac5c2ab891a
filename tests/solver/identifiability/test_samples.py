"""Evaluations as arrays."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.identifiability import Samples, StatisticsError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import X, free, problem_of, sampled


def test_a_history_gives_its_evaluations_in_order() -> None:
    alone = {"max_evaluations": "off"}
    problem = problem_of("a * x ** b", {"a": free(), "b": free(scale="log")}, X, answer=alone)
    result = calibrate(problem)
    samples = Samples.from_result(problem, result)
    assert samples.source == "particle_swarm"
    assert samples.size == result.evaluations
    for index, record in enumerate(result.history):
        assert (samples.generations[index], samples.particles[index]) == (record.generation, record.particle)
        np.testing.assert_array_equal(samples.parameters[index], record.evaluation.parameters)
        np.testing.assert_array_equal(samples.responses["y"][index], record.evaluation.responses["y"])
    assert samples.objectives[samples.best] == result.objective


def test_failed_evaluations_are_counted_and_left_out() -> None:
    problem = problem_of("a * x", {"a": free()}, X)
    samples = Samples.from_arrays(problem, np.array([[1.0], [2.0], [3.0]]), np.array([1.0, np.nan, np.inf]), failed=4)
    assert (samples.size, samples.failed) == (1, 6)
    failed = Evaluation(np.array([1.0]), None, {}, {}, 0.1, "diverged", "no balance")
    none = Samples.from_evaluations(problem, [failed])
    assert none.failed == 1
    with pytest.raises(StatisticsError, match="no successful evaluation"):
        _ = none.best


def test_unit_coordinates_follow_the_scale() -> None:
    problem = problem_of("a * x ** b", {"a": free(0.1, 10.1), "b": free(0.1, 10.0, "log")}, X)
    samples = Samples.from_arrays(problem, np.array([[5.1, 1.0]]), np.array([1.0]))
    np.testing.assert_allclose(samples.unit, [[0.5, 0.5]], rtol=1e-12)


def test_a_sampling_and_a_swarm_together_are_mixed() -> None:
    problem, samples = sampled("a * x", {"a": free()}, 2 * X, 50)
    alone = {"max_evaluations": "off"}
    method = {"kind": "particle_swarm"}
    swarm = parse_problem(problem.document() | {"method": method, "stopping": {"max_evaluations": 20}, "answer": alone})
    both = Samples.merge([samples, Samples.from_result(swarm, calibrate(swarm))])
    assert both.source == "mixed"
    assert both.size == 70
    assert int(both.unbiased.sum()) == 50
    other = problem_of("a * x", {"a": free(0.2, 3.0)}, X)
    with pytest.raises(StatisticsError, match="bounds agree"):
        Samples.merge([samples, Samples.from_arrays(other, np.ones((1, 1)), np.ones(1))])


def test_columns_of_different_length_are_refused() -> None:
    problem = problem_of("a * x", {"a": free()}, X)
    with pytest.raises(StatisticsError, match="parameters: the number of rows"):
        Samples.from_arrays(problem, np.ones((3, 1)), np.ones(2))
