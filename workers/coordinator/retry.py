"""Reruns the failed evaluations of a paused or ended job, without changing the results given to the search.

The search received a failure when its generation was joined, and continued; that is not undone. Another
try changes the evaluation's own row, which then says what the forward model gives, and with it the best evaluation, the
counts of failures, and the state of a job that had failed for want of one success. The try that counted before stays in
the list of attempts. Only failures of a generation that was not joined yet reach the search.

While it lasts the job is ``running`` and ``retry_to`` says what it will be: paused, finished, failed or cancelled as
before, or running when a failure had ended it in mid-generation.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, func, insert, select, text, update

from geoswarm.records.states import ENDED_STATES, UNDONE_STATES
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import no_success_message
from geoswarm.solver.progress.state import Best, Progress
from geoswarm.workers.errors import InvalidTransitionError, NothingToRetryError
from geoswarm.workers.queries.evaluations import KEPT
from geoswarm.workers.queries.jobs import LockedJob, publish_state
from geoswarm.workers.queries.queue import REOPENED, first_place
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_json, text_of_program, unpack_array, unpack_json
from geoswarm.workers.store.outbox import insert_deliveries
from geoswarm.workers.store.tables import attempts, evaluations, generations, jobs

__all__ = ["begin_retry", "finish_retry", "open_retries"]

ACCEPTED = ("paused", *ENDED_STATES)


def begin_retry(connection: Connection, locked: LockedJob, *, gap: float) -> int:
    """Make the failed evaluations of a job claimable again; return their number.

    Raises
    ------
    InvalidTransitionError
        When the job is queued or running.
    NothingToRetryError
        When no evaluation has failed that could be run again.
    """
    row = locked.row
    if row.state not in ACCEPTED:
        raise InvalidTransitionError("retry the failed evaluations of", row.state, ACCEPTED)
    joined = bool(unpack_json(row.stop_reasons))
    unfinished = row.retry_to is None and not joined and row.state in ("paused", "failed")
    past = _reopen(connection, locked, evaluations.c.generation < row.generation)
    current = _reopen(connection, locked, evaluations.c.generation >= row.generation) if unfinished else 0
    if past + current == 0:
        raise NothingToRetryError(locked.id)
    if row.state == "paused" and past == 0:
        return current  # they go out when the job is resumed
    retry_to = row.retry_to or ("running" if row.state == "failed" and unfinished else row.state)
    values = {
        "state": "running",
        "retry_to": retry_to if past else None,
        "error": None,
        "finished_at": None,
        "run_seconds": locked.run_seconds(gap),
        "clock_at": locked.now,
        "rung_at": None,
        "served_at": None,
        "place": first_place(row.priority, row.created_at),
    }
    connection.execute(update(jobs).where(jobs.c.id == locked.id).values(values))
    publish_state(connection, locked, "running", unpack_json(row.stop_reasons), None)
    return past + current


def _reopen(connection: Connection, locked: LockedJob, where: ColumnElement[bool]) -> int:
    """Enter failed evaluations in the list of attempts and make them claimable; they keep their reason until then."""
    failed = and_(evaluations.c.job_id == locked.id, text("evaluations.state = 'failed'"), where)
    source = select(
        evaluations.c.job_id,
        evaluations.c.generation,
        evaluations.c.particle,
        evaluations.c.attempts,
        evaluations.c.worker,
        evaluations.c.started_at,
        func.coalesce(evaluations.c.finished_at, database_now()),
        func.coalesce(evaluations.c.reason, "bad_output"),
        evaluations.c.message,
        evaluations.c.log,
    ).where(failed)
    names = ["job_id", "generation", "particle", "number", "worker", "started_at", "finished_at", "outcome"]
    connection.execute(insert(attempts).from_select([*names, "message", "log"], source))
    changed = connection.execute(
        update(evaluations).where(failed).values(state="pending", worker=None, started_at=None, finished_at=None)
    )
    return int(changed.rowcount)


def open_retries(connection: Connection, locked: LockedJob) -> tuple[int | None, bool]:
    """Return the first generation with an evaluation to rerun (None if there is none), and whether some are running."""
    here = evaluations.c.job_id == locked.id
    past = evaluations.c.generation < locked.row.generation
    first = connection.scalar(select(func.min(evaluations.c.generation)).where(here, past, text(REOPENED)))
    running = select(func.count()).where(here, past, text("evaluations.state = 'running'"))
    return first, bool(connection.scalar(running))


def finish_retry(
    connection: Connection, locked: LockedJob, problem: Problem | None, *, gap: float, state: str | None = None
) -> None:
    """End the rerun, early or complete: recount, find the best, and set the state of the job.

    Parameters
    ----------
    problem
        None when it cannot be built any more: the best evaluation is not looked for.
    state
        State to end in; None: what the job was before.
    """
    row = locked.row
    here = and_(evaluations.c.job_id == locked.id, evaluations.c.generation < row.generation)
    unfinished = and_(here, evaluations.c.state.in_(UNDONE_STATES), evaluations.c.reason.is_not(None))
    connection.execute(
        update(evaluations)
        .where(unfinished)
        .values(state="failed", worker=None, lease_expires_at=None, finished_at=locked.now)
    )
    progress = Progress.from_json(unpack_json(row.progress))
    best = progress.best
    if problem is not None:
        answer = progress.answer  # neighbours of the minimum may be lower by chance
        searched = here if answer is None else and_(here, evaluations.c.generation < answer.generation)
        found = _best(connection, searched)
        best = found if best is None or (found is not None and found.objective < best.objective) else best
    counted = select(evaluations.c.reason, func.count()).where(here, text("evaluations.state = 'failed'"))
    reasons: Counter[str] = Counter()
    for reason, count in connection.execute(counted.group_by(evaluations.c.reason)):
        reasons[reason] = count
    progress = replace(progress, best=best, failed=reasons.total())
    failures = unpack_json(row.failures)
    first_message = failures["first_message"]
    target = state or row.retry_to
    error = row.error
    if target == "failed":
        serves = best is not None or failures.get("kept") or _some_kept(connection, here)
        target = "finished" if serves else "failed"
        error = None if serves else no_success_message(reasons, first_message)
    ended = target in ENDED_STATES
    values: dict[str, Any] = {
        "state": target,
        "retry_to": None,
        "progress": pack_json(progress.to_json()),
        "failed_evaluations": reasons.total(),
        "failures": pack_json(
            failures | {"reasons": dict(reasons), "first_message": first_message if reasons else None}
        ),
        "error": None if error is None else text_of_program(error),
        "run_seconds": locked.run_seconds(gap),
        "clock_at": locked.now if target == "running" else None,
        "finished_at": locked.now if ended else None,
        "rung_at": None,
    }
    if row.conclusion is not None and reasons.total() != row.failed_evaluations:  # statistics know more now
        values["conclusion"] = pack_json({"search_best": unpack_json(row.conclusion)["search_best"]})
    if best is not None and problem is not None:
        parameters = problem.values(best.parameters.tolist())
        values |= {
            "objective": best.objective,
            "best_generation": best.generation,
            "best_particle": best.particle,
            "parameters": pack_json(parameters),
            "at_bounds": pack_json(problem.at_bounds(parameters)),
        }
    connection.execute(update(jobs).where(jobs.c.id == locked.id).values(values))
    _refresh_generations(connection, locked)
    publish_state(connection, locked, target, unpack_json(row.stop_reasons), values["error"])
    if ended:
        insert_deliveries(connection, locked.id, row.owner, target, locked.now)


def _best(connection: Connection, here: ColumnElement[bool]) -> Best | None:
    columns = (evaluations.c.objective, evaluations.c.generation, evaluations.c.particle, evaluations.c.parameters)
    finished = select(*columns).where(here, evaluations.c.objective.is_not(None))
    row = connection.execute(finished.order_by(*columns[:3]).limit(1)).one_or_none()
    return None if row is None else Best(row.objective, row.generation, row.particle, unpack_array(row.parameters))


def _some_kept(connection: Connection, here: ColumnElement[bool]) -> bool:
    return connection.scalar(select(evaluations.c.particle).where(here, KEPT).limit(1)) is not None


def _refresh_generations(connection: Connection, locked: LockedJob) -> None:
    """Renew the best evaluation in the rows of generations with another try; totals stay as they were reported."""
    touched = select(attempts.c.generation).where(attempts.c.job_id == locked.id).distinct()
    lowest = (
        select(func.min(evaluations.c.objective))
        .where(evaluations.c.job_id == generations.c.job_id, evaluations.c.generation == generations.c.number)
        .scalar_subquery()
    )
    statement = update(generations).where(generations.c.job_id == locked.id, generations.c.number.in_(touched))
    connection.execute(statement.values(best_objective=lowest))
