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
from geoswarm.solver.identifiability.weighting import BY_SPREAD, reweighted_problem, spread_weights
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.readings.preparation import independent_readings
from geoswarm.solver.problem.weighting import WEIGHTINGS, by_test, weight_shares

X = np.arange(1.0, 1201.0)
SCHEMES = [None, *WEIGHTINGS, BY_SPREAD]
LINES = {"kind": "formula", "series": {"q": "a * x", "r": "a * x", "p": "a + 0 * x"}}
P = {"series": "p", "points": {"x": [1, 2], "y": [2.9, 3.1]}, "error": 0.1}


def problem(observations: list[dict[str, Any]], weighting: str | None, model: dict[str, Any] = LINES) -> Problem:
    """Series q and r of the same line, and p with two readings."""
    prefix = "one." if "parts" in model else ""
    sections = [{**o, "series": prefix + o["series"]} for o in [*observations, P]]
    made = parse_problem(
        {
            "name": "thinned",
            "forward_model": model,
            "parameters": {"a": {"lower": 0, "upper": 10}},
            "observations": [*sections, *([{**P, "series": "other.p"}] if prefix else [])],
            "method": {"kind": "particle_swarm", "particles": 4},
            "stopping": {"max_evaluations": 8},
        }
        | ({} if weighting in (None, BY_SPREAD) else {"weighting": weighting})
    )
    assert parse_problem(made.document()) == made
    if weighting == BY_SPREAD:
        fitted = Calibration(made, 0).evaluate(np.array([2.9])).responses
        return reweighted_problem(made, point_weights=spread_weights(made, fitted))
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


WAYS = st.one_of(
    st.integers(2, 40).map(lambda every: {"resample": {"every": every}}),
    st.integers(20, 200).map(lambda number: {"resample": {"per_decade": number}}),
    st.integers(2, 40).map(lambda every: {"resample": {"every": every}, "x_to": 900.0}),
)


@pytest.mark.parametrize("weighting", SCHEMES)
@settings(max_examples=8)
@given(way=WAYS, seed=st.integers(0, 10_000))
def test_what_a_series_weighs_does_not_change(weighting: str | None, way: dict[str, Any], seed: int) -> None:
    noise = 1e-6 * np.random.default_rng(seed).standard_normal(len(X))  # else means would take it away
    kept = {key: value for key, value in way.items() if key == "x_to"}
    whole = problem([readings(noise, error=1e-6, **kept)], weighting)
    thinned = problem([readings(noise, error=1e-6, **way)], weighting)
    assert thinned.observations[0].x.size < whole.observations[0].x.size
    # means of a curve are not on it, and those beside x_to may have readings beyond it
    assert parts(thinned)["q"] == pytest.approx(parts(whole)["q"], rel=0.1 if kept or weighting == BY_SPREAD else 0.02)


@pytest.mark.parametrize("weighting", SCHEMES)
@pytest.mark.parametrize("repeats", [3, 50])
def test_repeats_that_are_averaged_weigh_what_they_did(weighting: str | None, repeats: int) -> None:
    x = np.repeat(np.arange(1.0, 41.0), repeats)
    x = np.concatenate([x, np.arange(41.0, 81.0)])  # so that means of many stand beside single readings
    noise = 1e-6 * np.random.default_rng(repeats).standard_normal(len(x))
    whole = problem([readings(noise, x=x, error=1e-6)], weighting)
    averaged = problem([readings(noise, x=x, error=1e-6, repeated_x="average")], weighting)
    assert averaged.observations[0].x.size == 80
    assert parts(averaged)["q"] == pytest.approx(parts(whole)["q"], rel=0.01)


def test_a_mean_of_ten_readings_does_not_count_tenfold() -> None:
    noise = np.zeros(len(X))
    misfits = [
        Calibration(problem([readings(noise, **keys)], None), 0).evaluate(np.array([2.0])).misfits["q"]
        for keys in ({}, {"resample": {"every": 10}}, {"resample": {"every": 100}}, {"resample": {"per_decade": 200}})
    ]
    assert misfits[1:] == pytest.approx([misfits[0]] * 3, rel=0.01)


