from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.acceleration import Proposer, ProposerState, candidates
from geoswarm.solver.search.determinism import particle_generator
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace
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
    return Runs.of(drawn, residuals)


def more(known: Runs, positions: FloatArray, residuals: FloatArray) -> Runs:
    rows = known.residuals(np.arange(len(known.positions)))
    return Runs.of(np.concatenate([known.positions, positions]), np.concatenate([rows, residuals]))


def propose(space: SearchSpace, known: Runs, seed: int, generation: int, count: int) -> FloatArray:
    """Proposals for ``count`` particles that the swarm moved to feasible points, natural values."""
    moved = np.array([space.draw(particle_generator(5, generation, i)) for i in range(count)])
    aimed = Proposer(space, seed).propose(generation, moved, np.arange(count), known)
    return space.to_natural(np.array(list(aimed.values())).reshape(-1, space.dimension))


def test_finds_the_minimum_of_a_smooth_valley_in_a_few_generations() -> None:
    space = oedometer_space()
    known = runs(space, 20, valley)
    for generation in range(1, 6):
        proposals = propose(space, known, 1, generation, 8)
        known = more(known, proposals, valley(proposals))
    assert known.objectives.min() < 1e-6
    best = known.positions[int(np.argmin(known.objectives))]
    np.testing.assert_allclose(best, CENTRE, rtol=0.01)


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1), count=st.integers(2, 25), failed=st.integers(0, 20), outputs=st.sampled_from([1, 4])
)
def test_proposals_are_feasible_inside_the_bounds_and_new(seed: int, count: int, failed: int, outputs: int) -> None:
    space = oedometer_space()
    known = runs(space, 25, lambda x: np.abs(valley(x)[:, :outputs]), failed)
    proposals = propose(space, known, seed, 1, count)
    assert max(1, round(0.4 * count)) <= len(proposals) <= count
    assert np.all((proposals >= space.lower) & (proposals <= space.upper))
    assert np.all(proposals[:, 0] > proposals[:, 1])
    everything = np.concatenate([known.positions, proposals])
    assert len(np.unique(everything, axis=0)) == len(everything)


def test_a_particle_that_would_repeat_a_run_is_aimed_too() -> None:
    space = oedometer_space()
    known = runs(space, 25, valley)
    moved = space.to_search(known.positions[:6])
    aimed = Proposer(space, 1).propose(1, moved, np.arange(6), known)
    repeats = [i for i in range(6) if (known.positions == space.to_natural(moved[i])).all(axis=1).any()]
    assert set(repeats) <= set(aimed)


def test_without_a_success_the_swarm_is_left_alone() -> None:
    space = oedometer_space()
    assert propose(space, runs(space, 10, valley, failed=10), 1, 1, 8).shape == (0, 3)


def test_regions_where_runs_fail_are_avoided() -> None:
    space = box(2, 0.0, 1.0)

    def walled(x: FloatArray) -> FloatArray:
        residuals = x - 0.2  # the surface's minimum lies where every run fails
        residuals[x[:, 0] < 0.5] = np.nan
        return residuals

    known = runs(space, 60, walled)
    proposals = propose(space, known, 1, 1, 20)
    assert np.mean(proposals[:, 0] > 0.4) > 0.9


@pytest.mark.parametrize("dimension", [1, 2, 8, 30])
@pytest.mark.parametrize("particles", [2, 12])
def test_any_dimension_and_number_of_particles(dimension: int, particles: int) -> None:
    space = box(dimension, -1.0, 1.0)

    def nearest(seed: int) -> float:
        known, proposer = runs(space, 3 * dimension + 5, lambda x: x - 0.3), Proposer(space, seed)
        for generation in range(1, 4):  # the trust region may have to grow to the minimum
            moved = np.array([space.draw(particle_generator(5, generation, i)) for i in range(particles)])
            aimed = proposer.propose(generation, moved, np.arange(particles), known)
            found = space.to_natural(np.array([aimed.get(i, moved[i]) for i in range(particles)]))
            known = more(known, found, found - 0.3)
            proposer.tell(known, particles)
        return float(np.abs(known.positions - 0.3).max(axis=1).min())

    assert max(nearest(seed) for seed in range(3)) < 0.05  # linear residuals, up to the compression


def waves(frequency: float) -> Callable[[FloatArray], FloatArray]:
    """Residuals that a surface predicts well (0.1) or not at all (60)."""
    x = np.linspace(0.0, 1.0, 12)
    return lambda at: np.asarray(np.sin(frequency * at.sum(axis=1)[:, None] * x) - 0.5)


def strategies_of(space: SearchSpace, known: Runs) -> tuple[ProposerState, dict[str, FloatArray]]:
    """The state after one generation of ten, and its aimed points (natural values) by strategy."""
    proposer, moved = Proposer(space, 1), np.array([space.draw(particle_generator(5, 1, i)) for i in range(10)])
    aimed = proposer.propose(1, moved, np.arange(10), known)
    return proposer.state, {
        strategy: space.to_natural(aimed[particle]) for particle, strategy in proposer.state.aimed.items()
    }


