"""Runs that earlier jobs offer to a job: found when it is submitted, stored with it, read when it starts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from sqlalchemy import Connection, insert, select, update

from geoswarm.records.problem import WarmStart
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import WarmStartRuns
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import Points, Problem
from geoswarm.solver.runs.warm_start import OTHER_MODEL, EarlierRuns, best_of, forward_model_hash, offer_of, usable_runs
from geoswarm.workers.cache import Cache
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.queries.jobs import get_problem
from geoswarm.workers.queries.selection import MOST_READ, MOST_VALUES
from geoswarm.workers.store.codec import pack_array, pack_responses, unpack_array, unpack_responses
from geoswarm.workers.store.database import Record, Store
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.store.tables import evaluations, jobs, offers

__all__ = ["find_offer", "find_warm_starts", "read_offer", "write_offer"]

_LOOKED_AT, _SUGGESTED, _COUNTED = 50, 5, 2000  # newest jobs of the kind; those named; evaluations of each


def find_offer(store: Store, problem: Problem, visible: Callable[[Connection, str], object]) -> WarmStartRuns | None:
    """Return what the jobs that a problem starts from offer to it.

    Parameters
    ----------
    visible
        Raises JobNotFoundError for a job that the caller may not see.

    Raises
    ------
    ProblemError
        When one of them is not there or offers nothing, with the reason.
    """
    found: list[WarmStartRuns] = []
    issues: list[Issue] = []
    wanted = forward_model_hash(problem)
    for number, job_id in enumerate(problem.warm_start):
        try:
            offer = _offer(store, problem, wanted, job_id, visible)
        except JobNotFoundError:
            issues.append(Issue(f"warm_start.jobs[{number}]", f"there is no job {job_id}"))
            continue
        if isinstance(offer, str):
            issues.append(Issue(f"warm_start.jobs[{number}]", f"job {job_id} {offer}"))
        else:
            found.append(offer)
    if issues:
        raise ProblemError(issues)
    return best_of(problem, found)


def find_warm_starts(store: Store, problem: Problem, owner: str | None, cache: Cache) -> list[WarmStart]:
    """Return earlier jobs that have runs for a problem, newest first; none where it would not learn from them.

    Parameters
    ----------
    owner
        Whose jobs are looked at; None: all.
    cache
        Keeps what was read of earlier jobs.
    """
    method = problem.method
    if not method.takes_offers or problem.warm_start:
        return []
    statement = select(jobs.c.id, jobs.c.name, jobs.c.forward_hash).where(
        jobs.c.forward_model == problem.forward_model.kind, jobs.c.evaluations > jobs.c.failed_evaluations
    )
    if owner is not None:
        statement = statement.where(jobs.c.owner == owner)
    newest = statement.order_by(jobs.c.created_at.desc(), jobs.c.id.desc()).limit(_LOOKED_AT)
    wanted, found = forward_model_hash(problem), []
    for row in store.read(lambda connection: connection.execute(newest).all()):
        try:
            if (row.forward_hash or _learned_hash(store, row.id)) != wanted:
                continue
            earlier = cache.once((row.id, "earlier"), partial(_slim, store, row.id))
            runs = store.read(partial(_runs, job_id=row.id, most=_COUNTED, responses=False))
        except (ProblemError, JobNotFoundError):  # no longer accepted, or deleted meanwhile
            continue
        usable = usable_runs(problem, earlier, _parameters(earlier, runs))
        if not isinstance(usable, str):
            found.append(WarmStart(job=row.id, name=row.name, evaluations=len(usable[1])))
        if len(found) == _SUGGESTED:
            break
    return found


def _offer(
    store: Store, problem: Problem, wanted: str, job_id: str, visible: Callable[[Connection, str], object]
) -> WarmStartRuns | str:
    """Return what one job offers. Documents are parsed between the transactions, not in one."""

    def known(connection: Connection) -> str | None:
        visible(connection, job_id)
        found: str | None = connection.scalar(select(jobs.c.forward_hash).where(jobs.c.id == job_id))
        return found

    if (store.read(known) or _learned_hash(store, job_id)) != wanted:
        return OTHER_MODEL
    earlier = _stored_problem(store, job_id)
    most = max(min(MOST_READ, MOST_VALUES // sum(o.x.size for o in earlier.observations)), 1)  # its first ones
    runs = store.read(partial(_runs, job_id=job_id, most=most, responses=True))
    responses = [unpack_responses(run.responses) for run in runs]
    return offer_of(problem, EarlierRuns(earlier, _parameters(earlier, runs), responses))


def _learned_hash(store: Store, job_id: str) -> str:
    """Find the hash of a job that was submitted before hashes were stored, and store it."""
    found = forward_model_hash(_stored_problem(store, job_id))
    statement = update(jobs).where(jobs.c.id == job_id).values(forward_hash=found)
    store.write(lambda connection: connection.execute(statement))
    return found


def _stored_problem(store: Store, job_id: str) -> Problem:
    row = store.read(lambda connection: get_problem(connection, job_id))
    if row is None:
        raise JobNotFoundError(job_id)
    return problem_of(row.problem)


def _slim(store: Store, job_id: str) -> Problem:
    """The problem of a job without its measurements as they were given, to be kept."""
    problem = _stored_problem(store, job_id)
    none = Points([], [], None)
    return replace(problem, observations=tuple(replace(o, points=none) for o in problem.observations))


def _runs(connection: Connection, job_id: str, most: int, *, responses: bool) -> Sequence[Record]:
    columns = (evaluations.c.parameters, evaluations.c.responses) if responses else (evaluations.c.parameters,)
    condition = (evaluations.c.job_id == job_id) & (evaluations.c.state == "finished")
    order = (evaluations.c.generation, evaluations.c.particle)
    return connection.execute(select(*columns).where(condition).order_by(*order).limit(most)).all()


def _parameters(problem: Problem, runs: Sequence[Record]) -> FloatArray:
    return np.array([unpack_array(run.parameters) for run in runs]).reshape(-1, len(problem.free))


def write_offer(connection: Connection, job_id: str, offer: WarmStartRuns) -> None:
    """Store an offer with a new job."""
    rows = zip(offer.parameters, offer.responses, strict=True)
    values = [
        {
            "job_id": job_id,
            "number": number,
            "parameters": pack_array(parameters),
            "responses": pack_responses(responses),
        }
        for number, (parameters, responses) in enumerate(rows)
    ]
    connection.execute(insert(offers), values)


def read_offer(connection: Connection, job_id: str) -> WarmStartRuns | None:
    """Return the offer that was stored with a job, None: there is none."""
    columns = (offers.c.parameters, offers.c.responses)
    rows = connection.execute(select(*columns).where(offers.c.job_id == job_id).order_by(offers.c.number)).all()
    if not rows:
        return None
    return WarmStartRuns(
        np.array([unpack_array(row.parameters) for row in rows]), [unpack_responses(row.responses) for row in rows]
    )
