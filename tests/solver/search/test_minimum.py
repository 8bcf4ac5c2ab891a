"""Runs to a minimum and around it, from a point near by: how many, where, and what fails."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.descent.minimum import MinimumSearch
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace
from tests.solver.search.spaces import box

Model = Callable[[FloatArray], FloatArray]

SPACE = box(2, 0.0, 9.0)
T = np.linspace(0.0, 1.0, 12)
NOISE = np.random.default_rng(8).normal(0.0, 0.1, T.size)


def line(x: FloatArray) -> FloatArray:
    """Residuals of a straight line, whose data belong to (1, 2) and noise."""
    return np.asarray((x[0] - 1.0) + (x[1] - 2.0) * T + NOISE)


def curve(x: FloatArray) -> FloatArray:
    """Residuals of a curve that bends, whose data belong to (1, 2) and noise."""
    return np.asarray(x[0] * np.exp(-x[1] * T) - np.exp(-2.0 * T) + 0.01 * NOISE)


def followed(space: SearchSpace, model: Model, start: list[float], most: int) -> tuple[MinimumSearch, FloatArray]:
    """Ask and tell to the end, through JSON between generations; the search and all residuals."""
    search, positions, rows = MinimumSearch(space, np.array(start), most), [], []
    while (due := search.ask()) is not None:
        positions += list(due)
        rows += [model(x) for x in due]
        runs = Runs.of(np.array(positions), np.array(rows))
        search = MinimumSearch(space, np.array(start), most, json.loads(json.dumps(search.snapshot())))
        search.tell(runs.objectives[-len(due) :], runs)
    return search, np.array(rows)


def test_at_the_minimum_differences_and_ends_are_all() -> None:
    design = np.stack([np.ones_like(T), T], axis=1)
    minimum = np.array([1.0, 2.0]) - np.linalg.lstsq(design, NOISE, rcond=None)[0]
    search, rows = followed(SPACE, line, minimum.tolist(), 100)
    assert len(rows) == 9 + 4
    assert search.walk(rows).row == 0
    assert search.ends is not None


def test_one_step_leads_to_the_minimum_of_a_line_and_derivatives_are_taken_there_again() -> None:
    design = np.stack([np.ones_like(T), T], axis=1)
    minimum = np.array([1.0, 2.0]) - np.linalg.lstsq(design, NOISE, rcond=None)[0]
    search, rows = followed(SPACE, line, [4.0, 0.5], 100)
    assert len(rows) == 9 + 1 + 9 + 4
    np.testing.assert_allclose(search.place(search.walk(rows).row), minimum, atol=1e-6)
    # without room for that, the step is taken all the same, and said to lead too far
    search, rows = followed(SPACE, line, [4.0, 0.5], 15)
    assert len(rows) == 10
    assert search.walk(rows).far
    np.testing.assert_allclose(search.place(search.walk(rows).row), minimum, atol=1e-6)


def test_a_curve_takes_some_steps() -> None:
    search, rows = followed(SPACE, curve, [2.0, 5.0], 100)
    walk = search.walk(rows)
    assert not walk.far
    np.testing.assert_allclose(search.place(walk.row), [1.0, 2.0], atol=0.01)
    assert len(rows) < 60


@pytest.mark.parametrize("most", range(8, 40, 3))
def test_nothing_is_begun_that_does_not_fit(most: int) -> None:
    _, rows = followed(SPACE, curve, [2.0, 5.0], most)
    assert len(rows) <= most
    assert (len(rows) > 0) == (most >= 9)


def test_a_minimum_on_a_bound_is_found() -> None:
    search, rows = followed(replace(SPACE, lower=np.array([0.0, 2.5])), curve, [2.0, 5.0], 100)
    place = search.place(search.walk(rows).row)
    assert place[1] == pytest.approx(2.5, abs=1e-9)
    best = np.exp(-2.5 * T) @ (np.exp(-2.0 * T) - 0.01 * NOISE) / (np.exp(-2.5 * T) @ np.exp(-2.5 * T))
    assert place[0] == pytest.approx(best, rel=1e-3)


def test_a_failed_run_is_a_step_too_far() -> None:
    def fails_below(x: FloatArray) -> FloatArray:
        return np.where(x[1] < 1.8, np.nan, curve(x))

    search, rows = followed(SPACE, fails_below, [2.0, 5.0], 100)
    np.testing.assert_allclose(search.place(search.walk(rows).row), [1.0, 2.0], atol=0.01)


def test_nothing_follows_where_the_start_itself_fails() -> None:
    search, rows = followed(SPACE, lambda x: np.full(T.size, np.nan * x[0]), [2.0, 5.0], 100)
    assert len(rows) == 9
    assert search.ends is None


def test_a_step_below_the_spacing_of_floats_is_none() -> None:
    """Readings without error: the last steps are rounding, one came out as no step and made the derivatives nan."""
    x = np.array([0.5, 2.0, 4.0])
    start = [float.fromhex("0x1.038d34031cda3p+1"), float.fromhex("0x1.3eb5317cf82d2p+2")]
    for factor in (1.0, 1.0 / np.sqrt(3.0)):
        search, rows = followed(
            box(2, 0.1, 10.0), lambda at, f=factor: f * (at[0] * x + at[1] - 2.0 * x - 5.0), start, 100
        )
        np.testing.assert_allclose(search.place(search.walk(rows).row), [2.0, 5.0], rtol=1e-14)
        trials = [tuple(place) for place in search.snapshot()["trials"]]
        assert len(set(trials)) == len(trials) > 0
