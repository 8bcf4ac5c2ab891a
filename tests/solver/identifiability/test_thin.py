"""A sampling that is too thin to judge says so, at its threshold; weights follow the spread of the residuals."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import analyse
from geoswarm.solver.identifiability.stored.filtering import Filtered, Threshold
from geoswarm.solver.identifiability.weighting import spread_weights
from tests.solver.identifiability.cases import X, free, problem_of, sampled


def test_a_raised_threshold_judges_nothing() -> None:
    noise = np.random.default_rng(4).normal(0.0, 0.005, X.size)
    problem, samples = sampled("a * x + b", {"a": free(), "b": free()}, 3.0 * X + 2.0 + noise)
    statistics = analyse(Calibration(problem, 1), samples)
    threshold = statistics.filtered.threshold
    assert threshold.origin == "samples"
    assert threshold.wanted is not None
    for verdict in statistics.verdicts:
        assert verdict.kind == "undecided"
        assert "too thin to judge" in verdict.sentence
        assert f"{threshold.value:.3g}" in verdict.sentence
        assert not any(proposal.kind == "link" for proposal in verdict.proposals)
    given = analyse(Calibration(problem, 1), samples, threshold=threshold.value)
    assert given.filtered.thin is None


def test_weights_follow_the_spread_of_the_residuals() -> None:
    rank = np.linspace(0.0, 1.0, X.size)
    size = np.exp(1.5 * rank)
    signs = np.where(np.arange(X.size) % 2, 1.0, -1.0)
    problem = problem_of("a * x", {"a": free()}, 3.0 * X)
    weights = np.array(spread_weights(problem, {"y": 3.0 * X + 0.01 * signs * size})["y"])
    np.testing.assert_allclose(weights / weights[0], (size / size[0]) ** -2.0, rtol=1e-6)
    np.testing.assert_allclose(weights.mean(), 1.0, rtol=1e-12)


def test_a_perfect_fit_that_is_thin_is_told_without_a_ratio() -> None:
    _, samples = sampled("a * x", {"a": free()}, 3.0 * X, 20)
    perfect = Filtered(samples, Threshold(0.5, "samples", "", wanted=0.0), 20)
    assert perfect.thin is not None
    assert perfect.thin.endswith("the threshold was raised to 0.5")
