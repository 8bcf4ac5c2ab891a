from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solver.arrays import FloatArray
from solver.search import Runs, SearchSpace
from solver.search.acceleration import propose
from solver.search.randomness import particle_generator
from tests.solver.search.spaces import box, oedometer_space

CENTRE = np.array([0.08, 0.05, 25.0])


def valley(positions: FloatArray) -> FloatArray:
    """A residual vector that is curved in the natural values and small only at CENTRE."""
    a, b, c = np.log(positions / CENTRE).T
    return np.stack([a + 0.3 * b * b, b - 0.2 * a * c, 0.1 * c + 0.05 * c * c, 0.5 * (a - b)], axis=1)


def runs(space: SearchSpace, count: int, residual: Callable[[FloatArray], FloatArray], failed: int = 0) -> Runs:
    drawn = space.to_natural(np.array([space.draw(particle_generator(3, 0, i)) for i in range(count)]))
    residuals = residual(drawn)
    residuals[:failed] = np.nan
    return Runs(drawn, residuals)


def test_finds_the_minimum_of_a_smooth_valley_in_a_few_generations() -> None:
    space = oedometer_space()
    known = runs(space, 20, valley)
    for generation in range(1, 6):
        proposals = space.to_natural(propose(space, known, 1, generation, 8))
        known = Runs(np.concatenate([known.positions, proposals]), np.concatenate([known.residuals, valley(proposals)]))
    assert known.objectives.min() < 1e-6
    best = known.positions[int(np.argmin(known.objectives))]
    np.testing.assert_allclose(best, CENTRE, rtol=0.01)


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12), failed=st.integers(0, 10))
def test_proposals_are_feasible_inside_the_bounds_and_new(seed: int, count: int, failed: int) -> None:
    space = oedometer_space()
    known = runs(space, 25, valley, failed)
    proposals = propose(space, known, seed, 1, count)
    assert 1 <= len(proposals) <= count
    natural = space.to_natural(proposals)
    assert np.all((proposals >= space.search_lower - 1e-12) & (proposals <= space.search_upper + 1e-12))
    assert np.all(natural[:, 0] > natural[:, 1])
    unit = np.concatenate([space.to_search(known.positions), proposals])
    unit = (unit - space.search_lower) / (space.search_upper - space.search_lower)
    apart = np.linalg.norm(unit[:, None] - unit[None], axis=2) + np.eye(len(unit))
    assert apart[25:].min() > 1e-4


@pytest.mark.parametrize(("count", "failed"), [(3, 0), (10, 8)])
def test_too_few_successful_runs_give_no_proposal(count: int, failed: int) -> None:
    space = oedometer_space()
    assert propose(space, runs(space, count, valley, failed), 1, 1, 8).shape == (0, 3)


@pytest.mark.parametrize("dimension", [1, 2, 8, 30])
def test_any_dimension(dimension: int) -> None:
    space = box(dimension, -1.0, 1.0)
    known = runs(space, 3 * dimension + 5, lambda x: x - 0.3)
    proposals = propose(space, known, 1, 1, 6)
    assert np.abs(proposals[0] - 0.3).max() < 1e-6  # linear residuals are solved at once


def test_the_cost_is_bounded_by_a_selection_of_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []
    from solver.search.acceleration import proposer

    class Counting(proposer.ResidualSurface):
        def __init__(self, points: FloatArray, residuals: FloatArray) -> None:
            sizes.append(len(points))
            super().__init__(points, residuals)

    monkeypatch.setattr(proposer, "ResidualSurface", Counting)
    space = oedometer_space()
    assert len(propose(space, runs(space, 2000, valley), 1, 1, 8)) >= 6
    assert max(sizes) == proposer.LARGEST_MODEL


PRINT_PROPOSALS = (
    "from tests.solver.search.acceleration.test_proposer import *;"
    "space = oedometer_space(); print(propose(space, runs(space, 120, valley), 1, 1, 8).tobytes().hex())"
)


def test_the_number_of_threads_changes_no_bit() -> None:
    def proposals(threads: str) -> str:
        environment = os.environ | dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), threads)
        command = [sys.executable, "-c", PRINT_PROPOSALS]
        return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout

    one = proposals("1")
    assert len(one) > 100
    assert proposals("4") == one