@pytest.mark.parametrize(("frequency", "misled"), [(0.1, False), (60.0, True)])
def test_the_hold_out_tells_where_the_surface_predicts_worse_than_the_mean(frequency: float, misled: bool) -> None:
    space = box(3, 0.0, 1.0)
    state, _ = strategies_of(space, runs(space, 22, waves(frequency)))
    assert state.hold_out is not None
    assert (state.hold_out > 1.0) == misled


@pytest.mark.parametrize("frequency", [0.1, 60.0])
def test_after_many_runs_the_surface_is_searched_around_the_best_that_lie_apart(frequency: float) -> None:
    space, wave = box(3, 0.0, 1.0), waves(frequency)
    assert not any(strategy.startswith("around") for strategy in strategies_of(space, runs(space, 20, wave))[1])
    known = runs(space, 60, wave)
    best = known.positions[np.argsort(known.objectives)]
    apart = best[np.abs(best - best[0]).max(axis=1) > 0.25]
    _, strategies = strategies_of(space, known)
    for number, centre in enumerate((best[0], apart[0])):
        reaches = {
            float(strategy.split(":")[2]): at
            for strategy, at in strategies.items()
            if strategy.startswith(f"around:{number}")
        }
        assert set(reaches) == {0.03, 0.1}
        for reach, at in reaches.items():
            assert 0.0 < np.abs(at - centre).max() <= reach + 1e-12


def test_points_along_a_valley_are_low_and_far_from_all_good_runs() -> None:
    def bent(at: FloatArray) -> FloatArray:
        return np.stack([at[:, 1] - 0.8 * at[:, 0] ** 2, 0.01 * at[:, 0]], axis=1)

    at = np.random.default_rng(1).random((80, 2))
    known = at[(at[:, 0] < 0.5) | (np.abs(bent(at)[:, 0]) > 0.15)]  # nothing good on the right
    point = strategies_of(box(2, 0.0, 1.0), Runs.of(known, bent(known)))[1]["valley"]
    assert point[0] > 0.6
    assert abs(bent(point[None])[0, 0]) < 0.1


def test_state_survives_json_bit_for_bit() -> None:
    space = oedometer_space()
    known, state = runs(space, 20, lambda x: np.abs(valley(x)[:, :1])), ProposerState()
    for generation in range(1, 12):
        moved = np.array([space.draw(particle_generator(5, generation, i)) for i in range(7)])
        proposers = [Proposer(space, 1, state), Proposer(space, 1, ProposerState.from_json(state.to_json()))]
        aimed = [p.propose(generation, moved, np.arange(7), known) for p in proposers]
        states = [json.dumps(p.state.to_json(), allow_nan=False) for p in proposers]
        assert states[0] == states[1]
        for particle, point in aimed[0].items():
            assert aimed[1][particle].tobytes() == point.tobytes()
            moved[particle] = point
        natural = space.to_natural(moved)
        new = np.abs(valley(natural)[:, :1])
        known = more(known, natural, new)
        for proposer in proposers:
            proposer.tell(known, 7)
        state = ProposerState.from_json(json.loads(json.dumps(proposers[1].state.to_json(), allow_nan=False)))
    assert state.covariance is not None


def test_the_cost_is_bounded_by_a_selection_of_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes: list[int] = []

    class Counting(candidates.ResidualSurface):
        def __init__(self, points: FloatArray, *rest: Any) -> None:
            sizes.append(len(points))
            super().__init__(points, *rest)

    monkeypatch.setattr(candidates, "ResidualSurface", Counting)
    space = oedometer_space()
    assert len(propose(space, runs(space, 2000, valley), 1, 1, 8)) >= 6
    assert max(sizes) == 140


def test_the_first_generation_is_a_simplex_and_points_far_from_it_and_keeps_the_estimate() -> None:
    space = oedometer_space()
    drawn = np.array([space.draw(particle_generator(1, 0, i)) for i in range(10)])
    first = Proposer(space, 1).first(drawn, keep=1)
    np.testing.assert_allclose(first[0], drawn[0], rtol=1e-12)
    assert all(space.is_feasible(point) for point in first)
    unit = (first - space.search_lower) / (space.search_upper - space.search_lower)
    steps = unit[1:4] - unit[0]
    assert np.linalg.matrix_rank(steps, tol=1e-3) == 3
    assert (np.count_nonzero(np.abs(steps) > 1e-12, axis=1) == 1).all()
    assert np.abs(steps).max() <= 0.2 + 1e-12

    def closest(points: FloatArray) -> float:
        unit = (points - space.search_lower) / (space.search_upper - space.search_lower)
        return float((np.linalg.norm(unit[:, None] - unit[None], axis=2) + 9.0 * np.eye(len(unit))).min())

    assert closest(first[4:]) > 2.0 * closest(drawn)
    few = Proposer(space, 1).first(drawn[:2], keep=0)
    assert few.shape == (2, 3)
    middle = (few[0] - space.search_lower) / (space.search_upper - space.search_lower)
    assert np.abs(middle - 0.5).max() <= 0.2  # room for steps to both sides


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
