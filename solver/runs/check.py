"""Tests a problem before it becomes a job: one forward calculation and an estimate of the cost."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation, choose_seed
from geoswarm.solver.course import Course
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.plausibility import implausible, require_possible
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.checks.consolidation import find_consolidation
from geoswarm.solver.problem.checks.extremes import extreme_issues
from geoswarm.solver.problem.weighting import WeightShare, weight_shares
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.runlog import RunLog
from geoswarm.solver.sentences import Sentence, plain

__all__ = ["CheckReport", "TestRunReport", "check_problem", "warnings_of"]

_LOOKED_AT = 140
"""Runs that a search which learns looks at."""

WARM_UP_LIMIT = 5.0
"""A first calculation shorter than this [s] is repeated: it may have been loading its kernels."""


@dataclass(frozen=True, slots=True)
class TestRunReport:
    """Outcome of the one forward calculation.

    Parameters
    ----------
    state
        ``finished`` or ``failed``.
    parameters
        Values of all parameters (free, fixed, linked) that it was made for.
    objective, misfits
        f and f'_g of every observed series, in base units squared; None and empty when failed.
    responses
        Every observed series, calculated at its observed points: ``x`` and ``y`` in base units, each of length m_g;
        empty when failed.
    seconds
        Wall time of the calculation when warm [s].
    reason, message
        Kind of failure and what happened, or None.
    """

    __test__ = False

    state: str
    parameters: dict[str, float]
    objective: float | None
    misfits: dict[str, float]
    responses: dict[str, dict[str, list[float]]]
    seconds: float
    reason: str | None
    message: str | None


@dataclass(frozen=True, slots=True)
class CheckReport:
    """What a valid problem will run and cost.

    Parameters
    ----------
    name, forward_model, method
        As in the problem.
    free_parameters
        Names in the order of the problem.
    data_points
        Number of measured points in all observations.
    planned_evaluations
        Most evaluations that the job makes; None when only time or quality ends it.
    left_to_answer
        How many of these the search leaves for minimum and intervals; None without a plan.
    test_run
        The one forward calculation.
    estimated_seconds
        Time of the planned evaluations on one worker and of the search itself, at most ``max_seconds`` [s]; None
        without a plan.
    warnings
        What is probably not meant, what in the measurements the model does not contain, and what to do, in sentences.
    notes
        What was done to the readings, by series.
    assumptions
        What the forward model assumes where the problem says nothing, with the field that would say it, in sentences.
    shares
        What the weights make of each series, before the search.
    """

    name: str
    forward_model: str
    method: str
    free_parameters: tuple[str, ...]
    data_points: int
    planned_evaluations: int | None
    left_to_answer: int | None
    test_run: TestRunReport
    estimated_seconds: float | None
    warnings: tuple[str, ...] = ()
    notes: dict[str, tuple[str, ...]] = field(default_factory=dict)
    assumptions: tuple[str, ...] = ()
    shares: tuple[WeightShare, ...] = ()


def warnings_of(problem: Problem) -> tuple[Sentence, ...]:
    """Return what is possible, but seldom meant; nothing runs."""
    return (*implausible(problem), *(found.parts for found in find_consolidation(problem)))


def check_problem(
    problem: Problem, evaluate: Callable[[Calibration, FloatArray], Evaluation] = Calibration.evaluate
) -> CheckReport:
    """Make one test run of a problem and estimate its cost.

    The run is made at the initial values where given and in the middle of the bounds (in search coordinates) elsewhere,
    or at the first feasible proposal of the search when that point violates a constraint. A failed run is reported,
    not raised.

    Parameters
    ----------
    evaluate
        Makes one forward calculation at natural values of the free parameters, shape (d,); here and now unless given.

    Raises
    ------
    InfeasibleSpaceError
        When no proposal satisfies the constraints.
    ProblemError
        When the forward model cannot be prepared for the observed points, a weight or an error of readings is beyond
        what can be calculated with, or readings are impossible and not accepted.
    """
    if extreme := extreme_issues(problem):
        raise ProblemError(extreme)
    require_possible(problem)
    problem.forward_model.require_available()
    calibration = Calibration(problem, choose_seed(problem.seed))
    course = Course(calibration)
    start = course.start()
    point = middle(calibration)
    if not calibration.space.feasible(point):
        point = start.positions[0]
    run = evaluate(calibration, point)
    if run.seconds < WARM_UP_LIMIT and not problem.forward_model.runs_outside:
        run = evaluate(calibration, point)
    planned = problem.planned_evaluations
    return CheckReport(
        name=problem.name,
        forward_model=problem.forward_model.kind,
        method=problem.method.kind,
        free_parameters=problem.free_names,
        warnings=tuple(map(plain, warnings_of(problem))),
        notes={o.series: o.notes for o in problem.observations if o.notes},
        assumptions=problem.forward_model.assumptions,
        shares=weight_shares(problem),
        data_points=sum(len(observation.x) for observation in problem.observations),
        planned_evaluations=planned,
        left_to_answer=None if planned is None else problem.left_to_answer(planned),
        test_run=_report(run, problem, problem.values(point.tolist())),
        estimated_seconds=_estimate(
            run.seconds + search_seconds(course, start, run), planned, problem.stopping.max_seconds
        ),
    )


def middle(calibration: Calibration) -> FloatArray:
    """Initial values where given, else the middle of the bounds in search coordinates; natural values, shape (d,)."""
    space = calibration.space
    centre = space.to_natural((space.search_lower + space.search_upper) / 2)
    initial = [parameter.initial for parameter in calibration.problem.free]
    return np.array([c if i is None else i for c, i in zip(centre, initial, strict=True)], dtype=np.float64)


def search_seconds(course: Course, start: Progress, run: Evaluation) -> float:
    """Time that the search itself takes for one evaluation [s], measured at one generation after made-up runs.

    Only a search that learns from all runs takes any time that counts, and the more the more runs there are: so it is
    tried in the middle of the plan, at most after as many runs as such a search looks at. Their responses are those of
    the ``run``, scaled by where they are.
    """
    calibration, method = course.calibration, course.problem.method
    if not method.learns or method.role == "follow_up" or run.reason is not None:
        return 0.0
    planned, space = calibration.problem.planned_evaluations, calibration.space
    earlier = _LOOKED_AT if planned is None else min(planned // 2, _LOOKED_AT)
    log = RunLog(calibration)
    anywhere = space.from_unit(np.random.default_rng(calibration.seed).random((earlier, space.dimension)))
    positions = np.concatenate([anywhere, start.positions])
    factors = (1.0 + space.to_unit(positions)).prod(axis=1).tolist()
    stored = [{series: y * factor for series, y in run.responses.items()} for factor in factors]
    objectives = [calibration.objective.value(calibration.objective.misfits(responses)) for responses in stored]
    log.add(list(positions), objectives)
    runs = log.runs(lambda keys: [stored[particle] for _, particle in keys])
    began = time.perf_counter()
    course.advance(start, objectives[earlier:], 0.0, runs, criteria=())
    return (time.perf_counter() - began) / len(start.positions)


def _estimate(seconds: float, planned: int | None, max_seconds: float | None) -> float | None:
    if planned is None:
        return max_seconds
    whole = seconds * planned
    return whole if max_seconds is None else min(whole, max_seconds)


def _report(run: Evaluation, problem: Problem, parameters: dict[str, float]) -> TestRunReport:
    observed = {observation.series: observation.x for observation in problem.observations}
    return TestRunReport(
        state="finished" if run.reason is None else "failed",
        parameters=parameters,
        objective=run.objective,
        misfits=run.misfits,
        responses={name: {"x": observed[name].tolist(), "y": y.tolist()} for name, y in run.responses.items()},
        seconds=run.seconds,
        reason=run.reason,
        message=run.message,
    )
