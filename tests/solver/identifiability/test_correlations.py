"""Correlations with their intervals, and the filter before them."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.identifiability import (
    Samples,
    StatisticsError,
    correlate,
    filter_samples,
    propose_threshold,
)
from geoswarm.solver.identifiability.stored.correlations import correlate_at
from geoswarm.solver.problem import Problem
from tests.solver.identifiability.cases import X, free, problem_of

PROBLEM = problem_of(
    "a * x ** b", {"a": free(-50, 50), "b": free(-50, 50)}, X, method={"kind": "monte_carlo", "samples": 2}, stopping={}
)


def samples_of(values: FloatArray) -> Samples:
    names = "abcdef"[: values.shape[1]]
    problem = PROBLEM if len(names) == 2 else wide(names)
    return Samples.from_arrays(problem, values, np.arange(1.0, len(values) + 1))


def wide(names: str) -> Problem:
    return problem_of(
        " + ".join(f"{name} * x ** {i}" for i, name in enumerate(names)),
        {name: free(-50, 50) for name in names},
        X,
        method={"kind": "monte_carlo", "samples": 2},
        stopping={},
    )


def normal(r: float, count: int, random: np.random.Generator) -> FloatArray:
    return random.multivariate_normal([0.0, 0.0], [[1.0, r], [r, 1.0]], count)


@pytest.mark.parametrize("method", ["pearson", "spearman"])
@pytest.mark.parametrize("r", [0.0, 0.64, 0.88])
def test_intervals_cover_the_true_correlation(method: str, r: float) -> None:
    random = np.random.default_rng(1)
    truth = r if method == "pearson" else 6.0 / np.pi * np.arcsin(r / 2.0)
    hits = []
    for _ in range(400):
        pair = correlate(samples_of(normal(r, 40, random)), method=method).get("b", "a")  # type: ignore[arg-type]
        assert pair.lower is not None
        assert pair.upper is not None
        hits.append(pair.lower <= truth <= pair.upper)
    assert 0.92 <= np.mean(hits) <= 0.98


def test_against_scipy() -> None:
    from scipy.stats import pearsonr, spearmanr

    values = normal(0.5, 30, np.random.default_rng(2))
    pair = correlate(samples_of(values)).pairs[0]
    expected = pearsonr(values[:, 0], values[:, 1])
    np.testing.assert_allclose(pair.coefficient, expected.statistic, rtol=1e-12)
    interval = expected.confidence_interval(0.95)
    np.testing.assert_allclose([pair.lower, pair.upper], [interval.low, interval.high], rtol=1e-10)
    for ranked in (values, values.round(0)):  # the second with many equal values
        found = correlate(samples_of(ranked), method="spearman").pairs[0]
        np.testing.assert_allclose(found.coefficient, spearmanr(ranked[:, 0], ranked[:, 1]).statistic, rtol=1e-12)


def test_heavy_tails_and_exact_lines_are_resampled() -> None:
    random = np.random.default_rng(3)
    heavy = random.standard_t(2, size=(200, 2)).clip(-49, 49)
    assert correlate(samples_of(heavy)).pairs[0].interval == "bootstrap"
    line = np.column_stack([np.arange(10.0), 2.0 * np.arange(10.0)])
    pair = correlate(samples_of(line)).pairs[0]
    assert pair.interval == "bootstrap"
    np.testing.assert_allclose([pair.coefficient, pair.lower, pair.upper], 1.0, rtol=1e-12)


def test_resampled_intervals_are_those_of_resampling_each_pair_alone() -> None:
    """Against a plain bootstrap of its own draws: the shared resamples have the same distribution."""
    random = np.random.default_rng(4)
    heavy = np.exp(
        random.multivariate_normal([0, 0, 0], [[1, 0.6, 0], [0.6, 1, 0.3], [0, 0.3, 1]], 300).clip(-3.5, 3.5)
    )
    for pair in correlate(samples_of(heavy)).pairs:
        x, y = (heavy[:, "abc".index(name)] for name in (pair.first, pair.second))
        draws = [random.integers(0, 300, 300) for _ in range(4000)]
        plain = np.quantile([np.corrcoef(x[one], y[one])[0, 1] for one in draws], [0.025, 0.975])
        assert pair.interval == "bootstrap"
        np.testing.assert_allclose([pair.lower, pair.upper], plain, atol=0.035)


def test_many_good_fits_are_resampled_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[int] = []

    class Counting(np.random.Generator):
        def integers(self, low: int, high: int, size: int) -> np.ndarray:  # type: ignore[override]
            drawn.append(size)
            return super().integers(low, high, size)

    monkeypatch.setattr(np.random, "default_rng", lambda seed: Counting(np.random.PCG64(seed)))
    lots = np.random.Generator(np.random.PCG64(5)).standard_t(2, size=(20_000, 6)).clip(-49, 49)
    pairs = correlate_at(samples_of(lots), (0.95, 0.999))
    assert all(pair.interval == "bootstrap" for level in pairs for pair in level)
    assert sum(drawn) == 200 * 20_000  # once for all pairs and both levels


def test_nothing_is_made_up_from_too_few_or_constant_values() -> None:
    few = correlate(samples_of(np.array([[1.0, 2.0], [2.0, 1.0]]))).pairs[0]
    assert (few.coefficient, few.lower, few.count, few.correlated) == (None, None, 2, False)
    three = correlate(samples_of(np.array([[1.0, 2.0], [2.0, 1.0], [4.0, 0.0]]))).pairs[0]
    assert three.coefficient is not None
    assert three.interval == "none"
    constant = correlate(samples_of(np.column_stack([np.full(20, 0.1), np.arange(20.0)])))
    assert constant.pairs[0].coefficient is None
    assert np.isnan(constant.matrix()[0, 1])


def test_thresholds() -> None:
    samples = samples_of(np.zeros((200, 2)))
    assert filter_samples(samples, 7.0).kept == 7
    assert filter_samples(samples, 7.0).statement == "f ≤ 7: 7 of 200 evaluations"
    proposed = propose_threshold(samples, 22)
    assert proposed.origin == "samples"
    assert filter_samples(samples, proposed).kept == 40
    # 1 + 2 / 20 F_0.95(2, 20) = 1.349
    statistical = propose_threshold(samples, 22, noise_objective=60.0)
    assert statistical.origin == "statistics"
    np.testing.assert_allclose(statistical.value, 60.0 * (1.0 + 0.1 * 3.4928), rtol=1e-4)
    for wrong in (0.0, -1.0, float("nan"), float("inf")):
        with pytest.raises(StatisticsError, match="finite number above 0"):
            filter_samples(samples, wrong)
