"""Slices and contours of the response surface against the forward model: what is drawn is right, and no more."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, StatisticsError
from geoswarm.solver.identifiability.stored.slices import SurfaceView, view_surface
from geoswarm.solver.identifiability.stored.surface import fit_surface
from geoswarm.solver.problem import Problem, parse_problem
from tests.solver.identifiability.cases import X, free, sampled

NOWHERE = np.empty((0, 2))
Y = 3.0 * np.exp(-0.8 * X) + np.random.default_rng(3).normal(0.0, 0.02, X.size)
DECAY = {"a": free(1.0, 10.0, "log"), "b": free(0.1, 3.0)}


@pytest.fixture(scope="module")
def decay() -> tuple[Problem, Samples]:
    return sampled("a * exp(-b * x)", DECAY, Y, 400)


def viewed(problem: Problem, samples: Samples, failed: np.ndarray = NOWHERE, **options: str) -> SurfaceView:
    calibration = Calibration(problem, 1)
    limit = 1.2 * float(samples.objectives.min())
    return view_surface(calibration, fit_surface(calibration, samples), samples, failed, limit, **options)


def test_what_is_drawn_is_what_the_model_calculates(decay: tuple[Problem, Samples]) -> None:
    problem, samples = decay
    view, calibration = viewed(problem, samples), Calibration(problem, 1)
    assert view.trusted
    assert view.error < 0.1
    best = samples.parameters[samples.best]
    for index, (values, objectives) in enumerate(view.slices):
        assert np.isclose(values, best[index], rtol=1e-12).any()
        for value, objective in zip(values[::7], objectives[::7], strict=True):
            place = best.copy()
            place[index] = value
            found = calibration.evaluate(place).objective
            assert objective == pytest.approx(found, rel=0.3, abs=0.3 * view.limit)
    known = np.argwhere(np.isfinite(view.contours))[::97]
    assert len(known) > 10
    for row, column in known:
        found = calibration.evaluate(np.array([view.x[column], view.y[row]])).objective
        assert view.contours[row, column] == pytest.approx(found, rel=0.3, abs=0.3 * view.limit)
    assert view.importance is not None
    assert view.importance.sum() == pytest.approx(1.0)
    json.dumps(view.to_json(), allow_nan=False)


def test_nothing_is_drawn_around_failed_runs_and_where_a_constraint_forbids_it(
    decay: tuple[Problem, Samples],
) -> None:
    problem, samples = decay
    best = samples.parameters[samples.best]
    failed = best * [1.0, 1.02]
    around = viewed(problem, samples, failed[None])
    row, column = np.abs(around.y - failed[1]).argmin(), np.abs(around.x - failed[0]).argmin()
    assert np.isnan(around.contours[row, column])
    assert np.isfinite(viewed(problem, samples).contours[row, column])
    assert around.to_json()["runs"]["objectives"][-1] is None
    limited = parse_problem(problem.document() | {"constraints": [f"b > {best[1]}"]})
    below = limited.free_names.index("b")
    values, objectives = viewed(limited, samples).slices[below]
    assert np.isnan(objectives[values < best[1]]).all()
    assert np.isfinite(objectives[values > best[1]]).any()


def test_a_surface_that_misses_runs_left_out_is_not_drawn() -> None:
    view = viewed(*sampled("sin(40 * a) * x + sin(40 * b)", {"a": free(), "b": free()}, X, 300))
    assert not view.trusted
    assert view.error > 0.3
    assert np.isnan(view.contours).all()
    assert all(np.isnan(objectives).all() for _, objectives in view.slices)
    assert view.importance is None
    json.dumps(view.to_json(), allow_nan=False)


def test_a_parameter_without_influence_has_no_importance_and_a_flat_slice() -> None:
    problem, samples = sampled("a * x + 0 * b", {"a": free(1.0, 5.0), "b": free(1.0, 2.0)}, 3.0 * X + 0.1, 300)
    view = viewed(problem, samples)
    assert view.importance is not None
    np.testing.assert_allclose(view.importance, [1.0, 0.0], atol=1e-3)
    objectives = view.slices[1][1]
    np.testing.assert_allclose(objectives[np.isfinite(objectives)], samples.objectives.min(), rtol=0.05)


def test_axes_are_chosen_and_one_parameter_has_slices_alone(decay: tuple[Problem, Samples]) -> None:
    turned = viewed(*decay, x="b").to_json()["contours"]
    assert (turned["x"], turned["y"]) == ("b", "a")
    upright = viewed(*decay, y="a").to_json()["contours"]
    assert (upright["x"], upright["y"]) == ("b", "a")
    with pytest.raises(StatisticsError, match="'c' is no free parameter; there are a, b"):
        viewed(*decay, x="c")
    with pytest.raises(StatisticsError, match="two different parameters, 'a' was given twice"):
        viewed(*decay, x="a", y="a")
    alone = viewed(*sampled("a * x", {"a": free(1.0, 5.0)}, 3.0 * X, 100), np.empty((0, 1))).to_json()
    assert alone["contours"] is None
    assert [one["parameter"] for one in alone["slices"]] == ["a"]
