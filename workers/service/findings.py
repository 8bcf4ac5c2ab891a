"""Follow-ups of jobs: more evaluations around the optimum or over the whole space, as jobs of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from geoswarm.records.job import Job
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.stored.findings import (
    follow_up_of,
    global_problem,
    profile_problem,
    sensitivity_problem,
)
from geoswarm.solver.problem import Problem
from geoswarm.workers.errors import NoOptimumError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.statistics import StoredJob

__all__ = ["submit_global_sensitivity", "submit_profile", "submit_sensitivity"]

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
    parent, job = _parent(service, job_id)
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
    parent, job = _parent(service, job_id)
    linearisation = service.statistics.linearisation(parent, noise=noise)
    if linearisation is None:
        raise NoOptimumError(
            f"profiles of job {parent} need the sensitivities at its optimum first: its stored evaluations are not "
            f"dense enough; POST /api/v1/jobs/{parent}/sensitivity evaluates them"
        )
    problem = profile_problem(job.problem, linearisation, seed=job.record.seed, parameters=parameters, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


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
    parent, job = _parent(service, job_id)
    problem = global_problem(job.problem, seed=job.record.seed, kind=kind, samples=samples, of=parent)
    return service.submit(problem, idempotency_key=idempotency_key)


def _parent(service: JobService, job_id: str) -> tuple[str, StoredJob]:
    """The job itself, or for a follow-up the one that it follows."""
    job = service.statistics.stored(job_id)
    parent = _followed(job.problem)
    return (job_id, job) if parent is None else (parent, service.statistics.stored(parent))


def _followed(problem: Problem) -> str | None:
    method = follow_up_of(problem)
    return None if method is None else method.of
