from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration.residual_surface import Components, CubicSurface, ResidualSurface, minimise


def points(count: int, dimension: int) -> FloatArray:
    return np.random.default_rng(count).random((count, dimension))


def curved(at: FloatArray) -> FloatArray:
    """Three residuals that vanish at (0.4, 0.6)."""
    a, b = at[:, 0] - 0.4, at[:, 1] - 0.6
    return np.stack([a + 0.5 * b * b, b - 0.3 * a * b, 0.2 * np.sin(a + b)], axis=1)


def best_first(count: int) -> tuple[FloatArray, FloatArray]:
    at = points(count, 2)
    order = np.argsort((curved(at) ** 2).sum(axis=1))
    return at[order], curved(at[order])


@pytest.mark.parametrize("dimension", [1, 3, 10])
def test_linear_functions_are_reproduced(dimension: int) -> None:
    matrix = np.random.default_rng(0).normal(size=(dimension, 4))
    known, asked = points(2 * dimension + 4, dimension), points(7, dimension)
    surface = CubicSurface(known, known @ matrix + 3.0)
    np.testing.assert_allclose(surface(asked), asked @ matrix + 3.0, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(surface.hold_out, known @ matrix + 3.0, rtol=1e-5, atol=1e-5)


def test_interpolates_what_it_was_given_even_twice() -> None:
    known = np.concatenate([points(30, 2), points(30, 2)[:3]])
    surface = CubicSurface(known, curved(known))
    np.testing.assert_allclose(surface(known), curved(known), atol=1e-6)


def test_error_falls_as_points_are_added() -> None:
    asked = 0.1 + 0.8 * points(200, 2)

    def worst(count: int) -> float:
        known = points(count, 2)
        return float(np.abs(CubicSurface(known, curved(known))(asked) - curved(asked)).max())

    assert worst(160) < 0.3 * worst(30) < 0.3


def test_slopes_are_of_second_order() -> None:
    surface = CubicSurface(points(40, 2), curved(points(40, 2)))
    at, direction = np.array([[0.4, 0.5]]), np.array([0.6, -0.5])
    values, slopes = surface.with_slopes(at)
    np.testing.assert_allclose(values, surface(at), rtol=1e-12)
    errors = [
        float(np.linalg.norm(surface(at + h * direction) - values - h * slopes @ direction)) for h in (4e-3, 2e-3)
    ]
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_hold_out_is_the_prediction_without_the_point() -> None:
    known = points(15, 2)
    left_out = CubicSurface(np.delete(known, 4, axis=0), np.delete(curved(known), 4, axis=0))
    np.testing.assert_allclose(CubicSurface(known, curved(known)).hold_out[4], left_out(known[4:5])[0], rtol=1e-5)


@pytest.mark.parametrize("outputs", [1, 3, 200])
def test_components_keep_the_objective(outputs: int) -> None:
    known = points(25, 3)
    residuals = (known - 0.3) @ np.random.default_rng(1).normal(size=(3, outputs))
    components = Components.of(residuals, 2)
    assert components.values.shape[1] <= min(outputs, 12)
    np.testing.assert_allclose((components.values**2).sum(axis=1), (residuals**2).sum(axis=1), rtol=1e-8)
    assert components.rest == pytest.approx(0.0, abs=1e-10)


def test_what_no_component_explains_is_in_the_rest() -> None:
    noise = np.random.default_rng(2).normal(size=(1, 100))
    residuals = points(40, 2)[:, :1] * np.ones((1, 100)) + 0.0 * noise
    residuals = np.concatenate([residuals, 1e-3 * np.random.default_rng(3).normal(size=(40, 100))], axis=1)
    components = Components.of(residuals, 2)
    total = (components.values**2).sum(axis=1) + components.rest
    np.testing.assert_allclose(total, (residuals**2).sum(axis=1), rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("compression", [None, 0.1, 1.0, 10.0])
def test_minima_are_those_of_the_function(compression: float | None) -> None:
    known, residuals = best_first(60)
    surface = ResidualSurface(known, Components.of(residuals, 2), 0.1, compression)
    ends, values = minimise(surface, points(6, 2))
    np.testing.assert_allclose(ends[np.argmin(values)], [0.4, 0.6], atol=1e-2)
    assert np.all((ends >= 0.0) & (ends <= 1.0))


def test_minima_in_a_box_are_the_lowest_there() -> None:
    known, residuals = best_first(60)
    surface = ResidualSurface(known, Components.of(residuals, 2), 0.1, None)
    lower, upper = np.array([0.55, 0.1]), np.array([0.9, 0.45])  # the minimum of all lies outside
    ends, values = minimise(surface, points(6, 2), lower, upper)
    assert np.all((ends >= lower) & (ends <= upper))
    everywhere = lower + (upper - lower) * np.random.default_rng(4).random((4000, 2))
    assert values.min() <= surface.objective(everywhere).min()


def ridge(at: FloatArray) -> FloatArray:
    """Two residuals that change fast along (2, -1, 2) and slowly along (1, 2, 0)."""
    fast, slow = at @ [2.0, -1.0, 2.0], at @ [1.0, 2.0, 0.0]
    return np.stack([np.sin(3.0 * fast) - 0.5, np.exp(0.5 * fast) - 1.0 + 0.05 * slow], axis=1)


def test_directions_in_which_little_changes_cost_no_accuracy() -> None:
    known, asked = points(60, 3), points(200, 3)
    known = known[np.argsort((ridge(known) ** 2).sum(axis=1))]
    components = Components.of(ridge(known), 3)
    stretched, plain = ResidualSurface(known, components, 1.0, None), CubicSurface(known, components.values)
    exact = (ridge(asked) ** 2).sum(axis=1)
    errors = [float(np.abs(found - exact).mean()) for found in (stretched.objective(asked), (plain(asked) ** 2).sum(1))]
    assert errors[0] < 0.1 * errors[1]


@pytest.mark.parametrize("compression", [None, 1.0])
def test_slopes_are_those_along_the_parameters(compression: float | None) -> None:
    known = points(60, 3)
    surface = ResidualSurface(known, Components.of(ridge(known), 3), 1.0, compression)
    at, step = np.array([[0.4, 0.5, 0.3]]), 1e-5 * np.eye(3)
    slopes = surface.residuals(at)[1][0]
    differences = (surface.residuals(at + step)[0] - surface.residuals(at - step)[0]) / 2e-5
    np.testing.assert_allclose(slopes, differences.T, rtol=1e-6, atol=1e-6)


def test_the_unexplained_share_tells_smooth_from_random() -> None:
    known, residuals = best_first(60)
    random = np.random.default_rng(5).normal(size=(60, 3))
    smooth, rough = (ResidualSurface(known, Components.of(r, 2), 0.1, None).unexplained for r in (residuals, random))
    assert 0.0 < smooth < 0.01
    assert 1.0 < rough < 20.0
    assert ResidualSurface(known, Components.of(np.ones((60, 3)), 2), 0.1, None).unexplained <= 1e6


def test_residuals_that_are_all_zero_have_one_component() -> None:
    """Where every run meets all readings exactly, whatever the parameters."""
    components = Components.of(np.zeros((1, 2)), 1)
    assert components.values.tolist() == [[0.0]]
    assert components.rest == 0.0
