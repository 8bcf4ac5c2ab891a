"""Follow-ups of jobs: more evaluations around the optimum or over the whole space, as jobs of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from geoswarm.records.job import Job
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.errors import NotExaminedError
from geoswarm.solver.identifiability.stored.exploring import explore_problem
from geoswarm.solver.identifiability.stored.follow_ups import (
    follow_up_of,
    global_problem,
    jackknife_problem,
    profile_problem,
    sensitivity_problem,
)
from geoswarm.solver.methods.design import Criterion
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.questions import (
    DEFAULT_DRAWS,
    DEFAULT_LEVEL,
    DEFAULT_RUNS,
    Source,
    design_question,
    prediction_question,
)
from geoswarm.workers.errors import NoOptimumError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.statistics import StoredJob

__all__ = [
    "EXPLORE_RUNS",
    "parent_of",
    "submit_design",
    "submit_explore",
    "submit_global_sensitivity",
    "submit_jackknife",
    "submit_prediction",
    "submit_profile",
    "submit_sensitivity",
]

EXPLORE_RUNS = 100

Submitted = tuple[Job, bool]


def submit_sensitivity(
    service: JobService,
    job_id: str,
    *,
    polish: bool = True,
    step: float | None = None,
    at: Mapping[str, float] | None = None,
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit the sensitivities at the best evaluation of a job, and return the new job.

    Parameters
    ----------
    polish
        Go to the minimum first; without, the sensitivities are one generation.
    step
        Largest difference in parts of the range.
    at
        Another optimum: values of the free parameters.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When no evaluation has succeeded.
    ProblemError, StatisticsError
        When there are fewer measured points than free parameters, or ``at`` is wrong.
    """
    parent, job = parent_of(service, job_id)
    if at is None:
        if job.record.best is None:
            raise NoOptimumError(f"job {parent} has no successful evaluation yet, so there is no optimum to examine")
        at = job.record.best.parameters
    missing = [name for name in job.problem.free_names if name not in at]
    if missing:
        raise StatisticsError(f"at: {', '.join(missing)} is missing; free: {', '.join(job.problem.free_names)}")
    optimum = np.array([at[name] for name in job.problem.free_names], dtype=np.float64)
    problem = sensitivity_problem(job.problem, optimum, seed=job.record.seed, step=step, polish=polish, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


def submit_profile(
    service: JobService,
    job_id: str,
    *,
    parameters: Sequence[str] | None = None,
    noise: Mapping[str, float] | float | None = None,
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit the profile objectives around the optimum that the sensitivities belong to, and return the new job.

    Parameters
    ----------
    parameters
        Those to profile; all when absent.
    noise
        Known standard deviation of a reading, base units.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When sensitivities are neither stored nor evaluated by a follow-up.
    StatisticsError
        When a name or the noise is wrong, or the noise is not known and cannot be estimated.
    """
    parent, job = parent_of(service, job_id)
    linearisation = service.statistics.linearisation(parent, noise=noise)
    if linearisation is None:
        raise NoOptimumError(
            f"profiles of job {parent} need the sensitivities at its optimum first: its stored evaluations are not "
            f"dense enough; POST /api/v1/jobs/{parent}/sensitivity evaluates them"
        )
    problem = profile_problem(job.problem, linearisation, seed=job.record.seed, parameters=parameters, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


def submit_jackknife(
    service: JobService, job_id: str, *, runs: int | None = None, idempotency_key: str | None = None
) -> Submitted:
    """Submit what :func:`.jackknife_problem` makes of the optimum that the sensitivities belong to; return the new job.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When there are no sensitivities at a minimum.
    ProblemError, StatisticsError
        As there.
    """
    parent, job = parent_of(service, job_id)
    linearisation = service.statistics.linearisation(parent)
    try:
        problem = jackknife_problem(job.problem, linearisation, seed=job.record.seed, runs=runs, of=parent)
    except NotExaminedError as error:
        raise NoOptimumError(_evaluate_first(parent, "a jackknife", error)) from error
    return service.submit(problem, idempotency_key=idempotency_key)


def submit_explore(
    service: JobService,
    job_id: str,
    *,
    runs: int = EXPLORE_RUNS,
    noise: Mapping[str, float] | float | None = None,
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit runs where a second basin would be most likely, by the stored evaluations of a job; return the new job.

    Parameters
    ----------
    runs
        Evaluations at most.
    noise
        Known standard deviation of a reading, base units.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When no evaluation has succeeded.
    ProblemError, StatisticsError
        When there are fewer measured points than free parameters, or ``runs`` or the noise are wrong.
    """
    parent, job = parent_of(service, job_id)
    if not job.samples.size:
        raise NoOptimumError(f"job {parent} has no successful evaluation yet, so there is nothing to explore around")
    linearisation = service.statistics.linearisation(parent, noise=noise)
    problem = explore_problem(job.problem, job.samples, linearisation, seed=job.record.seed, runs=runs, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


def submit_prediction(
    service: JobService,
    job_id: str,
    problem: Mapping[str, Any],
    *,
    runs: int = DEFAULT_RUNS,
    level: float = DEFAULT_LEVEL,
    noise: Mapping[str, float] | float | None = None,
    source: Source = "auto",
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit another problem with the identified parameters of a job, drawn from what is known of them.

    Parameters
    ----------
    problem
        The problem that is predicted; see :func:`geoswarm.solver.identifiability.prediction.question.predict_problem`.
    runs, level
        Forward runs, and share of the band.
    noise
        Known standard deviation of a reading, base units.
    source
        Where the draws come from.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When no evaluation has succeeded, or there are no sensitivities at a minimum.
    ProblemError, StatisticsError
        When the problem or an option is wrong, or the error of a reading is not known.
    """
    parent, job = parent_of(service, job_id)
    if not job.samples.size:
        raise NoOptimumError(f"job {parent} has no successful evaluation yet, so no parameters are identified")
    report = service.statistics.report(parent, noise=noise)
    try:
        question = prediction_question(
            report,
            problem,
            runs=runs,
            level=level,
            noise=noise,
            source=source,
            posterior=lambda: service.statistics.posterior(parent, noise=noise),
            of=parent,
        )
    except NotExaminedError as error:
        raise NoOptimumError(_evaluate_first(parent, "a prediction", error)) from error
    return service.submit(question, idempotency_key=idempotency_key)


def submit_design(
    service: JobService,
    job_id: str,
    candidates: Mapping[str, Any],
    *,
    predict: Mapping[str, Any] | None = None,
    criterion: Criterion | None = None,
    draws: int = DEFAULT_DRAWS,
    noise: Mapping[str, float] | float | None = None,
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit the sensitivities of candidate tests at the optimum of a job, and return the new job.

    Parameters
    ----------
    candidates
        The document of candidates.
    predict
        A problem whose prediction is to become narrower.
    criterion, draws
        What puts them in order, and over how many places around the optima it is averaged.

    Raises
    ------
    JobNotFoundError
    NoOptimumError
        When no evaluation has succeeded, or there are no sensitivities at a minimum.
    ProblemError, StatisticsError
        When the candidates or an option are wrong, or the error of a reading is not known.
    """
    parent, job = parent_of(service, job_id)
    if not job.samples.size:
        raise NoOptimumError(f"job {parent} has no successful evaluation yet, so no parameters are identified")
    report = service.statistics.report(parent, noise=noise)
    try:
        question = design_question(
            report, candidates, predict=predict, criterion=criterion, draws=draws, noise=noise, of=parent
        )
    except NotExaminedError as error:
        raise NoOptimumError(_evaluate_first(parent, "a design", error)) from error
    return service.submit(question, idempotency_key=idempotency_key)


def _evaluate_first(parent: str, what: str, error: NotExaminedError) -> str:
    return f"{what} from job {parent}: {error} (POST /api/v1/jobs/{parent}/sensitivity)"


def submit_global_sensitivity(
    service: JobService,
    job_id: str,
    *,
    kind: Literal["sobol", "morris"] = "sobol",
    samples: int | None = None,
    idempotency_key: str | None = None,
) -> Submitted:
    """Submit the design of Sobol or Morris over the search range of a job, and return the new job.

    Raises
    ------
    JobNotFoundError
    ProblemError
        When SALib is not installed, or ``samples`` is wrong.
    """
    parent, job = parent_of(service, job_id)
    problem = global_problem(job.problem, seed=job.record.seed, kind=kind, samples=samples, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


def parent_of(service: JobService, job_id: str) -> tuple[str, StoredJob]:
    """Return the job itself, or for a follow-up the one that it follows."""
    job = service.statistics.stored(job_id)
    parent = _followed(job.problem)
    return (job_id, job) if parent is None else (parent, service.statistics.stored(parent))


def _followed(problem: Problem) -> str | None:
    method = follow_up_of(problem)
    return None if method is None else method.of