def pieces(place: int, **keys: Any) -> list[dict[str, Any]]:
    """The readings of q in two series."""
    noise = 20.0 * np.random.default_rng(3).standard_normal(len(X))
    return [readings(noise[:place], x=X[:place], **keys), readings(noise[place:], "r", X[place:], **keys)]


def unsplit() -> dict[str, Any]:
    return readings(20.0 * np.random.default_rng(3).standard_normal(len(X)))


@pytest.mark.parametrize("weighting", ["by_count", "by_error"])
@settings(max_examples=6)
@given(place=st.integers(2, len(X) - 2))
def test_a_series_in_two_weighs_what_it_did(weighting: str, place: int) -> None:
    split = parts(problem(pieces(place), weighting))
    assert split["q"] + split["r"] == pytest.approx(parts(problem([unsplit()], weighting))["q"], rel=1e-9)


@settings(max_examples=6)
@given(place=st.integers(2, len(X) - 2))
def test_without_a_scheme_weights_by_readings_are_those_of_the_whole_series(place: int) -> None:
    """Equation (1) is a sum over series: without weights, two count twice."""
    split = pieces(place)
    for one in split:
        one["weight"] = len(one["points"]["x"]) / len(X)
    found = parts(problem(split, None))
    assert found["q"] + found["r"] == pytest.approx(parts(problem([unsplit()], None))["q"], rel=1e-9)


@settings(max_examples=6)
@given(seed=st.integers(0, 10_000))
def test_relative_to_the_range_two_series_of_one_range_share_its_weight(seed: int) -> None:
    noise = 20.0 * np.random.default_rng(3).standard_normal(len(X))
    first = np.random.default_rng(seed).random(len(X)) < 0.5
    first[[0, -1]] = True
    split = [readings(noise[own], name, X[own]) for name, own in (("q", first), ("r", ~first))]
    for one in split:
        one["weight"] = len(one["points"]["x"]) / len(X)
    found = parts(problem(split, "by_range"))
    assert found["q"] + found["r"] == pytest.approx(parts(problem([unsplit()], "by_range"))["q"], rel=0.05)


@settings(max_examples=6)
@given(place=st.integers(2, len(X) - 2), every=st.integers(2, 40))
def test_by_test_neither_splitting_nor_thinning_moves_the_share_of_a_test(place: int, every: int) -> None:
    model = {"kind": "combined", "parts": {"one": LINES, "other": LINES}}
    for observations in ([unsplit()], pieces(place), pieces(place, resample={"every": every})):
        shares = weight_shares(problem(observations, "by_test", model))
        assert by_test(shares) == pytest.approx({"one": 0.5, "other": 0.5}, rel=1e-12)
        inside = [one.share for one in shares if one.test == "one"]
        assert inside == pytest.approx([0.5 / len(inside)] * len(inside), rel=1e-12)


def test_series_that_are_thinned_differently_count_by_their_readings() -> None:
    noise = 20.0 * np.random.default_rng(3).standard_normal(len(X))
    halves = [
        readings(noise[:300], x=X[:300], resample={"every": 3}),
        readings(noise[300:], "r", X[300:], resample={"every": 30}),
    ]
    for weighting in ("by_count", "by_error"):
        made = problem(halves, weighting)
        assert [o.readings for o in made.observations] == [300, 900, 2]
        factors = {o.series: o.weight for o in made.observations}
        assert factors["q"] / factors["r"] == pytest.approx(1.0 / 3.0, rel=1e-9)
        assert [one.readings for one in weight_shares(made)] == pytest.approx([300, 900, 2], rel=1e-9)


def test_independent_errors_become_smaller_in_means_and_common_ones_do_not() -> None:
    noise = np.random.default_rng(1)
    white = 20.0 * noise.standard_normal(len(X))
    drift = 20.0 * np.sin(X / 100.0 + 1.0)
    found = problem([readings(white, resample={"every": 10})], None).observations[0]
    assert found.error == pytest.approx(20.0 / np.sqrt(10.0), rel=1e-12)
    assert found.notes[-1] == "the error of a mean of n readings counts as the error of a reading over the root of n"
    logger = problem([readings(drift, resample={"every": 10})], None).observations[0]
    assert logger.error == pytest.approx(20.0, rel=0.01)
    assert "the 1200 readings are equivalent to 120 independent ones of this error" in logger.notes[-1]
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
