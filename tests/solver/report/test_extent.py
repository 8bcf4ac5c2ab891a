"""Figures of extreme numbers: axes that can be drawn, no error and no warning of matplotlib."""

from __future__ import annotations

import itertools
import math
import warnings
from typing import Any

import pytest

from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.report.figures.extent import drawable
from geoswarm.solver.runs.local import calibrate

NUMBERS = (-math.inf, -1e308, -1.0, -5e-324, 0.0, 5e-324, 1e-300, 1e-150, 1.0, 1.0 + 1e-16, 1e300, math.inf, math.nan)


# all pairs; test_a_report_of_extreme_numbers draws some of them
@pytest.mark.slow
@pytest.mark.parametrize("log", [False, True])
def test_any_two_numbers_give_limits(log: bool) -> None:
    from matplotlib.figure import Figure

    for low, high in itertools.product(NUMBERS, NUMBERS):
        limits = drawable(low, high, log=log)
        assert limits[0] < limits[1]
        axes = Figure().add_subplot()
        if log:
            axes.set_xscale("log")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            axes.set_xlim(*limits)
        assert all(map(math.isfinite, axes.get_xlim()))


def test_ordinary_limits_stay() -> None:
    assert drawable(-1.5, 2.5) == (-1.5, 2.5)
    assert drawable(1e-9, 1e9, log=True) == (1e-9, 1e9)


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning", "ignore:invalid value:RuntimeWarning")
@pytest.mark.parametrize(
    ("scale", "changes", "threshold"),
    [
        (1.0, {"weight": 1e-300}, None),
        pytest.param(1.0, {"weight": 1e300}, None, marks=pytest.mark.slow),
        pytest.param(1e-200, {}, None, marks=pytest.mark.slow),
        (1e-310, {}, 5e-324),
        pytest.param(1e150, {}, None, marks=pytest.mark.slow),
        (1e153, {}, 1.7e308),
        pytest.param(1.0, {}, 1e-300, marks=pytest.mark.slow),
        (1.0, {}, 1.7e308),
    ],
)
def test_a_report_of_extreme_numbers(scale: float, changes: dict[str, Any], threshold: float | None) -> None:
    x = [0.0, 1.0, 2.0, 3.0]
    problem = parse_problem(
        {
            "name": "line",
            "forward_model": {"kind": "formula", "series": {"y": {"expression": "a + b * x"}}},
            "parameters": {"a": {"lower": 0.0, "upper": 3.0 * scale}, "b": {"lower": 0.0, "upper": 4.0 * scale}},
            "observations": [
                {"series": "y", "points": {"x": x, "y": [scale * (1.0 + 2.0 * v + 0.1 * v**2) for v in x]}, **changes}
            ],
            "method": {"kind": "monte_carlo", "samples": 60},
            "seed": 3,
        }
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error", UserWarning)
        page = report_of_result(problem, calibrate(problem), threshold=threshold).html()
    assert "<svg" in page
