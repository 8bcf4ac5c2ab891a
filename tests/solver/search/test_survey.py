"""Parameters that enter linearly show the basins of the others, whatever amplitudes the points had."""

from __future__ import annotations

import json
from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.descent.projection import project
from geoswarm.solver.search.descent.survey import Survey
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

T = np.linspace(0.0, 8.0, 60)
TRUTH = np.array([0.8, 0.3, 0.55])
LINEAR = (0, 1)


def residuals(unit: FloatArray) -> FloatArray:
    """An oscillation of unknown amplitude and mean: the frequency makes many basins."""
    amplitude, mean, frequency = unit
    wanted = TRUTH[0] * np.sin(5.0 * TRUTH[2] * T) + TRUTH[1]
    return np.asarray(amplitude * np.sin(5.0 * frequency * T) + mean - wanted)


def space(feasible: Callable[[FloatArray], bool] = lambda _: True) -> SearchSpace:
    names = ("amplitude", "mean", "frequency")
    return SearchSpace(names, np.zeros(3), np.ones(3), np.zeros(3, dtype=np.bool_), feasible)


def runs_at(points: FloatArray, failing: int | None = None) -> Runs:
    rows = np.array([residuals(point) for point in points])
    if failing is not None:
        rows[failing] = np.nan
    return Runs.of(points, rows)


def begun(searched: SearchSpace, centre: FloatArray) -> Survey:
    survey = Survey.begin(searched, centre, LINEAR)
    assert survey is not None
    return survey


def test_its_best_point_lies_in_the_basin_of_the_least_objective() -> None:
    centre = np.array([0.1, 0.9, 0.05])
    survey = begun(space(), centre)
    following = survey.advance(space(), runs_at(survey.asked))
    assert following is not None
    assert following.projected
    found = [float((residuals(point) ** 2).sum()) for point in following.asked]
    np.testing.assert_allclose(found, sorted(found), rtol=1e-12)
    tried = survey.asked[:: len(LINEAR) + 1, 2]
    assert following.asked[0, 2] == tried[np.argmin(np.abs(tried - TRUTH[2]))]


def test_linear_parameters_take_their_best_values_inside_the_bounds() -> None:
    survey = begun(space(), np.array([0.1, 0.9, 0.05]))
    following = survey.advance(space(), runs_at(survey.asked))
    assert following is not None
    for point in following.asked:
        columns = np.stack([np.sin(5.0 * point[2] * T), np.ones_like(T)], axis=1)
        wanted = -residuals(np.array([0.0, 0.0, point[2]]))
        np.testing.assert_allclose(point[:2], lsq_linear(columns, wanted, (0.0, 1.0), tol=1e-14).x, atol=1e-7)


def test_a_projection_is_the_solution_of_the_normal_equations_and_tells_its_objective() -> None:
    random = np.random.default_rng(2)
    columns, wanted = random.standard_normal((30, 2)), random.standard_normal(30)
    point = np.array([0.5, 0.4, 0.6])
    best, objective = project(space(), point, (0, 2), 0.01 * wanted, columns)
    step = np.linalg.solve(columns.T @ columns, -columns.T @ (0.01 * wanted))
    np.testing.assert_allclose(best, point + np.array([step[0], 0.0, step[1]]), rtol=1e-12)
    assert objective == pytest.approx(float(((0.01 * wanted + columns @ step) ** 2).sum()), rel=1e-12)


def test_a_projection_is_linear_in_natural_values_on_a_log_scale_too() -> None:
    """From 1 to 10^4: r = c p + r0, whatever the place at which the slope is known."""
    random = np.random.default_rng(3)
    column, wanted = random.standard_normal((30, 1)), random.standard_normal(30)
    searched = SearchSpace(("p",), np.array([1.0]), np.array([1e4]), np.array([True]), lambda _: True)
    best = 40.0
    wanted -= column[:, 0] * float(column[:, 0] @ wanted) / float(column[:, 0] @ column[:, 0])  # nothing of it in c
    for place in (0.2, 0.9):
        point = np.array([place])
        natural = float(searched.from_unit(point)[0])
        residuals_there = wanted + column[:, 0] * (natural - best)
        slope = column * natural * np.log(1e4)
        found, objective = project(searched, point, (0,), residuals_there, slope)
        assert searched.from_unit(found)[0] == pytest.approx(best, rel=1e-9)
        assert objective == pytest.approx(float(wanted @ wanted), rel=1e-9)


def test_constraints_hold_and_failed_points_are_left_out() -> None:
    low = space(lambda natural: bool(natural[2] < 0.7))
    survey = begun(low, np.array([0.1, 0.9, 0.05]))
    assert (survey.asked[:, 2] < 0.7).all()
    following = survey.advance(low, runs_at(survey.asked, failing=4))  # a move of the second point
    assert following is not None
    assert survey.asked[3, 2] not in following.asked[:, 2]
    assert survey.advance(low, Runs.of(survey.asked, np.full((len(survey.asked), T.size), np.nan))) is None


def test_there_is_none_without_both_kinds_of_parameters() -> None:
    centre = np.full(3, 0.5)
    assert Survey.begin(space(), centre, ()) is None
    assert Survey.begin(space(), centre, (0, 1, 2)) is None
    assert Survey.begin(space(lambda _: False), centre, LINEAR) is None


def test_its_state_is_plain_json() -> None:
    survey = begun(space(), np.full(3, 0.5))
    again = Survey.from_json(json.loads(json.dumps(survey.to_json())))
    np.testing.assert_array_equal(again.asked, survey.asked)
    assert (again.linear, again.projected) == (survey.linear, survey.projected)
