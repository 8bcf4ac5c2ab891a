from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.determinism import particle_generator
from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings
from geoswarm.solver.search.space import SearchSpace
from tests.solver.search.spaces import box, oedometer_space

FORMS = [
    SwarmSettings(),
    SwarmSettings(form="inertia_weight", cognitive_coefficient=1.49618, social_coefficient=1.49618),
    SwarmSettings(topology="ring"),
]
BOUNDARIES = ["reflect", "absorb", "resample"]


def sphere(positions: FloatArray) -> FloatArray:
    return np.sum((positions - 1.0) ** 2, axis=1)


def run(swarm: ParticleSwarm, generations: int) -> list[FloatArray]:
    history = []
    for _ in range(generations):
        history.append(swarm.ask())
        swarm.tell(sphere(history[-1]))
    return history


def test_constriction_is_clercs_factor() -> None:
    chi, cognitive, social = SwarmSettings().weights
    assert chi == pytest.approx(0.72984, abs=1e-5)
    assert cognitive == social == pytest.approx(1.49618, abs=1e-5)


@pytest.mark.parametrize("settings_", FORMS)
def test_finds_the_minimum_of_a_sphere(settings_: SwarmSettings) -> None:
    swarm = ParticleSwarm(box(3), settings_, seed=7)
    history = run(swarm, 150)
    assert sphere(history[0]).min() > 1e-2
    assert sphere(history[-1]).min() < 1e-8


def test_one_step_follows_the_published_update() -> None:
    space = box(2, -1000.0, 1000.0)
    swarm_settings = SwarmSettings(particles=3, max_velocity=10.0)
    swarm = ParticleSwarm(space, swarm_settings, seed=3)
    x, v = np.array(swarm.snapshot()["position"]), np.array(swarm.snapshot()["velocity"])
    objectives = np.array([3.0, 1.0, 2.0])
    swarm.tell(objectives)
    chi, s = 0.7298437881283576, 2.05
    for i in range(3):
        random = particle_generator(3, 1, i)
        random.random(2)  # r1 multiplies p - x, which is zero in the first step
        r2 = random.random(2)
        expected = x[i] + chi * (v[i] + s * r2 * (x[1] - x[i]))
        inside = np.abs(expected) <= 1000.0
        np.testing.assert_allclose(swarm.ask()[i][inside], expected[inside], rtol=1e-12)
        assert inside.any()


def test_ties_of_the_best_go_to_the_lowest_index() -> None:
    swarm = ParticleSwarm(box(2), SwarmSettings(particles=4), seed=1)
    first = np.array(swarm.snapshot()["position"])
    swarm.tell(np.array([2.0, 1.0, 1.0, 1.0]))
    assert swarm._informants()[0] == 1
    assert swarm.snapshot()["best_position"] == first.tolist()


def test_ring_knows_only_the_neighbours() -> None:
    swarm = ParticleSwarm(box(2), SwarmSettings(particles=6, topology="ring"), seed=1)
    swarm.tell(np.array([0.0, 5.0, 4.0, 3.0, 2.0, 1.0]))
    assert swarm._informants().tolist() == [0, 0, 3, 4, 5, 0]


def _scattered(positions: FloatArray, generation: int) -> FloatArray:
    """Objectives without any order, some failed: drives the swarm everywhere."""
    return np.array(
        [[np.inf, 1.0, 3.0, 0.5, 2.0][(i * 7 + generation * 3) % 5] / (1 + generation) for i in range(len(positions))]
    )


@settings(max_examples=30, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    boundary=st.sampled_from(BOUNDARIES),
    topology=st.sampled_from(["global", "ring"]),
    max_velocity=st.sampled_from([0.1, 0.5, 3.0]),
)
def test_every_proposal_keeps_bounds_and_constraints(
    seed: int, boundary: Any, topology: Any, max_velocity: float
) -> None:
    space = oedometer_space()
    swarm_settings = SwarmSettings(boundary=boundary, topology=topology, max_velocity=max_velocity)
    swarm = ParticleSwarm(space, swarm_settings, seed)
    for generation in range(15):
        positions = swarm.ask()
        assert np.all(positions >= space.lower)
        assert np.all(positions <= space.upper)
        assert np.all(positions[:, 0] > positions[:, 1])
        swarm.tell(_scattered(positions, generation))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), stop=st.integers(0, 12))
def test_a_restored_snapshot_goes_on_bit_for_bit_alike(seed: int, stop: int) -> None:
    space: SearchSpace = oedometer_space()
    swarm = ParticleSwarm(space, SwarmSettings(), seed)
    for generation in range(stop):
        swarm.tell(_scattered(swarm.ask(), generation))
    restored = ParticleSwarm.restore(space, SwarmSettings(), seed, json.loads(json.dumps(swarm.snapshot())))
    for generation in range(stop, stop + 6):
        assert swarm.ask().tobytes() == restored.ask().tobytes()
        swarm.tell(_scattered(swarm.ask(), generation))
        restored.tell(_scattered(restored.ask(), generation))
    assert swarm.snapshot() == restored.snapshot()


def test_the_users_estimate_is_particle_zero() -> None:
    space = oedometer_space()
    swarm = ParticleSwarm(space, SwarmSettings(), 5, initial=np.array([0.064, 0.035, 27.0]))
    assert swarm.ask()[0] == pytest.approx([0.064, 0.035, 27.0], rel=1e-14)


def test_without_any_success_particles_are_drawn_anew() -> None:
    swarm = ParticleSwarm(box(2), SwarmSettings(), seed=5)
    first = swarm.ask()
    swarm.tell(np.full(10, np.inf))
    second = swarm.ask()
    assert np.all(np.any(first != second, axis=1))
    assert swarm.snapshot()["best_objective"] == [None] * 10
    swarm.tell(sphere(second))
    assert None not in swarm.snapshot()["best_objective"]


def test_a_wrong_number_of_objectives_is_refused() -> None:
    swarm = ParticleSwarm(box(2), SwarmSettings(particles=4), seed=5)
    with pytest.raises(ValueError, match=r"shape \(3,\), expected \(4,\)"):
        swarm.tell(np.zeros(3))
