"""How a descent ends where no step may be taken, and where the next one begins."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration.candidates import Strategies
from geoswarm.solver.search.acceleration.descending import next_of_descent
from geoswarm.solver.search.acceleration.knowledge import Knowledge
from geoswarm.solver.search.acceleration.strategies import BEGIN_PATTERN, DESCENT_PATTERN, PARTLY
from geoswarm.solver.search.acceleration.trust_region import TrustRegion

MINIMUM = np.array([0.2, 0.3, 0.4, 0.6])


def strategies_of(finished: int, admissible: Callable[[FloatArray], bool]) -> Strategies:
    """Twelve runs of a curved valley, best first; the ``finished`` first of them lie in a finished basin."""
    points = np.random.default_rng(5).random((12, 4))
    residuals = (points - MINIMUM) + 0.3 * (points - MINIMUM)[:, ::-1] ** 2
    order = np.argsort((residuals**2).sum(axis=1))
    points, residuals = points[order], residuals[order]
    knowledge = Knowledge(
        points,
        (residuals**2).sum(axis=1),
        residuals,
        np.arange(12) >= finished,
        points,
        admissible,
        lambda point: point,
        np.zeros(4, dtype=bool),
        np.arange(12),
    )
    return Strategies(knowledge, np.random.default_rng(1), None, TrustRegion(since=finished))


@pytest.mark.parametrize(("finished", "ends"), [(2, True), (0, False)])
def test_a_descent_whose_steps_all_lead_into_a_finished_basin_ends(finished: int, ends: bool) -> None:
    """Beyond a constraint, without a finished basin, other strategies find a way around; nothing is over."""
    descent = next_of_descent(strategies_of(finished, lambda _: False), 12)
    assert descent.pattern == (BEGIN_PATTERN if ends else DESCENT_PATTERN)
    assert (descent.left is not None) is ends
    assert descent.region.since == (12 if ends else 0)


def test_the_box_narrows_only_until_a_step_is_admissible() -> None:
    strategies = strategies_of(2, lambda point: bool(np.abs(point - strategies.knowledge.points[2]).max() < 0.004))
    descent = next_of_descent(strategies, 12)
    assert descent.pattern == DESCENT_PATTERN
    assert 0.004 < descent.region.radius < 0.1
    assert strategies.step(None, 1.0) is not None


def test_points_partly_drawn_anew_share_parameters_with_the_best() -> None:
    strategies = strategies_of(1, lambda _: True)
    points = [point for _ in range(20) if (point := strategies.take(PARTLY)) is not None]
    shared = np.array([point == strategies.knowledge.points[0] for point in points]).sum(axis=1)
    assert len(points) == 20
    assert set(shared.tolist()) <= {0, 1, 2, 3}
    assert 1.0 < shared.mean() < 3.0
