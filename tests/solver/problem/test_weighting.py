"""Weighting schemes of the problem file."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import parse_problem


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
