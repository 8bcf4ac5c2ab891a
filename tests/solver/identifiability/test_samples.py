"""Evaluations as arrays."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.identifiability import Samples, StatisticsError
from geoswarm.solver.local import calibrate
from geoswarm.solver.problem import parse_problem
from tests.solver.identifiability.cases import X, free, problem_of, sampled


def test_history_and_rows_give_the_same_samples() -> None:
    problem = problem_of("a * x ** b", {"a": free(), "b": free(scale="log")}, X)
    result = calibrate(problem)
    samples = Samples.from_result(problem, result)
    rows = [
        {
            "generation": r.generation,
            "particle": r.particle,
            "parameters": dict(zip(problem.free_names, r.evaluation.parameters.tolist(), strict=True)),
            "objective": r.evaluation.objective,
            "misfits": r.evaluation.misfits,
            "responses": {s: {"x": X.tolist(), "y": v.tolist()} for s, v in r.evaluation.responses.items()},
        }
        for r in result.history
    ]
    stored = Samples.from_rows(problem, rows)
    assert samples.source == stored.source == "particle_swarm"
    assert samples.size == stored.size == result.evaluations
    np.testing.assert_array_equal(samples.parameters, stored.parameters)
    np.testing.assert_array_equal(samples.responses["y"], stored.responses["y"])
    np.testing.assert_array_equal(samples.generations, stored.generations)
    assert samples.objectives[samples.best] == result.objective


def test_failed_evaluations_are_counted_and_left_out() -> None:
    problem = problem_of("a * x", {"a": free()}, X)
    samples = Samples.from_arrays(problem, np.array([[1.0], [2.0], [3.0]]), np.array([1.0, np.nan, np.inf]), failed=4)
    assert (samples.size, samples.failed) == (1, 6)
    rows = [
        {"generation": 0, "particle": 0, "parameters": {"a": 1.0}, "objective": None, "misfits": {}, "responses": None}
    ]
    assert Samples.from_rows(problem, rows).failed == 1
    with pytest.raises(StatisticsError, match="no successful evaluation"):
        _ = Samples.from_rows(problem, rows).best


def test_unit_coordinates_follow_the_scale() -> None:
    problem = problem_of("a * x ** b", {"a": free(0.1, 10.1), "b": free(0.1, 10.0, "log")}, X)
    samples = Samples.from_arrays(problem, np.array([[5.1, 1.0]]), np.array([1.0]))
    np.testing.assert_allclose(samples.unit, [[0.5, 0.5]], rtol=1e-12)


def test_a_sampling_and_a_swarm_together_are_mixed() -> None:
    problem, samples = sampled("a * x", {"a": free()}, 2 * X, 50)
    swarm = parse_problem(
        problem.document() | {"method": {"kind": "particle_swarm"}, "stopping": {"max_evaluations": 20}}
    )
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
