"""Least squares inside bounds: the conditions of a minimum, and SciPy's method as a second one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from geoswarm.solver.search.bounded import bounded_least_squares


def problem(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Matrix, wanted values and bounds around zero; some are badly scaled, some have two nearly equal columns."""
    random = np.random.default_rng(seed)
    n, m = random.integers(1, 9), random.integers(1, 25)
    matrix = random.normal(size=(m, n)) * 10.0 ** (random.uniform(-4, 3, n) if seed % 3 == 0 else np.zeros(n))
    if seed % 5 == 0 and n > 1:
        matrix[:, 1] = matrix[:, 0] * (1.0 + 1e-9 * (seed % 2))
    lower = -random.random(n) * 10.0 ** random.uniform(-3, 0)
    return matrix, random.normal(size=m) * 10.0 ** random.uniform(-2, 2), lower, lower + random.random(n)


@pytest.mark.parametrize("most_steps", [None, 50, 2])
def test_it_gives_what_scipy_gives_to_the_last_bit(most_steps: int | None) -> None:
    """So the histories of searches do not depend on which of the two is asked."""
    for seed in range(1000):
        matrix, wanted, lower, upper = problem(seed)
        expected = lsq_linear(matrix, wanted, (lower, upper), method="bvls", max_iter=most_steps).x
        np.testing.assert_array_equal(
            bounded_least_squares(matrix, wanted, lower, upper, most_steps=most_steps), expected, err_msg=str(seed)
        )


def test_no_slope_leads_down_except_out_of_the_bounds() -> None:
    """Conditions of Karush, Kuhn and Tucker: the problem is convex, so they hold at its minimum alone."""
    seeds, on_bounds = [seed for seed in range(600) if seed % 3 and seed % 5], 0
    for seed in seeds:
        matrix, wanted, lower, upper = problem(seed)
        x = bounded_least_squares(matrix, wanted, lower, upper, most_steps=50)
        assert (x >= lower - 1e-14).all()
        assert (x <= upper + 1e-14).all()
        slopes = matrix.T @ (matrix @ x - wanted)
        low, high = x <= lower + 1e-14, x >= upper - 1e-14
        enough = 1e-9 * (1.0 + np.linalg.norm(matrix, 2) * np.linalg.norm(wanted))
        assert (slopes[low] >= -enough).all(), seed
        assert (slopes[high] <= enough).all(), seed
        assert (np.abs(slopes[~low & ~high]) <= enough).all(), seed
        on_bounds += int((low | high).sum())
    assert on_bounds > len(seeds)


def test_a_minimum_inside_is_that_without_bounds() -> None:
    matrix = np.array([[1.0, 0.0], [1.0, 1.0], [1.0, 2.0]])
    line = bounded_least_squares(matrix, np.array([1.0, 2.0, 3.0]), np.zeros(2), np.full(2, 5.0))
    np.testing.assert_allclose(line, [1.0, 1.0], rtol=1e-14)
