"""Which follow-ups a job has, and the evaluations of one in their order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from sqlalchemy import Connection, select

from geoswarm.records.states import DONE_STATES
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.methods.registry import kinds_of
from geoswarm.solver.problem import Problem
from geoswarm.workers.queries.selection import read_evaluations
from geoswarm.workers.store.codec import unpack_array, unpack_json, unpack_responses
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.store.tables import jobs

__all__ = ["Sees", "StoredFollowUp", "evaluations_in_order", "find_parent", "follow_ups_of"]

_MOST = 50

Sees: TypeAlias = Callable[[str | None, str | None], bool]
"""Whether somebody sees a job, by its owner and its id."""


@dataclass(frozen=True, slots=True)
class StoredFollowUp:
    """A follow-up: its id, name, owner, kind of method, state, number of evaluations, and seed."""

    id: str
    name: str
    owner: str | None
    kind: str
    state: str
    evaluations: int
    seed: int
    document: str

    @property
    def problem(self) -> Problem:
        """Its problem."""
        return problem_of(self.document, name=self.name)


def find_parent(connection: Connection, problem: Problem, sees: Sees) -> str | None:
    """Return the job whose follow-up a problem is; None: it is of none, or of one that its submitter does not see."""
    of = problem.document()["method"].get("of")
    if of is None:
        return None
    row = connection.execute(select(jobs.c.id, jobs.c.owner).where(jobs.c.id == of)).one_or_none()
    return None if row is None or not sees(row.owner, row.id) else str(row.id)


def follow_ups_of(connection: Connection, job: Any) -> list[StoredFollowUp]:
    """Return the latest follow-ups of a job, the newest first; ``job`` is its row."""
    names = ("id", "name", "owner", "method", "state", "evaluations", "seed", "problem")
    rows = connection.execute(
        select(*(jobs.c[name] for name in names))
        .where(jobs.c.method.in_(kinds_of("follow_up")), jobs.c.parent == job.id)
        .order_by(jobs.c.created_at.desc(), jobs.c.id)
        .limit(_MOST)
    )
    return [StoredFollowUp(*r) for r in rows]


def evaluations_in_order(connection: Connection, job_id: str, first: int = 0) -> list[Evaluation]:
    """Return the evaluations from a generation on, by generation and particle, up to the first that has not ended."""
    found: list[Evaluation] = []
    for row in read_evaluations(connection, job_id, None, first):
        if row.state not in DONE_STATES:
            break
        found.append(
            Evaluation(
                unpack_array(row.parameters),
                row.objective,
                {} if row.misfits is None else unpack_json(row.misfits),
                {} if row.responses is None else unpack_responses(row.responses),
                row.reason,
                row.message,
                row.seconds or 0.0,
            )
        )
    return found
