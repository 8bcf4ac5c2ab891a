"""Parameters that can be exchanged, the limit of fits that cannot be told apart, and where a basin could hide."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2, f

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples
from geoswarm.solver.identifiability.noise import problem_noise
from geoswarm.solver.identifiability.optimum.basins import equivalent_objective, exchangeable
from geoswarm.solver.identifiability.optimum.hidden import Unseen, hidden_share
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import X, free, linearised, problem_of

NOISE = 0.01 * np.random.default_rng(4).standard_normal(X.size)


@pytest.mark.parametrize("seed", range(3))
def test_exchange_of_two_rates_is_reported(seed: int) -> None:
    y = np.exp(-0.3 * X) + np.exp(-2.0 * X) + NOISE
    problem = problem_of("exp(-a * x) + exp(-b * x)", {"a": free(0.05, 5.0), "b": free(0.05, 5.0)}, y)
    statistics = report_of_result(problem, calibrate(problem, seed=seed)).statistics
    assert statistics is not None
    assert {verdict.kind for verdict in statistics.verdicts} == {"not_identified"}
    assert "the data allow both" in statistics.verdict("a").sentence
    assert [one.sentence for one in statistics.verdict("a").proposals][1] == (
        "Add a test or a measured series that tells these values of a apart."
    )
    assert any("a and b can be exchanged" in warning for warning in statistics.warnings)


def test_a_constraint_that_excludes_an_exchange_decides_it() -> None:
    y = np.exp(-0.3 * X) + np.exp(-2.0 * X) + NOISE
    rates = {"a": free(0.05, 5.0), "b": free(0.05, 5.0)}
    problem = problem_of("exp(-a * x) + exp(-b * x)", rates, y, constraints=["a < b"])
    statistics = report_of_result(problem, calibrate(problem, seed=1)).statistics
    assert statistics is not None
    assert {verdict.kind for verdict in statistics.verdicts} == {"identified"}
    assert not any("exchanged" in warning for warning in statistics.warnings)


def test_whole_numbers_are_exchanged_with_whole_numbers_alone() -> None:
    n = {"lower": 1, "upper": 9, "integer": True}
    problem = problem_of("a * x + n + k", {"a": free(1.0, 9.0), "n": n, "k": n | {"upper": 8}}, 2.5 * X + 7.0)
    pairs = [pair for *pair, _ in exchangeable(Calibration(problem, 1), np.array([2.5, 3.0, 4.0]))]
    assert pairs == [["n", "k"]]


def test_equal_bounds_alone_are_no_exchange() -> None:
    y = 2.0 * X + 5.0 + NOISE
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, y)
    statistics = report_of_result(problem, calibrate(problem, seed=1)).statistics
    assert statistics is not None
    assert {verdict.kind for verdict in statistics.verdicts} == {"identified"}
    assert not any("exchanged" in warning for warning in statistics.warnings)
    assert "it holds within its basin" in statistics.verdict("a").sentence
    assert statistics.verdict("a").evidence.hidden == statistics.basins.hidden


def test_limit_with_and_without_a_known_noise() -> None:
    x = X[:8]
    y = 2.0 * x + 5.0
    parameters = {"a": free(), "b": free()}
    plain = problem_of("a * x + b", parameters, y, x)
    assert equivalent_objective(Calibration(plain, 1), 0.01, None) == pytest.approx(
        0.01 * (1.0 + 2.0 / 6.0 * f.ppf(0.95, 2, 6))
    )
    points = {"x": x.tolist(), "y": y.tolist()}
    stated = problem_of("a * x + b", parameters, y, x, observations=[{"series": "y", "points": points, "error": 0.1}])
    known = problem_noise(stated)
    # residuals smaller than the noise: the rise alone counts, 0.01 chi2 / 8
    assert equivalent_objective(Calibration(stated, 1), 0.002, known) == pytest.approx(
        0.002 + 0.01 * chi2.ppf(0.95, 2) / 8.0
    )


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy"])
def test_limit_with_a_loss_is_that_of_the_readings_without_outliers(loss: str) -> None:
    y = 2.0 * X + 5.0 + 0.1 * np.random.default_rng(7).standard_normal(X.size)
    y[[4, 13]] += 4.0
    robust = {"series": "y", "points": {"x": X.tolist(), "y": y.tolist()}, "loss": loss, "error": 0.1}
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, y, observations=[robust])
    calibration = Calibration(problem, 1)
    best = polish(calibration, np.array([2.0, 5.0]))
    assert best.evaluation.objective is not None
    found = linearised(problem, best.parameters.tolist())
    lowest = best.evaluation.objective
    rise = equivalent_objective(calibration, lowest, problem_noise(problem), found) - lowest
    assert 0.4 < rise / (0.01 * 2.0 * f.ppf(0.95, 2, X.size - 2) / X.size) < 2.0


def test_share_where_a_basin_could_hide() -> None:
    # one parameter, f = mean(x^2) (a - 5)^2: a basin reaches as far as the median of the early runs is away
    y = 5.0 * X
    problem = problem_of("a * x", {"a": free(0.0, 10.0)}, y)
    found = linearised(problem, [5.0])
    rise = float(np.mean(X**2))

    def share(places: list[float]) -> float:
        a = np.array(places)
        samples = Samples.from_arrays(problem, a[:, None], rise * (a - 5.0) ** 2)
        told = hidden_share(Calibration(problem, 1).space, Unseen.of(samples, found, 0.0))
        assert told is not None
        return told

    assert share([4.0, 5.0, 6.0, 5.0]) == pytest.approx(
        1.0 - (2.0 + 2.0 * 0.5**0.5) / 10.0, abs=0.03
    )  # to 0.71 beside 4 and 6
    assert share([2.0, 5.0, 8.0, 5.0]) == 0.0  # reach 3


def test_a_long_history_hides_no_more_than_its_beginning() -> None:
    """A quarter of a long swarm has converged; its median would say that a basin is as flat as the optimum."""
    y = 5.0 * X
    problem = problem_of("a * x", {"a": free(0.0, 10.0)}, y)
    found = linearised(problem, [5.0])
    rise = float(np.mean(X**2))
    space = Calibration(problem, 1).space

    def share(converged: int) -> float | None:
        a = np.concatenate([np.linspace(0.0, 10.0, 100), np.full(converged, 5.0)])
        samples = Samples.from_arrays(problem, a[:, None], rise * (a - 5.0) ** 2)
        return hidden_share(space, Unseen.of(samples, found, 0.0))

    assert share(300) == share(3000) == 0.0
