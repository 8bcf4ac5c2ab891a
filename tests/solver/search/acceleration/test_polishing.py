"""The end of a polished search."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.search.acceleration.proposer_state import Polishing
from geoswarm.solver.search.acceleration.strategies import PROBE, Local, polish_pattern
from tests.solver.problems import decay_document

POLISHED = {"kind": "particle_swarm", "particles": 10, "polish": True}


def noisy() -> Problem:
    """A decay with scatter, so that the least objective is not zero."""
    document = decay_document(method=POLISHED, stopping={"max_evaluations": 600})
    points = document["observations"][0]["points"]
    points["y"] = (np.array(points["y"]) + 0.05 * np.random.default_rng(1).standard_normal(21)).tolist()
    return parse_problem(document)


def test_a_polished_search_ends_by_itself_at_the_minimum_that_scipy_finds() -> None:
    problem = noisy()
    calibration = Calibration(problem, 1)

    def residuals(values: np.ndarray) -> np.ndarray:
        return np.asarray(calibration.objective.weighted_residuals(calibration.evaluate(values).responses))

    least = least_squares(residuals, [3.0, 0.7], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    for seed in range(4):
        result = calibrate(problem, seed=seed)
        assert result.stop_reasons == ("polished",)
        assert result.objective == pytest.approx(2.0 * least.cost, rel=1e-6)
        assert result.best is not None
        np.testing.assert_allclose(result.best.parameters, least.x, rtol=1e-3)
        assert result.evaluations <= 200


def test_any_number_of_particles_and_a_scalar_can_be_polished() -> None:
    for particles in (2, 5):
        document = noisy().document() | {"method": POLISHED | {"particles": particles}}
        assert calibrate(parse_problem(document), seed=1).stop_reasons == ("polished",)
    single = decay_document(
        forward_model={"kind": "formula", "series": {"y": "(amplitude - 3)**2 + (rate - 0.7)**2 + 0.1 + 0 * x"}},
        observations=[{"series": "y", "points": {"x": [0.0], "y": [0.0]}}],
        method=POLISHED,
        stopping={"max_evaluations": 1000},
    )
    result = calibrate(parse_problem(single), seed=1)
    assert result.stop_reasons == ("polished",)
    assert result.objective == pytest.approx(0.01, rel=1e-4)


def test_polish_needs_stored_responses() -> None:
    with pytest.raises(ProblemError, match="needs the stored responses"):
        parse_problem(decay_document(method=POLISHED | {"acceleration": "none"}))


def test_it_ends_when_two_generations_gain_nothing_or_after_ten() -> None:
    state = Polishing(1.0)
    assert not state.after(0.9995).done
    assert state.after(0.9995).after(0.9994).done
    assert not state.after(0.9995).after(0.5).done
    for number in range(9):
        state = state.after(0.5 ** (number + 1))
        assert not state.done
    assert state.after(0.0).done
    assert Polishing(**state.to_json()) == state


def test_half_of_a_polishing_generation_are_steps() -> None:
    assert polish_pattern(2) == (Local("quadratic", 0, 1), PROBE)
    strategies = polish_pattern(12)
    assert len(strategies) == 12
    assert sum(strategy != PROBE for strategy in strategies) == 3
    assert polish_pattern(4)[:2] == (Local("quadratic", 0, 1), Local("quadratic", 0, 0.3))
