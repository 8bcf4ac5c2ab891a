"""Follow-ups through the in-process engine: the answer follows from the evaluations alone, finished or not."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.stored.findings import findings_of, join_findings
from geoswarm.solver.identifiability.stored.follow_ups import (
    global_problem,
    profile_problem,
    same_question,
    sensitivity_problem,
)
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.local import calibrate
from geoswarm.solver.runs.runlog import RunLog
from tests.solver.identifiability.cases import WHITE, X, free, linearised, problem_of

Y = 6.0 * X + 1.0 + np.random.default_rng(1).normal(0.0, 0.1, X.size)
LINE = problem_of("a * x + b", {"a": free(), "b": free()}, Y, noise=WHITE)
SLOPE, INTERCEPT = np.polyfit(X, Y, 1)


def run(problem: Problem) -> list[Evaluation]:
    return [record.evaluation for record in calibrate(problem).history]


def test_sensitivities_and_the_ends_of_intervals_give_the_textbook_errors() -> None:
    problem = sensitivity_problem(LINE, np.array([SLOPE, INTERCEPT]), seed=3, of="0123456789abcdef")
    result = calibrate(problem)
    # four places a parameter, the optimum, and then both ends of each interval
    assert (result.evaluations, result.generations) == (9 + 4, 2)
    assert result.stop_reasons == ("design_completed",)
    found = findings_of(problem, 3, [record.evaluation for record in result.history])
    assert found.linearisation is not None
    design = np.stack([X, np.ones_like(X)], axis=1)
    s2 = np.sum((Y - design @ [SLOPE, INTERCEPT]) ** 2) / (X.size - 2)
    errors = np.sqrt(s2 * np.diag(np.linalg.inv(design.T @ design)))
    np.testing.assert_allclose(found.linearisation.standard_errors, errors, rtol=1e-6)
    assert found.linearisation.at_optimum
    np.testing.assert_allclose(found.linearisation.bending, 0.0, atol=1e-6)  # a line does not bend
    assert found.linearisation.bases == ("linearised", "linearised")
    assert findings_of(problem, 3, []).notes == ("the sensitivities are not complete yet",)


def test_the_descent_finds_the_minimum_before_the_sensitivities() -> None:
    problem = sensitivity_problem(LINE, np.array([2.0, 5.0]), seed=3, polish=True)
    result = calibrate(problem)
    assert 1 < result.generations < 10
    found = findings_of(problem, 3, [record.evaluation for record in result.history])
    assert found.linearisation is not None
    np.testing.assert_allclose(found.linearisation.optimum, [SLOPE, INTERCEPT], rtol=1e-7)
    assert found.start_objective is not None
    assert found.objective is not None
    assert found.objective < 1e-2 * found.start_objective
    early = findings_of(problem, 3, [record.evaluation for record in result.history[:7]])
    assert early.notes == ("the descent to the minimum has not ended",)


def test_a_descent_stays_inside_the_bounds_and_the_constraints() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free(2.0, 10.0)}, Y, constraints=["a < 5.5"])
    follow_up = sensitivity_problem(problem, np.array([4.0, 5.0]), seed=3, polish=True)
    result = calibrate(follow_up)
    evaluations = [record.evaluation for record in result.history]
    assert {e.reason for e in evaluations} <= {None, "infeasible"}
    assert result.best is not None
    assert result.best.parameters[0] < 5.5
    assert result.best.parameters[1] >= 2.0
    assert len(evaluations) < 500


def test_profiles_run_as_a_job_and_can_go_on_after_any_generation() -> None:
    found = linearised(LINE, [SLOPE, INTERCEPT])
    problem = profile_problem(LINE, found, seed=3)
    calibration = Calibration(problem, 3)
    progress, log, evaluations = Course(calibration).start(), RunLog(calibration), []
    responses: list[list[dict[str, FloatArray]]] = []
    while True:
        progress = Progress.from_json(json.loads(json.dumps(progress.to_json(), allow_nan=False)))
        done = [calibration.evaluate(x) for x in progress.positions]
        evaluations += done
        log.add([e.parameters for e in done], [e.objective for e in done])
        responses.append([e.responses for e in done])
        runs = log.runs(lambda keys: [responses[generation][particle] for generation, particle in keys])
        step = Course(calibration).advance(progress, [e.objective for e in done], 1.0, runs)
        if step.stop_reasons:
            break
        progress = step.progress
    assert step.stop_reasons == ("design_completed",)
    straight = run(problem)
    np.testing.assert_array_equal([e.objective for e in evaluations], [e.objective for e in straight])
    profiles = findings_of(problem, 3, evaluations).profiles
    for profile in profiles:
        np.testing.assert_allclose(profile.interval, found.interval(profile.parameter), rtol=1e-3)
        assert profile.complete
    part = findings_of(problem, 3, evaluations[:20])
    assert part.notes == ("the profiles are not complete yet",)
    assert not all(profile.complete for profile in part.profiles)


def test_indices_of_a_design() -> None:
    problem = global_problem(LINE, seed=3, kind="morris", samples=10)
    result = calibrate(problem)
    assert result.evaluations == 30
    evaluations = [record.evaluation for record in result.history]
    found = findings_of(problem, 3, evaluations)
    assert [index.output for index in found.global_sensitivities] == ["objective", "y"]
    assert findings_of(problem, 3, evaluations[:7]).notes == ("7 of 30 evaluations of the design are done",)
    sobol = global_problem(LINE, seed=3, samples=8)
    assert sobol.planned_evaluations == 32
    both = join_findings([found, findings_of(sobol, 3, run(sobol))])
    assert [(index.kind, index.output) for index in both.global_sensitivities] == [
        ("morris", "objective"),
        ("morris", "y"),
        ("sobol", "objective"),
        ("sobol", "y"),
    ]


def test_infeasible_moves_fail_and_are_never_the_best() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, Y, constraints=["a <= 4"])
    result = calibrate(sensitivity_problem(problem, np.array([4.0, 5.0]), seed=3, polish=True))
    assert result.failed_evaluations > 0
    assert {r.evaluation.reason for r in result.history} == {None, "infeasible"}
    assert result.best is not None
    assert result.best.parameters[0] <= 4.0


def test_follow_ups_ask_the_same_question() -> None:
    follow_up = sensitivity_problem(LINE, np.array([SLOPE, INTERCEPT]), seed=3)
    assert same_question(LINE, follow_up)
    assert not same_question(LINE, problem_of("a * x + b", {"a": free(), "b": free()}, Y + 1.0))
    with pytest.raises(StatisticsError, match="particle_swarm is not a follow-up"):
        findings_of(LINE, 3, [])


@pytest.mark.parametrize(
    ("method", "path", "message"),
    [
        ({"kind": "sensitivity", "at": {"a": 1.0}}, "method.at", "must name the free parameters a, b, got a"),
        ({"kind": "sensitivity", "at": {"a": 1.0, "b": 99.0}}, "method.at.b", "between the bounds 0.1 and 10"),
        ({"kind": "profile", "at": {"a": 1.0, "b": 1.0}, "rise": {"c": 1.0}}, "method.rise", "c: not a free parameter"),
        ({"kind": "profile", "at": {"a": 1.0, "b": 1.0}, "rise": {"a": 0.0}}, "method.rise.a", "above 0"),
        ({"kind": "sobol", "samples": 100}, "method.samples", "must be a power of two, got 100"),
        ({"kind": "sensitivity", "at": {"a": 9.0, "b": 1.0}}, "method.at", "does not satisfy the constraints"),
    ],
)
def test_wrong_follow_ups_are_refused(method: dict[str, object], path: str, message: str) -> None:
    document = LINE.document() | {"method": method, "stopping": {}, "constraints": ["a < 5"]}
    with pytest.raises(ProblemError) as refused:
        parse_problem(document)
    assert [issue.path for issue in refused.value.issues] == [path]
    assert message in refused.value.issues[0].message


def test_one_point_for_two_parameters_is_refused() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0]), np.array([1.0]))
    with pytest.raises(ProblemError, match="1 measured point cannot determine 2 free parameters"):
        sensitivity_problem(problem, np.array([1.0, 1.0]), seed=3)
