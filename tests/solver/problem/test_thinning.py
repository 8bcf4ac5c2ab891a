"""Thinning does not weigh: misfits and shares of series stay, whatever the weighting, and errors do not shrink."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability.noise import known_noise, problem_noise
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.preparation import independent_readings

X = np.arange(1.0, 1201.0)
WEIGHTINGS = [None, "by_range", "by_count", "by_error"]


def problem(observations: list[dict[str, Any]], weighting: str | None) -> Problem:
    """Series q and r of the same line, and p with two readings."""
    made = parse_problem(
        {
            "name": "thinned",
            "forward_model": {"kind": "formula", "series": {"q": "a * x", "r": "a * x", "p": "a + 0 * x"}},
            "parameters": {"a": {"lower": 0, "upper": 10}},
            "observations": [*observations, {"series": "p", "points": {"x": [1, 2], "y": [2.9, 3.1]}, "error": 0.1}],
            "method": {"kind": "particle_swarm", "particles": 4},
            "stopping": {"max_evaluations": 8},
        }
        | ({} if weighting is None else {"weighting": weighting})
    )
    assert parse_problem(made.document()) == made
    return made


def readings(noise: FloatArray, series: str = "q", x: FloatArray = X, **keys: Any) -> dict[str, Any]:
    y = 3.0 * x + 50.0 * np.sin(x / 300.0) + noise
    return {"series": series, "points": {"x": x.tolist(), "y": y.tolist()}, "error": 20.0, **keys}


def parts(made: Problem) -> dict[str, float]:
    """w_g f_g at a = 3, over that of p."""
    calibration = Calibration(made, 0)
    found = calibration.evaluate(np.array([3.0])).misfits
    whole = {o.series: o.weight * found[o.series] for o in made.observations}
    return {series: part / whole["p"] for series, part in whole.items()}


@pytest.mark.parametrize("weighting", WEIGHTINGS)
@settings(max_examples=10)
@given(every=st.integers(2, 40), seed=st.integers(0, 10_000))
def test_what_a_series_weighs_does_not_change(weighting: str | None, every: int, seed: int) -> None:
    noise = 1e-6 * np.random.default_rng(seed).standard_normal(len(X))  # else means would take it away
    whole = problem([readings(noise, error=1e-6)], weighting)
    thinned = problem([readings(noise, error=1e-6, resample={"every": every})], weighting)
    assert thinned.observations[0].x.size == -(-len(X) // every)
    # means of a curve are not on it, and span less than it; everything else stays
    assert parts(thinned)["q"] == pytest.approx(parts(whole)["q"], rel=0.01 if weighting != "by_range" else 0.1)


def test_a_mean_of_ten_readings_does_not_count_tenfold() -> None:
    noise = np.zeros(len(X))
    misfits = [
        Calibration(problem([readings(noise, **keys)], None), 0).evaluate(np.array([2.0])).misfits["q"]
        for keys in ({}, {"resample": {"every": 10}}, {"resample": {"every": 100}}, {"resample": {"per_decade": 200}})
    ]
    assert misfits[1:] == pytest.approx([misfits[0]] * 3, rel=0.01)


@pytest.mark.parametrize("weighting", ["by_count", "by_error"])
def test_a_series_in_two_parts_weighs_what_it_did(weighting: str) -> None:
    noise = 20.0 * np.random.default_rng(3).standard_normal(len(X))
    whole = parts(problem([readings(noise)], weighting))
    halves = problem(
        [
            readings(noise[:300], x=X[:300], resample={"every": 3}),
            readings(noise[300:], "r", X[300:], resample={"every": 30}),
        ],
        weighting,
    )
    assert [o.readings for o in halves.observations] == [300, 900, 2]
    split = problem([readings(noise[:300], x=X[:300]), readings(noise[300:], "r", X[300:])], weighting)
    assert parts(split)["q"] + parts(split)["r"] == pytest.approx(whole["q"], rel=1e-9)
    factors = {o.series: o.weight for o in halves.observations}
    assert factors["q"] / factors["r"] == pytest.approx(1.0 / 3.0, rel=1e-9)


def test_independent_errors_become_smaller_in_means_and_common_ones_do_not() -> None:
    noise = np.random.default_rng(1)
    white = 20.0 * noise.standard_normal(len(X))
    drift = 20.0 * np.sin(X / 100.0 + 1.0)
    found = problem([readings(white, resample={"every": 10})], None).observations[0]
    assert found.error == pytest.approx(20.0 / np.sqrt(10.0), rel=1e-12)
    assert found.notes[-1] == "the error of a mean of n readings counts as the error of a reading over the root of n"
    logger = problem([readings(drift, resample={"every": 10})], None).observations[0]
    assert logger.error == pytest.approx(20.0, rel=0.01)
    assert "the 1200 readings count as 120 independent ones of this error" in logger.notes[-1]
    assert logger.given_error == 20.0


def test_errors_of_two_kinds() -> None:
    """Independent errors of variance 1/4 beside common ones: a mean of 8 is worth 1 / (1 / 32 + 3 / 4)."""
    noise = 0.5 * np.random.default_rng(2).standard_normal(80_000)
    x = np.arange(80_000.0)
    worth, _ = independent_readings(x, 2.0 * x + noise, np.arange(0, 80_000, 8), 1.0)
    assert worth / 10_000 == pytest.approx(1.0 / (0.25 / 8 + 0.75), rel=0.02)


def test_few_of_the_means_hold_several_readings() -> None:
    x = np.array([0.0, 1.0, 1.0, 2.0, 3.0])
    begins = np.array([0, 1, 3, 4])
    assert independent_readings(x, 10.0 * x, begins, 1e-3)[0] == pytest.approx(4.0)  # no scatter at all at x = 1
    assert independent_readings(x, x + np.array([0, 1, -1, 0, 0]), begins, 1.0)[0] == pytest.approx(5.0)
    assert independent_readings(x, x, np.arange(5), 1.0)[0] == 5.0


@pytest.mark.parametrize("more", [{"independent": 2.1}, {"readings": [10, 10], "independent": 20.5}])
def test_no_more_readings_are_independent_than_there_are(more: dict[str, Any]) -> None:
    observation = {"series": "q", "points": {"x": [1, 2], "y": [3, 6], **more}, "error": 20.0}
    with pytest.raises(ProblemError, match=r"points\.independent.* at most as many can be independent"):
        problem([observation], None)


def test_noise_that_is_given_afterwards_is_that_of_a_reading_as_error_is() -> None:
    noise = 24.0 * np.random.default_rng(5).standard_normal(len(X))  # no less than the error that is stated
    made = problem([readings(noise, resample={"every": 10})], None)
    stated, given = problem_noise(made), known_noise(made, {"q": 20.0, "p": 0.1})
    assert stated is not None
    assert given.deviations == stated.deviations
    assert given.deviations["q"] == pytest.approx(20.0 / math.sqrt(10.0), rel=0.02)
