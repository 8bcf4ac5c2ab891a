from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.search.acceleration.local_models import gauss_newton_point, quadratic_point

RANDOM = np.random.default_rng(7)


@pytest.mark.parametrize("dimension", [1, 2, 5, 12])
def test_gauss_newton_solves_linear_residuals_at_once(dimension: int) -> None:
    target = np.full(dimension, 0.45)
    points = 0.4 + 0.1 * RANDOM.random((3 * dimension + 6, dimension))
    residuals = (points - target) @ RANDOM.normal(size=(dimension, dimension + 4))
    centre = int(np.argmin((residuals**2).sum(axis=1)))
    np.testing.assert_allclose(gauss_newton_point(points, residuals, centre, 10.0), target, atol=1e-3)


def test_a_step_stays_in_reach_and_inside_the_bounds() -> None:
    points = 0.9 + 0.1 * RANDOM.random((8, 2))
    far = points - 5.0
    step = gauss_newton_point(points, far, 0, 0.5) - points[0]
    farthest = np.linalg.norm(points - points[0], axis=1).max()
    assert np.abs(step).max() <= 0.5 * farthest + 1e-12
    assert gauss_newton_point(points, -far, 0, 9.0).max() <= 1.0


@pytest.mark.parametrize("dimension", [1, 2, 4])
def test_the_minimum_of_a_quadratic_is_found_at_once(dimension: int) -> None:
    target = np.full(dimension, 0.52)
    points = 0.45 + 0.1 * RANDOM.random((60, dimension))
    shape = np.eye(dimension) + 0.3
    objectives = np.einsum("ni,ij,nj->n", points - target, shape, points - target) + 2.0
    found = quadratic_point(points, objectives, int(np.argmin(objectives)), 2.0)
    assert found is not None
    np.testing.assert_allclose(found, target, atol=1e-3)


def test_too_few_points_give_no_quadratic() -> None:
    assert quadratic_point(RANDOM.random((4, 3)), np.arange(4.0), 0, 1.0) is None
