"""Sorting, readings at equal x and thinning, before readings become observations."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Observation, parse_problem
from geoswarm.solver.problem.readings.preparation import many_points_warning
from tests.solver.problem.test_columns import mistakes, observed
from tests.solver.problems import decay_document


def points(x: list[float], y: list[float], weight: list[float] | None = None, **keys: Any) -> Observation:
    given: dict[str, Any] = {"x": x, "y": y} | ({} if weight is None else {"weight": weight})
    problem = parse_problem(decay_document(observations=[{"series": "y", "points": given, **keys}]))
    assert parse_problem(problem.document()) == problem
    return problem.observations[0]


def test_readings_are_sorted_with_all_that_belongs_to_them() -> None:
    found = points([3.0, 1.0, 2.0], [30.0, 10.0, 20.0], [0.3, 0.1, 0.2], sort=True)
    assert (found.x.tolist(), found.y.tolist(), found.point_weights.tolist()) == (
        [1, 2, 3],
        [10, 20, 30],
        [0.1, 0.2, 0.3],
    )


def test_readings_at_equal_x() -> None:
    x, y = [1.0, 1.0, 2.0, 4.0, 4.0, 4.0], [10.0, 20.0, 30.0, 1.0, 2.0, 6.0]
    mean = points(x, y, repeated_x="average")
    assert (mean.x.tolist(), mean.y.tolist(), mean.point_weights.tolist()) == ([1, 2, 4], [15, 30, 3], [1, 0.5, 1.5])
    assert mean.readings == 6
    weighted = points(x, y, [1.0, 3.0, 1.0, 0.0, 0.0, 0.0], repeated_x="average")
    assert (weighted.y.tolist(), weighted.point_weights.tolist()) == ([17.5, 30, 3], [2, 0.5, 0])
    shifted = points(x, y, repeated_x="shift")
    np.testing.assert_allclose(shifted.x, [1, 1.5, 2, 4, 4 + 2 / 3, 4 + 4 / 3])
    assert shifted.y.tolist() == y
    assert points([1.0, 2.0], [1.0, 2.0], repeated_x="average").points.weight is None


def test_a_mistake_names_the_option(tmp_path: Path) -> None:
    equal = mistakes(tmp_path, "a.csv", "x [day],y [m]\n1,0.1\n1,0.2\n2,0.3\n")
    assert "x = 1 day (point 2) follows x = 1 day (point 1); repeated_x: average or shift makes them differ" in equal
    assert "; sort: true sorts" in mistakes(tmp_path, "a.csv", "x [day],y [m]\n2,0.1\n1,0.2\n")
    assert observed(
        tmp_path, "a.csv", "x [day],y [m]\n2,1\n1,2\n1,4\n", sort="true", repeated_x="average"
    ).y.tolist() == [3, 1]


def test_very_many_readings_become_few() -> None:
    x = np.geomspace(1e-3, 10.0, 4001)
    y = 3.0 * np.exp(-0.7 * x)
    found = points(x.tolist(), y.tolist(), resample={"per_decade": 20})
    assert 80 <= len(found.x) <= 81
    assert found.point_weights.mean() == pytest.approx(1.0, rel=1e-12)
    assert found.readings == 4001
    assert abs(found.y - 3.0 * np.exp(-0.7 * found.x)).max() < 2e-3  # means lie close to the curve
    every = points(x.tolist(), y.tolist(), resample={"every": 10})
    assert len(every.x) == 401
    assert every.y[0] == pytest.approx(y[:10].mean())
    assert every.point_weights[-1] == pytest.approx(0.1 * every.point_weights[0], rel=1e-12)
    from_zero = points([0.0, 0.001, 0.0011, 10.0], [1.0, 2.0, 3.0, 4.0], resample={"per_decade": 1})
    assert from_zero.x.tolist() == [0.0, pytest.approx(0.00105), 10.0]


def test_one_way_to_thin() -> None:
    with pytest.raises(ProblemError, match="give either per_decade or every"):
        points([1.0], [1.0], resample={"per_decade": 20, "every": 2})
    assert many_points_warning("y", 20_000) is None
    assert "resample: {per_decade: 20}" in str(many_points_warning("y", 20_001))


def test_a_large_file_of_numbers_is_read_the_quick_way_to_the_same_numbers(tmp_path: Path) -> None:
    rows = [f"{i * 1e-4:.6g},{np.sin(i):.17g}" for i in range(12_000)]
    quick = observed(tmp_path, "a.csv", "x [day],y [m]\n" + "\n".join(rows) + "\n")
    slow = observed(tmp_path, "b.csv", "x [day],y [m]\n# a remark\n" + "\n".join(rows) + "\n")
    np.testing.assert_array_equal(quick.x, slow.x)
    np.testing.assert_array_equal(quick.y, slow.y)
    assert (quick.x_unit, slow.x_unit) == ("day", "day")
    for wrong, message in (
        ("1,2,3", "line 12002: 3 cells under 2 headings"),
        ("1,", "line 12002, column y: the cell is empty"),
    ):
        assert message in mistakes(tmp_path, "c.csv", "x,y\n" + "\n".join([*rows, wrong]) + "\n")
