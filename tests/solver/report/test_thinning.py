"""Figures of very many points: small, and nothing that sticks out is lost."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.curves import MOST_SHOWN, shown
from geoswarm.solver.report.document.build import report_of_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.problems import decay_document


def many(count: int) -> Problem:
    x = np.linspace(0.0, 5.0, count)
    y = 3.0 * np.exp(-0.7 * x) + 0.01 * np.random.default_rng(3).standard_normal(count)
    points = {"x": x.tolist(), "y": y.tolist()}
    return parse_problem(
        decay_document(observations=[{"series": "y", "points": points}], stopping={"max_evaluations": 24})
    )


def test_extremes_and_ends_are_kept() -> None:
    random = np.random.default_rng(1)
    first, second = random.standard_normal(300_000), random.standard_normal(300_000)
    first[123_456], second[7] = 50.0, -60.0
    chosen = shown(first, second)
    assert len(chosen) <= MOST_SHOWN
    assert {0, 7, 123_456, 299_999} <= set(chosen.tolist())
    assert (np.diff(chosen) > 0).all()
    np.testing.assert_array_equal(shown(first[:4000]), np.arange(4000))


@pytest.mark.slow
def test_a_report_of_very_many_points_is_small() -> None:
    problem = many(200_000)
    report = report_of_result(problem, calibrate(problem))
    assert len(report.html()) < 10e6
    assert len(report.pdf()) < 10e6
    assert report.figures.csv("fit").count("\n") <= MOST_SHOWN + 1
