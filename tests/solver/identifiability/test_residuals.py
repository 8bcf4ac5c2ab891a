"""Correlated residuals and repeats."""

from __future__ import annotations

import numpy as np
from scipy.special import ndtr

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import SeriesResiduals, examine_residuals, known_noise, noise_objective
from geoswarm.solver.identifiability.residuals.independence import durbin_watson, runs_test
from tests.solver.identifiability.cases import free, problem_of


def examine(
    residuals: FloatArray, x: FloatArray | None = None, noise: dict[str, float] | None = None
) -> SeriesResiduals:
    x = np.arange(1.0, len(residuals) + 1) if x is None else x
    problem = problem_of("a * x", {"a": free()}, x - residuals, x)
    return examine_residuals(Calibration(problem, 1), {"y": x}, noise)[0]


def test_independent_residuals_raise_no_warning_more_often_than_they_should() -> None:
    random = np.random.default_rng(5)
    warned = [bool(examine(random.normal(0.0, 1.0, 40)).warnings) for _ in range(400)]
    assert 0.02 <= np.mean(warned) <= 0.10  # two tests of 5 %, closely related


def test_a_wave_is_found() -> None:
    found = examine(np.sin(np.linspace(0.0, 12.0, 60)))
    assert found.durbin_watson is not None
    assert found.durbin_watson < 0.1
    assert found.runs == 4
    assert "correlated" in found.warnings[0]


def test_statistics_by_hand() -> None:
    residuals = np.array([1.0, 2.0, -1.0, -1.0, 3.0, -2.0])
    runs, expected, _ = runs_test(residuals)
    assert (runs, expected) == (4, 4.0)
    statistic, _ = durbin_watson(residuals)
    np.testing.assert_allclose(statistic, (1 + 9 + 0 + 16 + 25) / 20, rtol=1e-12)
    assert runs_test(np.ones(10))[2] == 2.0**-9


def test_runs_probability_against_simulation() -> None:
    random = np.random.default_rng(6)
    counts = np.array([runs_test(random.permutation([1.0] * 15 + [-1.0] * 15))[0] for _ in range(4000)])
    for runs in (11, 13, 16):
        share = float(np.mean(counts <= runs))
        expected, deviation = 16.0, np.sqrt(15.0 * 14.0 / 29.0)
        np.testing.assert_allclose(ndtr((runs + 0.5 - expected) / deviation), share, atol=0.02)


def test_repeats_tell_noise_from_lack_of_fit() -> None:
    random = np.random.default_rng(7)
    x = np.repeat(np.arange(1.0, 11.0), 4)
    noise = random.normal(0.0, 0.1, x.size)
    fine = examine(noise, x).lack_of_fit
    assert fine is not None
    assert fine.repeats == 30
    np.testing.assert_allclose(fine.noise, 0.1, rtol=0.3)
    assert not fine.significant
    bent = examine(noise + 0.3 * np.sin(x), x)
    assert bent.lack_of_fit is not None
    assert bent.lack_of_fit.significant
    assert any("repeats" in warning for warning in bent.warnings)


def test_few_points_give_no_test_and_a_stated_noise_is_compared() -> None:
    few = examine(np.array([1.0, -1.0, 2.0]), noise={"y": 0.1})
    assert few.runs is None
    assert few.durbin_watson is None
    assert "times the stated noise" in few.warnings[0]


def test_the_objective_that_noise_leaves() -> None:
    random = np.random.default_rng(8)
    x = np.linspace(1.0, 2.0, 50)
    problem = problem_of("a * x", {"a": free()}, 3.0 * x, x)
    expected = noise_objective(problem, known_noise(problem, 0.2))
    drawn = [np.mean(random.normal(0.0, 0.2, 50) ** 2) for _ in range(2000)]
    np.testing.assert_allclose(expected, np.mean(drawn), rtol=0.02)
