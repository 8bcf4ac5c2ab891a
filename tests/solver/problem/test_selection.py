"""Readings that take no part: by x, by the time since the load, and by stage."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import reweighted_problem
from geoswarm.solver.problem import Problem, parse_problem

X = [0.5, 10.0, 60.0, 1440.0, 1440.5, 1500.0, 2880.0]  # min; a load at 0 and at 1440


def staged(series: str = "settlement", **selection: Any) -> Problem:
    stage = series.startswith("stage_")
    x = [1.0, 2.0] if stage else X
    return parse_problem(
        {
            "forward_model": {
                "kind": "oedometer",
                "material": "soft_soil_creep",
                "discretization": "material_point",
                "height": 0.02,
                "initial_stress": 5.0,
                "stages": [{"stress": 10, "duration": 1}, {"stress": 20, "duration": 1}],
            },
            "parameters": {"lambda_star": {"lower": 0.01, "upper": 0.3}}
            | {n: {"value": v} for n, v in {"kappa_star": 0.01, "mu_star": 0.002, "c": 5, "phi": 25, "psi": 0}.items()},
            "observations": [
                {"series": series, "points": {"x": x, "y": list(range(len(x)))}, "y_unit": "mm"}
                | ({} if stage else {"x_unit": "min"})
                | selection
            ],
            "stopping": {"max_evaluations": 10},
        }
    )


@pytest.mark.parametrize(
    ("selection", "kept"),
    [
        ({"x_from": 10}, [1, 2, 3, 4, 5, 6]),
        ({"x_from": 10, "x_to": 1440}, [1, 2, 3]),
        ({"stage_x_from": 30}, [2, 3, 5, 6]),
        ({"leave_out_stages": [1]}, [4, 5, 6]),
        ({"stage_x_from": 30, "leave_out_stages": [2]}, [2, 3]),
    ],
)
def test_what_takes_part(selection: dict[str, Any], kept: list[int]) -> None:
    problem = staged(**selection)
    (observation,) = problem.observations
    np.testing.assert_allclose(observation.y * 1e3, kept, rtol=1e-12)
    assert observation.left_out == len(X) - len(kept)
    # the file keeps all points, and reads back as the same
    document = problem.document()
    assert len(document["observations"][0]["points"]["x"]) == len(X)
    assert parse_problem(document).document() == document
    weighted = reweighted_problem(problem, point_weights={"settlement": [2.0] * len(kept)})
    np.testing.assert_array_equal(weighted.observations[0].x, observation.x)


def test_stages_by_their_number() -> None:
    np.testing.assert_array_equal(staged("stage_settlement", leave_out_stages=[1]).observations[0].x, [2.0])


@pytest.mark.parametrize(
    ("selection", "words"),
    [
        ({"x_from": 20, "x_to": 10}, "below x_from"),
        ({"x_from": 5000}, "no point is left of 7"),
        ({"leave_out_stages": [1, 2]}, "leave_out_stages: no point is left"),
        ({"leave_out_stages": [0]}, "leave_out_stages"),
    ],
)
def test_what_cannot_be_left_out(selection: dict[str, Any], words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        staged(**selection)


def test_time_since_a_load_needs_stages_over_time() -> None:
    with pytest.raises(ProblemError, match="does not run over the time of a test in stages"):
        staged("stage_settlement", stage_x_from=1.0)
