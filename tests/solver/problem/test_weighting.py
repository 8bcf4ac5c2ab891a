"""Weighting schemes of the problem file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.problem.weighting import by_test, weight_shares


def document(**changes: Any) -> dict[str, Any]:
    return {
        "forward_model": {
            "kind": "formula",
            "series": {
                "s": {"expression": "a * x", "x_unit": "day", "y_unit": "m"},
                "p": {"expression": "b * x", "x_unit": "day", "y_unit": "kPa"},
            },
        },
        "parameters": {"a": {"lower": 0, "upper": 1}, "b": {"lower": 0, "upper": 1}},
        "observations": [
            {"series": "s", "points": {"x": [1, 2, 3], "y": [1, 2, 5]}, "y_unit": "mm", "error": 0.5, "weight": 2.0},
            {"series": "p", "points": {"x": [1, 2], "y": [10, 30]}, "error": 4.0},
        ],
        "stopping": {"max_evaluations": 10},
    } | changes


@pytest.mark.parametrize(
    ("weighting", "ratio"),
    [("by_error", (3 / 0.0005**2) / (2 / 4.0**2)), ("by_count", 3 / 2), ("by_range", (1 / 0.004**2) / (1 / 20.0**2))],
)
def test_a_scheme_multiplies_the_given_weights(weighting: str, ratio: float) -> None:
    problem = parse_problem(document(weighting=weighting))
    first, second = problem.observations
    np.testing.assert_allclose(first.weight / second.weight, 2.0 * ratio, rtol=1e-12)
    np.testing.assert_allclose(first.error, 0.0005, rtol=1e-12)
    again = parse_problem(problem.document())
    assert again == problem
    assert [o.weight for o in again.observations] == [first.weight, second.weight]
    assert problem.document()["weighting"] == weighting


def two_tests(**changes: Any) -> dict[str, Any]:
    """Two tests of three and one series; of the first test one series is shown only."""
    one = document()["forward_model"]
    readings = {"x": [1, 2, 3], "y": [1, 2, 5]}
    return {
        "forward_model": {"kind": "combined", "parts": {"dense": one, "loose": one}},
        "parameters": document()["parameters"],
        "observations": [
            {"series": "dense.s", "points": readings},
            {"series": "dense.p", "points": {"x": [1, 2], "y": [0, 400]}},
            {"series": "loose.p", "points": readings},
        ],
        "stopping": {"max_evaluations": 10},
    } | changes


def test_by_test_every_test_counts_alike_and_the_series_in_it() -> None:
    problem = parse_problem(two_tests(weighting="by_test"))
    weights = [o.weight for o in problem.observations]
    assert weights == pytest.approx([0.5, 0.5 / 100.0**2, 1.0], rel=1e-12)
    shares = weight_shares(problem)
    assert [one.share for one in shares] == pytest.approx([0.25, 0.25, 0.5], rel=1e-12)
    assert by_test(shares) == pytest.approx({"dense": 0.5, "loose": 0.5}, rel=1e-12)
    assert parse_problem(problem.document()) == problem


def test_a_series_that_is_only_shown_takes_nothing_from_its_test() -> None:
    observations = two_tests()["observations"]
    observations[1]["weight"] = 0
    problem = parse_problem(two_tests(weighting="by_test", observations=observations))
    assert by_test(weight_shares(problem)) == pytest.approx({"dense": 0.5, "loose": 0.5}, rel=1e-12)


def test_given_weights_multiply_those_of_a_test() -> None:
    observations = two_tests()["observations"]
    observations[2]["weight"] = 3.0
    problem = parse_problem(two_tests(weighting="by_test", observations=observations))
    assert by_test(weight_shares(problem)) == pytest.approx({"dense": 0.25, "loose": 0.75}, rel=1e-12)


def test_other_problems_are_one_test() -> None:
    problem = parse_problem(document(weighting="by_test"))
    assert {one.test for one in weight_shares(problem)} == {""}
    assert by_test(weight_shares(problem)) == {}
    ranged = parse_problem(document(weighting="by_range"))
    assert [o.weight for o in problem.observations] == [o.weight for o in ranged.observations]


def test_shares_say_how_many_readings_a_scheme_counts() -> None:
    means = {"x": [1, 2, 3], "y": [1, 2, 5], "readings": [10, 10, 10]}
    for more, worth in (({}, 3.0), ({"independent": 12.0}, 12.0)):
        observations = document()["observations"]
        observations[0]["points"] = means | more
        counted = {
            scheme: weight_shares(parse_problem(document(weighting=scheme, observations=observations)))[0].readings
            for scheme in ("by_error", "by_count", "by_range")
        }
        assert counted == {"by_error": pytest.approx(worth, rel=1e-12), "by_count": 30.0, "by_range": None}


def test_shares_of_extreme_weights_are_numbers() -> None:
    observations = two_tests()["observations"]
    observations[0] |= {"weight": 1e150, "points": {"x": [1, 2], "y": [-1e300, 1e300]}}
    shares = [one.share for one in weight_shares(parse_problem(two_tests(observations=observations)))]
    assert shares == [1.0, 0.0, 0.0]


def test_without_a_scheme_weights_are_those_given() -> None:
    problem = parse_problem(document())
    assert [o.weight for o in problem.observations] == [2.0, 1.0]
    assert "weighting" not in problem.document()


def test_by_error_needs_every_error() -> None:
    observations = document()["observations"]
    del observations[1]["error"]
    with pytest.raises(ProblemError, match=r"weighting: by_error needs the error of every observation; .* for p"):
        parse_problem(document(weighting="by_error", observations=observations))


@pytest.mark.parametrize("error", [0, -1.0])
def test_an_error_is_above_zero(error: float) -> None:
    observations = document()["observations"]
    observations[1]["error"] = error
    with pytest.raises(ProblemError, match=r"observations\[1\].error"):
        parse_problem(document(observations=observations))


def test_an_unknown_scheme_is_refused() -> None:
    with pytest.raises(ProblemError, match="by_error"):
        parse_problem(document(weighting="by_eye"))
