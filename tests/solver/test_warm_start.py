"""Runs of earlier calibrations are taken over where they are runs of the new problem, and only there."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, WarmStartRuns
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.warm_start import MOST_OFFERED, EarlierRuns, best_of, offer_of
from tests.solver.problems import decay_document

AIMED = {"kind": "particle_swarm", "particles": 8}


def problem(**changes: Any) -> Problem:
    return parse_problem(decay_document(**{"method": AIMED, **changes}))


def earlier(source: Problem, seed: int = 1) -> EarlierRuns:
    runs = [record.evaluation for record in calibrate(source, seed=seed).history]
    return EarlierRuns(source, np.array([r.parameters for r in runs]), [r.responses for r in runs])


def sampling(**changes: Any) -> Problem:
    return problem(method={"kind": "monte_carlo", "samples": 60}, stopping=None, **changes)


def offered(now: Problem, runs: EarlierRuns) -> WarmStartRuns:
    offer = offer_of(now, runs)
    assert isinstance(offer, WarmStartRuns)
    return offer


def check_runs(now: Problem, offer: WarmStartRuns) -> None:
    """What is offered is what a run of the new problem would give."""
    calibration = Calibration(now, 1)
    for parameters, responses in list(zip(offer.parameters, offer.responses, strict=True))[:5]:
        fresh = calibration.evaluate(parameters).responses
        np.testing.assert_allclose(responses["y"], fresh["y"], rtol=1e-12)


def test_other_data_weights_and_bounds_change_nothing_in_what_a_run_gives() -> None:
    runs = earlier(sampling())
    points = {"x": np.linspace(0.0, 5.0, 21)[::4].tolist(), "y": [2.0, 1.0, 0.5, 0.3, 0.1, 0.0]}
    parameters = {"amplitude": {"lower": 1.0, "upper": 5.0}, "rate": {"lower": 0.1, "upper": 5.0}}
    now = problem(observations=[{"series": "y", "points": points, "weight": 3.0}], parameters=parameters)
    offer = offered(now, runs)
    assert 0 < len(offer.parameters) < 60
    assert np.all((offer.parameters >= [1.0, 0.1]) & (offer.parameters <= 5.0))
    check_runs(now, offer)


def test_a_parameter_may_be_free_now_that_was_fixed_or_linked() -> None:
    linked = {"rate": {"lower": 0.01, "upper": 10.0}, "amplitude": {"expression": "2 * rate"}}
    offer = offered(problem(), earlier(sampling(parameters=linked)))
    np.testing.assert_allclose(offer.parameters[:, 0], 2.0 * offer.parameters[:, 1], rtol=1e-12)
    check_runs(problem(), offer)


def test_what_is_fixed_now_must_have_had_the_same_value() -> None:
    fixed = {"amplitude": {"value": 3.0}, "rate": {"lower": 0.01, "upper": 10.0, "scale": "log"}}
    assert len(offered(problem(parameters=fixed), earlier(sampling(parameters=fixed))).parameters) == 60
    other = fixed | {"amplitude": {"value": 3.1}}
    assert "same values of all parameters" in str(
        offer_of(problem(parameters=other), earlier(sampling(parameters=fixed)))
    )


def test_another_model_or_other_points_offer_nothing() -> None:
    runs = earlier(sampling())
    other = problem(forward_model={"kind": "formula", "series": {"y": "amplitude * exp(-2 * rate * x)"}})
    assert offer_of(other, runs) == "has another forward model"
    elsewhere = problem(observations=[{"series": "y", "points": {"x": [0.1], "y": [1.0]}}])
    assert offer_of(elsewhere, runs) == "has no responses at all observed points of y"


def test_a_warm_start_saves_runs_and_runs_the_best_again() -> None:
    offer = offered(problem(), earlier(sampling()))
    best = Calibration(problem(), 1, offer).offered
    assert best is not None
    cold = [calibrate(problem(), seed=seed).evaluations for seed in range(5)]
    warm = [calibrate(problem(), seed=seed, offer=offer) for seed in range(5)]
    assert max(r.evaluations for r in warm) <= min(cold)
    first = warm[0].history[0].evaluation
    np.testing.assert_allclose(first.parameters, best.positions[int(np.argmin(best.objectives))], rtol=1e-12)
    assert first.objective == pytest.approx(best.objectives.min(), rel=1e-12)


def test_an_offer_changes_nothing_in_the_promise_that_a_seed_fixes_the_history() -> None:
    offer = offered(problem(), earlier(sampling()))

    def history() -> list[FloatArray]:
        return [record.evaluation.parameters for record in calibrate(problem(), seed=2, offer=offer).history]

    np.testing.assert_array_equal(history(), history())


def test_offers_are_joined_each_point_once_and_bounded() -> None:
    offer = offered(problem(), earlier(sampling()))
    joined = best_of(problem(), [offer, offer])
    assert joined is not None
    assert len(joined.parameters) == len(offer.parameters)
    many = 3 * MOST_OFFERED
    random = np.random.default_rng(1)
    large = WarmStartRuns(1.0 + random.random((many, 2)), [{"y": random.random(21)} for _ in range(many)])
    bounded = best_of(problem(), [large])
    assert bounded is not None
    assert len(bounded.parameters) == len(bounded.responses) == MOST_OFFERED
    assert best_of(problem(), []) is None


def test_jobs_to_start_from_are_for_the_service_and_for_aimed_swarms() -> None:
    named = problem(warm_start={"jobs": ["0123456789abcdef"]})
    assert named.document()["warm_start"] == {"jobs": ["0123456789abcdef"]}
    assert parse_problem(named.document()) == named
    with pytest.raises(ProblemError, match="jobs are known to the service only"):
        calibrate(named)
    with pytest.raises(ProblemError, match="needs method particle_swarm"):
        problem(warm_start={"jobs": ["0123456789abcdef"]}, method=AIMED | {"acceleration": "none"})
