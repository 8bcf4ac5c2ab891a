"""Readings that take no part: by x, by the time since the load, and by stage."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import reweighted_problem
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.draft import inlined_document

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


def readings_at(x: list[float], y: list[float], **keys: Any) -> Problem:
    return staged(points={"x": x, "y": y}, **keys)


AT_1440 = [1.0, 1.0, 1440.0, 1440.0, 1441.0]  # min
BEFORE_AND_AFTER = [0.0, 0.02, 0.1, 0.5, 0.6]  # mm


@pytest.mark.parametrize("keys", [{"repeated_x": "average"}, {"resample": {"every": 2}}])
def test_no_mean_is_taken_across_a_load(keys: dict[str, Any], tmp_path: Path) -> None:
    words = r"repeated_x: 2 readings at x = 1440, where stage 2 begins, are from 0.1 to 0.5: .* repeated_x: shift"
    with pytest.raises(ProblemError, match=words):
        readings_at(AT_1440, BEFORE_AND_AFTER, x_factor=1.0, **keys)
    rows = "".join(f"{x / 60.0!r},{y!r}\n" for x, y in zip(AT_1440, BEFORE_AND_AFTER, strict=True))
    (tmp_path / "a.csv").write_text("time [h],s [mm]\n" + rows, encoding="utf-8")
    document = staged().document()
    document["observations"] = [{"series": "settlement", "file": "a.csv", "x_column": "time", "y_column": "s", **keys}]
    (tmp_path / "problem.json").write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ProblemError, match="2 readings at x = 24, where stage 2 begins"):
        inlined_document(tmp_path / "problem.json")


def test_means_end_at_a_load() -> None:
    (equal,) = readings_at(AT_1440, [0.0, 0.02, 0.1, 0.1, 0.6], repeated_x="average").observations
    np.testing.assert_allclose(equal.y * 1e3, [0.01, 0.1, 0.6], rtol=1e-12)
    (shifted,) = readings_at(AT_1440, BEFORE_AND_AFTER, repeated_x="shift").observations
    np.testing.assert_allclose(shifted.x[2:4] * 1440.0, [1440.0, 1440.5], rtol=1e-12)
    (few,) = readings_at(X, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0], resample={"every": 3}).observations
    np.testing.assert_allclose(few.y * 1e3, [1.0, 3.0, 4.5, 6.0], rtol=1e-12)
    (few,) = readings_at(X[2:5], [0.0, 1.0, 2.0], resample={"per_decade": 1}).observations
    np.testing.assert_allclose(few.y * 1e3, [0.0, 1.0, 2.0], rtol=1e-12)


def test_several_gauges_are_averaged_at_a_load_as_at_every_other_time() -> None:
    x = [1.0, 1.0, 60.0, 60.0, 1440.0, 1440.0, 1450.0, 1450.0]
    y = [0.0, 0.02, 0.1, 0.12, 0.2, 0.24, 0.5, 0.52]
    (mean,) = readings_at(x, y, repeated_x="average").observations
    np.testing.assert_allclose(mean.x * 1440.0, [1.0, 60.0, 1440.0, 1450.0], rtol=1e-12)
    np.testing.assert_allclose(mean.y * 1e3, [0.01, 0.11, 0.22, 0.51], rtol=1e-12)
    before_and_after = [*x[:6], 1440.0, 1440.0, *x[6:]]
    (both,) = readings_at(before_and_after, [*y[:6], 0.4, 0.42, *y[6:]], repeated_x="average").observations
    np.testing.assert_allclose(both.x * 1440.0, [1.0, 60.0, 1440.0, 1445.0, 1450.0], rtol=1e-12)
    np.testing.assert_allclose(both.y * 1e3, [0.01, 0.11, 0.22, 0.41, 0.51], rtol=1e-12)
    assert "at a load, the first 2 of 4 readings are those before it" in " ".join(both.notes)
    with pytest.raises(ProblemError, match="average takes the mean of several gauges, where every x has a reading of"):
        readings_at([*x[:6], 1440.0, *x[6:]], [*y[:6], 0.4, *y[6:]], repeated_x="average")


def test_the_remedy_for_equal_times_at_a_load_is_to_shift() -> None:
    with pytest.raises(ProblemError, match=r"follows x = 1440 min \(point 1\); repeated_x: shift takes the first"):
        readings_at([1440.0, 1440.0, 1441.0], [0.1, 0.5, 0.6])
