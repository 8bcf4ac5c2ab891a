from __future__ import annotations

import itertools

import numpy as np
import pytest

from solver.arrays import FloatArray
from solver.search.acceleration.residual_surface import ResidualSurface


def points(count: int, dimension: int) -> FloatArray:
    return np.random.default_rng(count).random((count, dimension))


def test_a_linear_residual_vector_is_modelled_exactly() -> None:
    matrix, shift = np.random.default_rng(0).normal(size=(3, 40)), np.random.default_rng(1).normal(size=40)
    known = points(12, 3)
    surface = ResidualSurface(known, known @ matrix + shift)
    asked = points(7, 3)
    expected = np.sum((asked @ matrix + shift) ** 2, axis=1)
    np.testing.assert_allclose(surface.objective(asked), expected, rtol=1e-10)


def test_interpolates_what_it_was_given() -> None:
    known = points(30, 2)
    residuals = np.stack([np.sin(3 * known[:, 0]), np.exp(known[:, 1]), known[:, 0] * known[:, 1]], axis=1)
    surface = ResidualSurface(known, residuals)
    np.testing.assert_allclose(surface.objective(known), np.sum(residuals**2, axis=1), rtol=1e-8)


def test_error_falls_as_points_are_added() -> None:
    def worst(count: int) -> float:
        known, asked = points(count, 2), 0.2 + 0.6 * points(200, 2)
        truth = np.cos(2 * asked[:, 0]) * np.exp(asked[:, 1])
        surface = ResidualSurface(known, (np.cos(2 * known[:, 0]) * np.exp(known[:, 1]))[:, None])
        return float(np.abs(np.sqrt(surface.objective(asked)) - np.abs(truth)).max())

    assert worst(160) < 0.3 * worst(40) < 0.3


def test_points_in_a_plane_are_no_obstacle() -> None:
    known = points(12, 3)
    known[:, 2] = 0.5
    surface = ResidualSurface(known, known[:, :2] - 0.3)
    assert surface.objective(np.array([[0.3, 0.3, 0.5]]))[0] == pytest.approx(0.0, abs=1e-12)


def test_jacobian_is_of_second_order() -> None:
    known = points(40, 3)
    residuals = np.stack([np.sin(3 * known[:, 0]) * known[:, 2], np.exp(known[:, 1])], axis=1)
    surface = ResidualSurface(known, residuals)
    at, direction = np.array([0.4, 0.5, 0.6]), np.array([0.6, -0.5, 0.3])
    z, jacobian = surface.linearised(at)
    errors = [
        float(np.linalg.norm(surface.linearised(at + h * direction)[0] - z - h * jacobian @ direction))
        for h in (0.02, 0.01, 0.005)
    ]
    orders = [np.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert all(1.8 < order < 2.2 for order in orders), orders
