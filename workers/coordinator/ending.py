"""Changes the stop criteria of a job after submission; a job that has ended continues exactly where it was.

The search is asked for the next generation before the criteria are judged, so a job that ended by one of them has its
next generation at hand: with other criteria it goes on as if they had been given from the start.

Workers keep what they have read of a problem. So the changed criteria stand in the job's row, which is locked in every
exchange, and what was concluded under other ones does not count.
"""

from __future__ import annotations

from sqlalchemy import Connection, update

from geoswarm.records.states import ENDED_STATES, JOB_STATES
from geoswarm.solver.course import search_criteria, stop_criteria
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import Problem, Stopping
from geoswarm.solver.problem.running import least_answer
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.progress.stopping import (
    MaxEvaluations,
    StopCriterion,
    SwarmStatus,
    evaluations_left,
    satisfied_reasons,
)
from geoswarm.workers.access.quotas import check_quotas, lock_quotas
from geoswarm.workers.errors import InvalidTransitionError, NothingLeftError
from geoswarm.workers.queries.jobs import LockedJob, get_problem
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import GoOnRequested, Transition, apply
from geoswarm.workers.store.codec import pack_json, unpack_json
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.store.tables import jobs

__all__ = ["change_stopping", "changed_criteria"]

ACCEPTED = tuple(state for state in JOB_STATES if state != "failed")


def changed_criteria(stopping: str | None) -> tuple[StopCriterion, ...] | None:
    """Return the criteria of a row's ``stopping``; None if those of the problem apply."""
    return None if stopping is None else stop_criteria(Stopping.model_validate(unpack_json(stopping)))


def change_stopping(
    connection: Connection, locked: LockedJob, stopping: Stopping, settings: Settings, quota_of: str | None, taken: int
) -> Transition | None:
    """Store new stop criteria of a job; return how it continues if it had ended.

    Parameters
    ----------
    quota_of
        Owner whose quotas limit what may be planned; None: no owner.
    taken
        What the database takes of its disk now [bytes].

    Raises
    ------
    InvalidTransitionError
        When it has failed, or its failed evaluations are run again.
    NothingLeftError
        When it has ended and would not go on, or not for a single generation.
    ProblemError
        When its search needs a criterion and none is left, or draws its samples as a whole.
    QuotaExceededError
    """
    row = locked.row
    if row.state not in ACCEPTED or row.retry_to is not None:
        state = "rerunning failed evaluations" if row.retry_to is not None else row.state
        raise InvalidTransitionError("change the stop criteria of", state, ACCEPTED)
    stored = get_problem(connection, locked.id)
    if stored is None:
        raise RuntimeError(f"job {locked.id} has a row but no problem")
    wanted = stopping.model_dump(mode="json", exclude_none=True)
    problem = problem_of(stored.problem, pack_json(wanted))
    planned = problem.planned_evaluations
    if problem.method.role == "sampling" and planned != row.max_evaluations:
        raise ProblemError(
            [
                Issue(
                    "stopping.max_evaluations",
                    f"a sampling draws its {row.max_evaluations} points at once and cannot have {planned};"
                    " submit a new job with another number",
                )
            ]
        )
    ended = row.state in ENDED_STATES
    if ended and row.progress is not None:
        _refuse_to_stand_still(locked, problem)
    if quota_of is not None:
        more = (
            max((planned or 0) - row.evaluations, 0) if ended else max((planned or 0) - (row.max_evaluations or 0), 0)
        )
        size = {"document_bytes": 0, "evaluation_bytes": row.evaluation_bytes}
        lock_quotas(connection)
        check_quotas(connection, quota_of, more, settings, size=size, taken=taken, another=ended)
    values = {"stopping": pack_json(wanted), "max_evaluations": planned}
    connection.execute(update(jobs).where(jobs.c.id == locked.id).values(values))
    return apply(locked.job(), GoOnRequested()) if ended else None


def _refuse_to_stand_still(locked: LockedJob, problem: Problem) -> None:
    progress, criteria, room = Progress.from_json(unpack_json(locked.row.progress)), stop_criteria(problem.stopping), 0
    if locked.row.state != "cancelled" and progress.answer is not None:
        progress, criteria = progress.going_on(), search_criteria(problem, criteria)
        room = least_answer(len(problem.free))
    if not len(progress.positions):
        raise NothingLeftError(f"the search of job {locked.id} has nothing left to evaluate")
    status = SwarmStatus(
        evaluations=progress.evaluations,
        next_evaluations=len(progress.positions),
        seconds=locked.row.run_seconds,
        objective=None if progress.best is None else progress.best.objective,
        stagnation=progress.stagnant(problem.method),
    )
    reasons = satisfied_reasons(criteria, status) if progress.evaluations else ()
    left = evaluations_left(stop_criteria(problem.stopping), status.evaluations + status.next_evaluations)
    if not reasons and left is not None and left < room:
        reasons = (MaxEvaluations.reason,)  # no new intervals could follow, and those that it has would be lost
    if reasons:
        objective = "none" if status.objective is None else f"{status.objective:.6g}"
        raise NothingLeftError(
            f"job {locked.id} would end immediately by {', '.join(reasons)}: it has {status.evaluations} evaluations "
            f"and the next generation {status.next_evaluations} more, {status.seconds:.3g} s, objective {objective}, "
            f"{status.stagnation} generations without a lower one"
            + ("; a part of the evaluations is left to the runs after the search" if room else "")
        )
