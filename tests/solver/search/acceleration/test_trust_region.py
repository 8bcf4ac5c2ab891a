"""The trust region: its ratio test, the directions that runs span, and descents at any width."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.search.acceleration.trust_region import TrustRegion, missing_direction, spanned
from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace
from tests.solver.search.acceleration.test_proposer import CENTRE, valley
from tests.solver.search.spaces import box, oedometer_space

ACCELERATED = SwarmSettings(acceleration="response_surface")


def region_after(found: float, promised: float | None, step: float = 0.1) -> TrustRegion:
    """After the best of two runs had 4, a step of so much was to have ``promised`` and had ``found``."""
    points = np.array([[0.2, 0.5], [0.5, 0.5], [0.5 + step, 0.5]])
    return TrustRegion(0.2, promised=promised).after(points, np.array([9.0, 4.0, found]), 1, [0])


@pytest.mark.parametrize(
    ("found", "radius", "missed"),
    [(1.0, 0.2, False), (2.5, 0.2, False), (3.9, 0.1, True), (5.0, 0.1, True), (np.inf, 0.1, True)],
)
def test_the_box_follows_what_became_of_the_promise(found: float, radius: float, missed: bool) -> None:
    region = region_after(found, 1.0)
    assert region == TrustRegion(pytest.approx(radius), missed=missed)


def test_a_promise_kept_by_a_step_to_the_edge_doubles_the_box_up_to_half_of_the_ranges() -> None:
    assert region_after(1.0, 1.0, 0.2).radius == pytest.approx(0.4)
    assert region_after(1.0, 1.0, 0.4).radius == pytest.approx(0.5)


def test_without_a_promise_the_box_stays() -> None:
    assert region_after(1.0, None) == TrustRegion(0.2)


def test_a_descent_counts_its_own_runs_alone() -> None:
    points = np.array([[0.1], [0.7], [0.75]])
    region = TrustRegion(0.2, since=1, promised=1.0).after(points, np.array([0.1, 4.0, 2.0]), 1, [0])
    assert not region.missed  # two thirds of the decrease from 4, though 0.1 was known elsewhere


def test_directions_that_runs_near_the_centre_span() -> None:
    centre = np.array([0.5, 0.5, 0.5])
    runs = np.array([centre, [0.6, 0.5, 0.5], [0.5, 0.62, 0.5], [0.5, 0.5, 0.99]])
    basis = spanned(runs, centre, 0.1)
    np.testing.assert_allclose(basis @ basis.T, np.eye(2), atol=1e-12)
    missing = missing_direction(runs, centre, 0.1)
    assert missing is not None
    np.testing.assert_allclose(np.abs(missing), [0.0, 0.0, 1.0], atol=1e-12)
    assert missing_direction(runs, centre, 0.3) is None  # the far run lies within two half widths then
    assert missing_direction(centre[None], centre, 0.1) is not None


def searched(
    space: SearchSpace, widths: Sequence[int], seed: int, *, restored: bool = False
) -> tuple[FloatArray, FloatArray]:
    """Positions and residuals of generations of these widths, each search restored from JSON if asked for."""
    search = ParticleSwarm(space, SwarmSettings(particles=widths[0], acceleration="response_surface"), seed)
    positions, residuals = np.empty((0, space.dimension)), np.empty((0, 4))
    for width, after in zip(widths, [*widths[1:], widths[-1]], strict=True):
        asked = search.ask()
        assert asked is not None
        assert len(asked) == width
        found = valley(asked)
        positions, residuals = np.concatenate([positions, asked]), np.concatenate([residuals, found])
        search.tell((found**2).sum(axis=1), Runs.of(positions, residuals), particles=after)
        if restored:
            kept = json.loads(json.dumps(search.snapshot(), allow_nan=False))
            search = ParticleSwarm.restore(space, ACCELERATED, seed, kept)
    return positions, residuals


@pytest.mark.parametrize(("width", "generations"), [(1, 30), (2, 16), (3, 12), (4, 10), (10, 7), (40, 5), (100, 4)])
def test_any_width_finds_the_minimum_of_a_smooth_valley(width: int, generations: int) -> None:
    positions, residuals = searched(oedometer_space(), [width] * generations, 0)
    best = int(np.argmin((residuals**2).sum(axis=1)))
    np.testing.assert_allclose(positions[best], CENTRE, rtol=0.02)


def test_the_width_may_change_between_generations_and_the_search_be_restored() -> None:
    widths = [3, 1, 4, 10, 2, 1, 1, 2, 5, 1, 3, 1]
    space = oedometer_space()
    positions, residuals = searched(space, widths, 7)
    again, _ = searched(space, widths, 7, restored=True)
    assert positions.tobytes() == again.tobytes()
    assert len(np.unique(positions, axis=0)) == sum(widths)
    np.testing.assert_allclose(positions[int(np.argmin((residuals**2).sum(axis=1)))], CENTRE, rtol=0.02)


def test_a_generation_has_at_least_one_particle() -> None:
    search = ParticleSwarm(oedometer_space(), ACCELERATED, 1)
    with pytest.raises(ValueError, match="particles must be at least 1, got 0"):
        search.tell(np.ones(10), particles=0)


@pytest.mark.parametrize("width", [1, 3])
def test_a_descent_into_a_poor_basin_is_left_and_the_better_one_found(width: int) -> None:
    space = box(1, 0.0, 1.0)

    def basins(
        x: FloatArray,
    ) -> FloatArray:  # a wide one at 0.8, whose objective stays at 0.09, and a better one at 0.1
        return np.where(x < 0.25, np.hstack([x - 0.1, 0.0 * x]), np.hstack([x - 0.8, 0.3 + 0.0 * x]))

    for seed in range(3):
        search = ParticleSwarm(space, SwarmSettings(particles=width, acceleration="response_surface"), seed)
        positions = np.empty((0, 1))
        while len(positions) < 60:
            asked = search.ask()
            assert asked is not None
            positions = np.concatenate([positions, asked])
            search.tell((basins(asked) ** 2).sum(axis=1), Runs.of(positions, basins(positions)))
        assert np.abs(positions - 0.1).min() < 1e-3


def test_the_best_basin_is_taken_to_its_minimum() -> None:
    """The surface promised less than 1 % where 5 % were left to gain."""
    x = np.linspace(0.0, 4.0, 60)
    document: dict[str, Any] = {
        "forward_model": {"kind": "formula", "series": {"y": "a * exp(-d * x) * cos(2 * pi * f * x + p) + o"}},
        "parameters": {
            "a": {"lower": 0.1, "upper": 20.0, "scale": "log"},
            "d": {"lower": 0.01, "upper": 5.0, "scale": "log"},
            "f": {"lower": 0.2, "upper": 6.0},
            "p": {"lower": -3.2, "upper": 3.2},
            "o": {"lower": -3.0, "upper": 3.0},
        },
        "observations": [{"series": "y", "points": {"x": x.tolist(), "y": x.tolist()}}],
        "method": {"kind": "particle_swarm", "particles": 1},
        "stopping": {"max_evaluations": 300},
        "answer": {"max_evaluations": "off"},
    }
    model = Calibration(parse_problem(document), 1)

    def calculated(values: Sequence[float]) -> FloatArray:
        return model.evaluate_values(dict(zip(document["parameters"], values, strict=True))).responses["y"]

    true = [3.0, 0.5, 2.3, 0.7, 0.4]
    y = calculated(true) + 0.15 * np.random.default_rng(3).standard_normal(x.size)
    least = 2.0 * least_squares(lambda values: calculated(values) - y, true).cost / x.size
    document["observations"][0]["points"]["y"] = y.tolist()
    document["stopping"]["target_objective"] = 1.01 * least
    assert calibrate(parse_problem(document), seed=1).stop_reasons == ("target_objective",)
