"""The swarm that aims particles at what all runs so far promise."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.course import Course
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.runlog import RunLog
from tests.solver.problems import decay_problem

EXAMPLES = Path(__file__).parents[3] / "examples"
ACCELERATED = {"kind": "particle_swarm", "particles": 10, "acceleration": "response_surface"}
ALONE = {"max_evaluations": "off"}  # the search, without the runs that follow it


def accelerated(example: str, **stopping: float) -> Problem:
    document = load_problem(EXAMPLES / example / "problem.yaml").document()
    return parse_problem(document | {"method": ACCELERATED, "answer": ALONE, "stopping": stopping})


def objectives(result: CalibrationResult) -> list[float | None]:
    return [record.evaluation.objective for record in result.history]


def test_the_published_oedometer_takes_tens_of_runs() -> None:
    problem = accelerated("oedometer", max_evaluations=1590, target_objective=5e-9)
    results = [calibrate(problem, seed=seed) for seed in range(30)]
    assert all("target_objective" in result.stop_reasons for result in results)
    evaluations = [result.evaluations for result in results]
    assert 20 <= np.median(evaluations) <= 40
    assert np.percentile(evaluations, 90) <= 70


def test_failing_runs_cost_little() -> None:
    problem = decay_problem(
        forward_model={"kind": "formula", "series": {"y": "amplitude * exp(-rate * x) + 0 * sqrt(rate - 0.2)"}},
        method=ACCELERATED,
        answer=ALONE,
    )
    result = calibrate(problem)
    assert "target_objective" in result.stop_reasons
    assert result.failed_evaluations > 0
    assert result.evaluations <= 100


def test_the_same_seed_gives_the_same_history_for_any_number_of_workers() -> None:
    problem = accelerated("oedometer", max_evaluations=60)
    assert objectives(calibrate(problem, workers=2)) == objectives(calibrate(problem))


def shares_of(problem: Problem, generations: int) -> list[float]:
    calibration = Calibration(problem, seed=4)
    course = Course(calibration)
    log, progress = RunLog(calibration), course.start()
    shares, responses = [], []
    for _ in range(generations):
        evaluations = [calibration.evaluate(position) for position in progress.positions]
        values = [e.objective for e in evaluations]
        log.add([e.parameters for e in evaluations], values)
        responses.append([e.responses for e in evaluations])
        runs = log.runs(lambda keys: [responses[generation][particle] for generation, particle in keys])
        progress = course.advance(progress, values, 1.0, runs).progress
        json.dumps(progress.to_json(), allow_nan=False)
        shares.append(progress.snapshot["proposer"]["share"])
    return shares


def test_all_particles_descend_and_with_an_objective_alone_aiming_gives_way_where_it_does_not_pay() -> None:
    assert shares_of(decay_problem(method=ACCELERATED), 4) == [1.0] * 4
    flat = {"kind": "formula", "series": {"y": "0 * amplitude + 0 * rate + 0 * x"}}
    one = [{"series": "y", "points": {"x": [1.0], "y": [2.0]}}]
    falling = shares_of(decay_problem(forward_model=flat, observations=one, method=ACCELERATED), 12)
    assert falling == sorted(falling, reverse=True)
    assert (falling[0], falling[-1]) == (0.9, 0.4)


def test_no_run_is_made_twice() -> None:
    result = calibrate(decay_problem(method=ACCELERATED, answer=ALONE, stopping={"max_evaluations": 300}))
    positions = np.array([record.evaluation.parameters for record in result.history])
    assert len(np.unique(positions, axis=0)) == len(positions) == 300


def test_an_accelerated_search_needs_the_runs() -> None:
    course = Course(Calibration(decay_problem(method=ACCELERATED), seed=4))
    with pytest.raises(ValueError, match="needs the runs so far"):
        course.advance(course.start(), [1.0] * 10, 1.0)
