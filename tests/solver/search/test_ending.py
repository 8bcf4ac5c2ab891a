"""The end of a polished search: to a minimum, from its state, and with a true word about how it ended."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.runlog import RunLog
from tests.solver.identifiability.cases import free, problem_of

T = np.linspace(0.0, 8.0, 41)
SCATTER = 0.05 * np.random.default_rng(4).standard_normal(T.size)
POLISHED = {"kind": "particle_swarm", "particles": 10, "polish": True}
ALONE = {"max_evaluations": "off"}  # the search, without the runs that follow it


def polished(expression: str, parameters: dict[str, Any], y: np.ndarray, **changes: Any) -> Problem:
    stopping = {"max_evaluations": 1000}
    return problem_of(expression, parameters, y, T, method=POLISHED, answer=ALONE, **({"stopping": stopping} | changes))


def decay(**changes: Any) -> Problem:
    y = 3.0 * np.exp(-0.7 * T) + 0.5 + SCATTER
    return polished("a * exp(-k * x) + c", {"a": free(), "k": free(), "c": free(0.0, 2.0)}, y, **changes)


def gradient(problem: Problem, result: CalibrationResult) -> float:
    """Largest slope of the objective per standard error and objective, by differences of its own."""
    calibration = Calibration(problem, 1)
    assert result.best is not None
    best = result.best.parameters
    assert result.objective is not None
    slopes = []
    for index in range(best.size):
        step = np.zeros(best.size)
        step[index] = 1e-5 * best[index]
        up, down = calibration.evaluate(best + step).objective, calibration.evaluate(best - step).objective
        assert up is not None
        assert down is not None
        bend = max((up - 2.0 * result.objective + down) / 1e-10, 1e-300)
        slopes.append(abs(up - down) / 2e-5 / np.sqrt(bend * result.objective))
    return max(slopes)


def test_it_ends_where_no_gradient_is_left() -> None:
    for seed in range(3):
        result = calibrate(decay(), seed=seed)
        assert result.stop_reasons == ("polished",)
        assert gradient(decay(), result) < 1e-5


def looked_around() -> Problem:
    """A line through a bent curve: residuals follow each other, so other basins are looked for by what is linear."""
    y = 3.0 * np.exp(-0.7 * T) + 0.1 * T
    return polished("a * exp(-k * x) + c", {"a": free(), "k": free(), "c": free(-2.0, 2.0)}, y)


@pytest.mark.parametrize(("problem", "surveyed"), [(decay(), False), (looked_around(), True)], ids=["sure", "doubtful"])
def test_it_goes_on_from_its_state_bit_for_bit(problem: Problem, surveyed: bool) -> None:
    whole = calibrate(problem, seed=2)
    calibration = Calibration(problem, 2)
    progress, log, curves = Course(calibration).start(), RunLog(calibration), []
    history: list[float | None] = []
    while True:
        evaluations = [calibration.evaluate(x) for x in progress.positions]
        objectives = [e.objective for e in evaluations]
        history += objectives
        log.add([e.parameters for e in evaluations], objectives)
        curves.append([e.responses for e in evaluations])
        runs = log.runs(lambda keys: [curves[generation][particle] for generation, particle in keys])
        step = Course(calibration).advance(progress, objectives, 0.0, runs)
        if step.stop_reasons:
            break
        calibration = Calibration(problem, 2)
        progress = Progress.from_json(json.loads(json.dumps(step.progress.to_json())))
    assert step.progress.snapshot["ending"]["surveyed"] == surveyed
    assert step.stop_reasons == whole.stop_reasons
    assert history == [record.evaluation.objective for record in whole.history]


def improvable(problem: Problem, result: CalibrationResult) -> float:
    """By which share SciPy's least squares lower the objective from the best run."""
    calibration = Calibration(problem, 1)
    space = calibration.space
    assert result.best is not None
    assert result.objective is not None

    def residuals(unit: np.ndarray) -> np.ndarray:
        found = calibration.evaluate(space.from_unit(np.clip(unit, 0.0, 1.0)))
        return np.asarray(calibration.objective.weighted_residuals(found.responses))

    place = np.clip(space.to_unit(result.best.parameters), 1e-12, 1.0 - 1e-12)
    lower = least_squares(residuals, place, bounds=(0.0, 1.0), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    return 1.0 - 2.0 * lower.cost / result.objective


def peak(width: float) -> Problem:
    """A peak on a plateau: nothing changes where the calculated peak lies beside the points."""
    x = np.linspace(0.0, 10.0, 41)
    y = np.exp(-0.5 * ((x - 6.3) / width) ** 2) + 0.01 * np.random.default_rng(8).standard_normal(x.size)
    parameters = {"m": free(-60.0, 60.0), "w": free(width / 10.0, width * 10.0)}
    stopping = {"max_evaluations": 400}
    expression = "exp(-0.5 * ((x - m) / w)**2)"
    return problem_of(expression, parameters, y, x, method=POLISHED, answer=ALONE, stopping=stopping)


def test_polished_is_said_of_the_best_run_alone() -> None:
    """A run beside the descents that was better than their ends once stayed the result, and was called polished."""
    for seed in range(4):
        problem = peak(0.4)
        result = calibrate(problem, seed=seed)
        assert result.objective == min(
            r.evaluation.objective for r in result.history if r.evaluation.objective is not None
        )
        assert result.stop_reasons != ("polished",) or improvable(problem, result) < 1e-6


@pytest.mark.parametrize(("roughness", "reason"), [(1e-9, "polished"), (1e-6, "polished"), (1e-4, "polish_unfinished")])
def test_a_rough_model_costs_no_more_and_is_not_called_polished(roughness: float, reason: str) -> None:
    """Roughness as of a model that iterates: below what matters a minimum is one, above it gradients are left."""
    y = 3.0 * np.exp(-0.7 * T) + 0.5 + SCATTER
    rough = f"a * exp(-k * x) + c + {roughness} * sin(1e6 * (a + k + 0.1 * c) + x)"
    problem = polished(rough, {"a": free(), "k": free(), "c": free(0.0, 2.0)}, y)
    results = [calibrate(problem, seed=seed) for seed in range(1, 4)]
    # One search in thirty ends where the roughness itself has its least value.
    assert sum(result.stop_reasons == (reason,) for result in results) >= 2
    assert max(result.evaluations for result in results) < 200
    least = calibrate(decay(), seed=1).objective
    assert [result.objective for result in results] == pytest.approx([least] * 3, rel=10.0 * roughness)


def test_a_slow_first_evaluation_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = [record.evaluation.objective for record in calibrate(looked_around(), seed=2).history]
    evaluate, waits = Calibration.evaluate, iter([3600.0])
    monkeypatch.setattr(Calibration, "evaluate", lambda self, x: replace(evaluate(self, x), seconds=next(waits, 0.0)))
    assert [record.evaluation.objective for record in calibrate(looked_around(), seed=2).history] == whole


def test_a_plateau_is_no_minimum() -> None:
    problem = polished("where(a > 20, a, 0) * x + where(k > 20, k, 0)", {"a": free(), "k": free()}, 1.0 + SCATTER)
    assert calibrate(problem, seed=1).stop_reasons == ("polish_unfinished",)


def test_products_bounds_constraints_and_whole_numbers() -> None:
    y = 3.0 * np.exp(-0.7 * T) + SCATTER
    few = {"max_evaluations": 200}
    product = polished("a * b * exp(-k * x)", {"a": free(), "b": free(), "k": free()}, y, stopping=few)
    assert calibrate(product, seed=1).objective == pytest.approx(
        calibrate(polished("a * exp(-k * x)", {"a": free(), "k": free()}, y), seed=1).objective, rel=1e-6
    )
    bounded = polished("a * exp(-k * x)", {"a": free(0.1, 2.5), "k": free()}, y)
    result = calibrate(bounded, seed=1)
    assert result.parameters is not None
    assert result.parameters["a"] == pytest.approx(2.5, rel=1e-9)
    assert result.stop_reasons == ("polished",)
    tied = polished("a * exp(-k * x)", {"a": free(), "k": free()}, y, constraints=["a < 4 * k"], stopping=few)
    result = calibrate(tied, seed=1)
    assert result.parameters is not None
    assert result.parameters["a"] < 4.0 * result.parameters["k"]
    whole = polished(
        "a * exp(-k * x) * n / 3", {"a": free(), "k": free(), "n": {"lower": 1, "upper": 6, "integer": True}}, y
    )
    assert calibrate(whole, seed=1).stop_reasons == ("polished",)


def test_a_search_cut_off_says_so() -> None:
    result = calibrate(decay(stopping={"max_evaluations": 75}), seed=1)
    assert result.stop_reasons == ("max_evaluations",)


def test_an_oscillation_ends_in_its_least_basin_or_does_not_claim_it() -> None:
    """It once ended at forty times the least objective, called polished, while its report found the better set."""
    y = np.exp(-0.1 * T) * np.cos(6.0 * T) + SCATTER
    problem = polished("exp(-delta * x) * cos(omega * x)", {"delta": free(0.01, 1.0), "omega": free(0.5, 20.0)}, y)
    least = float(np.mean(SCATTER**2))
    ends = [calibrate(problem, seed=seed) for seed in range(3)]
    for result in ends:
        assert result.objective is not None
        assert result.stop_reasons != ("polished",) or gradient(problem, result) < 1e-4
    assert sum(result.objective < 1.01 * least for result in ends if result.objective is not None) >= 2
