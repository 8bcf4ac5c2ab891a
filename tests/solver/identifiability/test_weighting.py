"""Re-weighting stored responses is a fresh evaluation, to rounding."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import (
    Samples,
    StatisticsError,
    design,
    from_evaluations,
    reweight,
    scheme_weights,
)
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.weighting import series_shares
from geoswarm.solver.runs.local import calibrate

X = np.linspace(0.0, 4.0, 9)


def two_series(**changes: Any) -> Problem:
    document = {
        "forward_model": {"kind": "formula", "series": {"near": "a * x + b", "far": "100 * b * x"}},
        "parameters": {"a": {"lower": 0.1, "upper": 5.0}, "b": {"lower": 0.1, "upper": 5.0}},
        "observations": [
            {"series": "near", "points": {"x": X.tolist(), "y": (2.0 * X + 1.0).tolist()}},
            {"series": "far", "points": {"x": X[:4].tolist(), "y": (300.0 * X[:4]).tolist()}, "weight": 1e-4},
        ],
        "method": {"kind": "monte_carlo", "samples": 300},
        "seed": 3,
    }
    return parse_problem(document | changes)


def samples_of(problem: Problem) -> Samples:
    return Samples.from_result(problem, calibrate(problem))


def check_fresh(problem: Problem, parameters: FloatArray, objectives: FloatArray) -> None:
    calibration = Calibration(problem, 1)
    fresh = [calibration.evaluate(x).objective for x in parameters]
    np.testing.assert_allclose(objectives, np.array(fresh, dtype=np.float64), rtol=1e-14)


def test_new_weights_of_series_and_points_equal_a_fresh_evaluation() -> None:
    problem = two_series()
    samples = samples_of(problem)
    points = {"near": np.linspace(0.0, 2.0, 9).tolist()}
    changed = reweight(problem, samples, weights={"near": 3.0, "far": 0.2}, point_weights=points)
    assert changed.problem.observations[0].weight == 3.0
    check_fresh(changed.problem, samples.parameters, changed.samples.objectives)
    assert changed.best_after == changed.samples.best


def test_unchanged_weights_change_nothing() -> None:
    problem = two_series()
    samples = samples_of(problem)
    changed = reweight(problem, samples)
    np.testing.assert_array_equal(changed.samples.objectives, samples.objectives)
    assert changed.warnings == ()
    assert changed.best_before == changed.best_after


@pytest.mark.parametrize(
    ("weighting", "expected"),
    [
        ("by_error", {"near": 9 / 0.1**2, "far": 4 / 2.0**2}),
        ("by_count", {"near": 9.0, "far": 4.0}),
        ("by_range", {"near": 1 / 8.0**2, "far": 1 / 450.0**2}),
        ("by_test", {"near": 1 / 8.0**2, "far": 1 / 450.0**2}),
    ],
)
def test_schemes(weighting: Any, expected: dict[str, float]) -> None:
    problem = two_series()
    noise = {"near": 0.1, "far": 2.0}
    found = scheme_weights(problem, weighting, noise=noise)
    assert max(found.values()) == 1.0
    np.testing.assert_allclose(found["near"] / found["far"], expected["near"] / expected["far"], rtol=1e-12)
    samples = samples_of(problem)
    changed = reweight(problem, samples, weighting=weighting, noise=noise)
    check_fresh(changed.problem, samples.parameters, changed.samples.objectives)


def test_weights_by_error_make_the_objective_chi_square() -> None:
    problem = two_series()
    weights = scheme_weights(problem, "by_error", noise={"near": 0.1, "far": 2.0})
    changed = reweight(problem, samples_of(problem), weights=weights)
    row = 17
    chi = sum(
        np.sum((changed.samples.responses[o.series][row] - o.y) ** 2) / {"near": 0.1, "far": 2.0}[o.series] ** 2
        for o in problem.observations
    )
    largest = 9 / 0.1**2
    np.testing.assert_allclose(changed.samples.objectives[row] * largest, chi, rtol=1e-12)


def test_shares_add_up() -> None:
    problem = two_series()
    found = series_shares(problem, {"near": 2.0, "far": 1e4})
    np.testing.assert_allclose([s.share for s in found], [2.0 / 3.0, 1.0 / 3.0], rtol=1e-12)
    assert [s.share for s in series_shares(problem, {"near": 0.0, "far": 0.0})] == [0.0, 0.0]


def test_an_optimum_that_leaves_the_swarms_region_is_reported() -> None:
    stopping = {"max_evaluations": 400}
    problem = two_series(method={"kind": "particle_swarm", "acceleration": "none"}, stopping=stopping)
    changed = reweight(problem, samples_of(problem), weights={"near": 0.0, "far": 1.0})
    assert changed.best_after != changed.best_before
    assert any("swarm did not search there" in w or "edge of the sampled region" in w for w in changed.warnings)


def test_what_cannot_be_done_is_refused() -> None:
    problem = two_series()
    samples = samples_of(problem)
    bare = Samples.from_arrays(problem, samples.parameters, samples.objectives, misfits=samples.misfits)
    again = reweight(problem, bare, weights={"near": 2.0})
    np.testing.assert_allclose(
        again.samples.objectives, 2.0 * samples.misfits["near"] + 1e-4 * samples.misfits["far"], rtol=1e-14
    )
    with pytest.raises(StatisticsError, match="stored responses"):
        reweight(problem, bare, point_weights={"near": [1.0] * 9})
    with pytest.raises(StatisticsError, match="unknown series up; observed: near, far"):
        reweight(problem, samples, weights={"up": 1.0})
    with pytest.raises(StatisticsError, match="either weights or weighting"):
        reweight(problem, samples, weights={"near": 1.0}, weighting="by_count")
    with pytest.raises(StatisticsError, match="by_error needs"):
        reweight(problem, samples, weighting="by_error")
    with pytest.raises(StatisticsError, match="known: by_error, by_count, by_range, by_test"):
        scheme_weights(problem, "by_eye")  # type: ignore[arg-type]
    with pytest.raises(ProblemError, match="weight"):
        reweight(problem, samples, weights={"near": -1.0})
    with pytest.raises(ProblemError, match="has 2 values, but x has 9"):
        reweight(problem, samples, point_weights={"near": [1.0, 1.0]})


def test_the_noise_of_the_problem_file_is_known_noise() -> None:
    document = two_series().document()
    document["observations"][0]["error"] = 0.1
    document["observations"][1] |= {"error": 2.0, "weight": 1.0}
    calibration = Calibration(parse_problem(document | {"weighting": "by_error"}), 1)
    plan = design(calibration, np.array([2.0, 3.0]))
    found = from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions])
    assert found.noise is not None
    assert found.noise.origin == "known"
    near, far = np.stack([X, np.ones(9)], axis=1) / 0.1, np.stack([np.zeros(4), 100.0 * X[:4]], axis=1) / 2.0
    jacobian = np.concatenate([near, far])
    expected = np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(found.standard_errors, expected, rtol=1e-6)


def test_new_weights_take_the_place_of_a_scheme() -> None:
    problem = two_series(weighting="by_range")
    samples = samples_of(problem)
    kept = reweight(problem, samples)
    np.testing.assert_array_equal(kept.samples.objectives, samples.objectives)
    changed = reweight(problem, samples, weights={"near": 3.0, "far": 0.2})
    assert [o.weight for o in changed.problem.observations] == [3.0, 0.2]
    check_fresh(changed.problem, samples.parameters, changed.samples.objectives)
