"""How often the test of lack of fit is wrong: alarms on right models, misses on wrong ones, and what intervals do."""

from __future__ import annotations

import numpy as np
import pytest

from tests.solver.identifiability.cases import free, linearised, problem_of
from tests.variants import variants
from tests.verification.fit_cases import DEPARTING, FEW_STATED, RIGHT, WRONG, fitted, share_flagged

_FEW = {
    "bend, 15 points": 0.85,
    "wave, 15 points": 0.83,
    "step, 15 points": 0.35,
    "step, 18 points": 0.37,
    "step, 15 points, stated error": 0.78,
    "step, 18 points, stated error": 0.82,
}
"""Deviations of twice the noise that more than a tenth of the fits hide, and what is found of them at least.

Of the first three, an F test at the same level that knows the one direction finds 96, 99 and 94 %, and one that looks
in three directions, the deviation among them, 81, 88 and 76 % (noncentral F): few readings do not show more.
"""


@pytest.mark.parametrize("name", ["15 points, saturation", "two series, stated errors"])
def test_right_models_are_seldom_called_wrong(name: str) -> None:
    assert share_flagged(RIGHT[name], 40) <= 0.15


@pytest.mark.parametrize("name", ["bend, 40 points", "wave, 15 points, stated error"])
def test_a_deviation_of_twice_the_noise_is_found(name: str) -> None:
    assert share_flagged(WRONG[name], 30) >= 0.8


@pytest.mark.parametrize("points", variants([3, 4, 5, 6], {3, 6}))
def test_a_stated_error_counts_from_the_first_degree_of_freedom(points: int) -> None:
    """Errors stated 20 times too small were met "identified" below six readings.

    With one degree of freedom such residuals stay within the error once in nine times: P(chi2_1 < 6.63 / 400) = 0.103.
    """
    assert share_flagged(FEW_STATED[points, 0.0025], 30) >= (0.7 if points == 3 else 0.9)
    assert share_flagged(FEW_STATED[points, 0.05], 30) <= 0.1


def test_without_a_degree_of_freedom_intervals_say_that_they_rest_on_the_stated_error() -> None:
    problem = problem_of("a + b * x", {"a": free(), "b": free()}, np.array([2.0, 4.0]), np.array([1.0, 3.0]))
    found = linearised(problem, [1.0, 1.0], noise=0.1)
    assert found.fit.kind == "untested"
    assert found.interval("b") == pytest.approx((1 - 1.96 * 0.1 / 2**0.5, 1 + 1.96 * 0.1 / 2**0.5), abs=1e-3)
    assert found.interval_in_words("b") == "its 95 % interval by linearisation, if the stated error holds,"


def test_the_verdict_says_where_and_by_how_much() -> None:
    found = fitted(WRONG["bend, 40 points"], np.random.default_rng(3)).fit
    assert found.kind == "lack_of_fit"
    assert found.misfits[0].series == "y"
    # the largest deviation of the parabola from its line, 0.1, lies at an end; a reading adds its noise of 0.05
    assert abs(abs(found.misfits[0].largest) - 0.1) < 3 * 0.05
    assert found.misfits[0].x < 0.5 or found.misfits[0].x > 3.5
    assert "does not describe y" in found.sentence
    assert found.remedies


def test_correlated_residuals_widen_the_intervals() -> None:
    found = fitted(DEPARTING["correlated noise, 0.8"], np.random.default_rng(5))
    assert found.fit.kind == "lack_of_fit"
    (one,) = found.dependence
    assert one.kind == "correlated"
    assert 0.4 < one.rho <= 0.95
    assert one.effective < 20


@pytest.mark.slow
@pytest.mark.parametrize("name", list(RIGHT))
def test_false_alarms_in_1000_repeats(name: str) -> None:
    assert share_flagged(RIGHT[name], 1000) <= 0.05


@pytest.mark.slow
@pytest.mark.parametrize(("points", "level"), [(3, 0.01), (4, 0.01), (5, 0.01), (6, 0.05)])
def test_a_right_stated_error_of_few_readings_in_1000_repeats(points: int, level: float) -> None:
    """Patterns, at a level of 4 % of their own, are looked for from six readings on."""
    assert share_flagged(FEW_STATED[points, 0.05], 1000) <= level + 0.005


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in WRONG if name not in _FEW])
def test_misses_in_300_repeats(name: str) -> None:
    assert share_flagged(WRONG[name], 300) >= 0.9


@pytest.mark.slow
@pytest.mark.parametrize("name", _FEW)
def test_what_few_readings_of_unknown_noise_show(name: str) -> None:
    assert share_flagged(WRONG[name], 300) >= _FEW[name]
