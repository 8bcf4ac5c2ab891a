"""Whether a point is new is found without comparing all coordinates of all runs."""

from __future__ import annotations

import time

import numpy as np

from geoswarm.solver.search.acceleration.candidates import _any_within


def test_it_is_the_largest_difference_of_a_coordinate_that_counts() -> None:
    random = np.random.default_rng(3)
    for dimension in (1, 2, 7):
        points = np.round(random.random((400, dimension)), 2)
        for apart in (0.0, 1e-5, 0.02, 0.3):
            for point in (*np.round(random.random((40, dimension)), 2), points[17], points[5] + apart):
                nearest = float(np.abs(points - point).max(axis=1).min())
                assert _any_within(points, point, apart) is not (nearest > apart)
    assert not _any_within(np.empty((0, 2)), np.zeros(2), 1.0)


def test_thousands_of_runs_cost_little() -> None:
    """Least processor time of several passes, beside what a comparison of all coordinates takes."""
    random = np.random.default_rng(4)
    points, asked = random.random((20_000, 4)), random.random((200, 4))
    spent: list[tuple[float, float]] = []
    for _ in range(7):
        began = time.process_time()
        whole = [float(np.abs(points - point).max(axis=1).min()) > 1e-5 for point in asked]
        between = time.process_time()
        quick = [not _any_within(points, point, 1e-5) for point in asked]
        spent.append((time.process_time() - between, between - began))
        assert quick == whole
    of_quick, of_whole = (min(times) for times in zip(*spent, strict=True))
    assert of_quick < 0.5 * of_whole
