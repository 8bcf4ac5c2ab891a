"""What the follow-ups of a job would cost, before one is submitted."""

from __future__ import annotations

from sqlalchemy import Connection

from geoswarm.records.progress import FollowUpCost, FollowUpCosts
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability.stored.follow_ups import global_problem
from geoswarm.solver.methods.jackknife import lacks_tests, most_runs
from geoswarm.solver.problem.running import least_answer
from geoswarm.workers.queries.progress import free_workers, mean_seconds
from geoswarm.workers.service.findings import EXPLORE_RUNS, parent_of
from geoswarm.workers.service.job_service import JobService

__all__ = ["follow_up_costs"]

NO_OPTIMUM = "There is no successful evaluation yet to start from."
NO_SENSITIVITIES = "It needs the sensitivities at the optimum first."
_STEPS = 3  # generations of 2 d + 1 on the way to the minimum, by experience
_ALONG_PROFILE = 14  # values of a parameter, both sides together, of d runs each, by experience


def follow_up_costs(service: JobService, job_id: str) -> FollowUpCosts:
    """Return runs and time of every follow-up of a job; of a follow-up, those of the job that it follows.

    Raises
    ------
    JobNotFoundError
    """
    parent, job = parent_of(service, job_id)
    free = len(job.problem.free)
    lease = service.settings.lease_seconds

    def work(connection: Connection) -> tuple[float | None, int]:
        return mean_seconds(connection, parent, max(job.record.generations - 1, 0)), free_workers(connection, lease)

    each, workers = service.store.read(work)
    no_optimum = NO_OPTIMUM if job.record.best is None else None
    no_profile = no_optimum
    if no_profile is None and service.statistics.linearisation(parent) is None:
        no_profile = NO_SENSITIVITIES

    def cost(kind: str, runs: int, *, exact: bool, refused: str | None) -> FollowUpCost:
        seconds = None if each is None else each * runs / max(workers, 1)
        return FollowUpCost(kind=kind, evaluations=runs, exact=exact, seconds=seconds, refused=refused)  # type: ignore[arg-type]

    sensitivity = least_answer(free) + 2 * free + _STEPS * (2 * free + 1)
    profile = _ALONG_PROFILE * free * free
    items = [
        cost("sensitivity", sensitivity, exact=False, refused=no_optimum),
        cost("profile", profile, exact=False, refused=no_profile),
        cost("explore", EXPLORE_RUNS, exact=False, refused=no_optimum),
        cost("again", job.record.evaluations, exact=False, refused=None),
    ]
    if lacks_tests(job.problem) is None:
        tests = len({test for test, _ in job.problem.series_by_test if test})
        items.append(cost("jackknife", most_runs(free, tests), exact=False, refused=no_profile))
    try:
        planned = global_problem(job.problem, seed=job.record.seed, of=parent).planned_evaluations or 0
        items.append(cost("sobol", planned, exact=True, refused=None))
    except SolverError as error:
        items.append(cost("sobol", 0, exact=True, refused=str(error)))
    return FollowUpCosts(items=items, run_seconds=each, workers=workers)
