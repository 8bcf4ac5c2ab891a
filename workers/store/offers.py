"""Runs that earlier jobs offer to a job: found when it is submitted, stored with it, read when it is taken up."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from sqlalchemy import Connection, insert, select

from geoswarm.solver.calibration import Offer
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import ParticleSwarmMethod, Problem, parse_problem
from geoswarm.solver.warm_start import EarlierRuns, best_of, forward_model_hash, offer_of
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.store.codec import pack_array, pack_responses, unpack_array, unpack_problem, unpack_responses
from geoswarm.workers.store.jobs import get_problem
from geoswarm.workers.store.tables import evaluations, jobs, offers

__all__ = ["MOST_READ", "WarmStart", "find_offer", "find_warm_starts", "read_offer", "write_offer"]

MOST_READ = 20_000
"""Evaluations of an earlier job that are looked at: its first ones."""

_LOOKED_AT, _SUGGESTED, _COUNTED = 50, 5, 2000  # newest jobs of the kind; those named; evaluations of each


@dataclass(frozen=True, slots=True)
class WarmStart:
    """An earlier job with the same forward model; ``evaluations`` of it could be taken over at no cost."""

    job: str
    name: str
    evaluations: int


def find_offer(connection: Connection, problem: Problem, visible: Callable[[Connection, str], object]) -> Offer | None:
    """Return what the jobs that a problem starts from offer to it.

    Parameters
    ----------
    visible
        Raises JobNotFoundError for a job that is not there for who asks.

    Raises
    ------
    ProblemError
        When one of them is not there or offers nothing, with the reason.
    """
    found: list[Offer] = []
    issues: list[Issue] = []
    for number, job_id in enumerate(problem.warm_start):
        try:
            visible(connection, job_id)
        except JobNotFoundError:
            issues.append(Issue(f"warm_start.jobs[{number}]", f"there is no job {job_id}"))
            continue
        offer = offer_of(problem, _earlier_runs(connection, job_id))
        if isinstance(offer, str):
            issues.append(Issue(f"warm_start.jobs[{number}]", f"job {job_id} {offer}"))
        else:
            found.append(offer)
    if issues:
        raise ProblemError(issues)
    return best_of(problem, found)


def find_warm_starts(connection: Connection, problem: Problem, owner: str | None) -> list[WarmStart]:
    """Return earlier jobs that have runs for a problem, newest first; none where it would not learn from them.

    Parameters
    ----------
    owner
        Whose jobs are looked at; None: all.
    """
    method = problem.method
    if not isinstance(method, ParticleSwarmMethod) or method.acceleration == "none" or problem.warm_start:
        return []
    statement = select(jobs.c.id, jobs.c.name, jobs.c.problem).where(
        jobs.c.forward_model == problem.forward_model.kind, jobs.c.evaluations > jobs.c.failed_evaluations
    )
    if owner is not None:
        statement = statement.where(jobs.c.owner == owner)
    newest = statement.order_by(jobs.c.created_at.desc(), jobs.c.id.desc()).limit(_LOOKED_AT)
    wanted, found = forward_model_hash(problem), []
    for row in connection.execute(newest).all():
        try:
            same = forward_model_hash(parse_problem(unpack_problem(row.problem))) == wanted
        except ProblemError:  # no longer accepted
            continue
        if not same:
            continue
        offer = offer_of(problem, _earlier_runs(connection, row.id, _COUNTED))
        if isinstance(offer, Offer):
            found.append(WarmStart(row.id, row.name, len(offer.parameters)))
        if len(found) == _SUGGESTED:
            break
    return found


def _earlier_runs(connection: Connection, job_id: str, most: int = MOST_READ) -> EarlierRuns:
    row = get_problem(connection, job_id)
    if row is None:
        raise JobNotFoundError(job_id)
    problem = parse_problem(unpack_problem(row.problem))
    columns = (evaluations.c.parameters, evaluations.c.responses)
    condition = (evaluations.c.job_id == job_id) & (evaluations.c.state == "finished")
    order = (evaluations.c.generation, evaluations.c.particle)
    rows = connection.execute(select(*columns).where(condition).order_by(*order).limit(most)).all()
    parameters = np.array([unpack_array(r.parameters) for r in rows]).reshape(-1, len(problem.free))
    return EarlierRuns(problem, parameters, [unpack_responses(r.responses) for r in rows])


def write_offer(connection: Connection, job_id: str, offer: Offer) -> None:
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


def read_offer(connection: Connection, job_id: str) -> Offer | None:
    """Return the offer that was stored with a job, None: there is none."""
    columns = (offers.c.parameters, offers.c.responses)
    rows = connection.execute(select(*columns).where(offers.c.job_id == job_id).order_by(offers.c.number)).all()
    if not rows:
        return None
    return Offer(
        np.array([unpack_array(row.parameters) for row in rows]), [unpack_responses(row.responses) for row in rows]
    )
