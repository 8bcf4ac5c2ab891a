"""Effect of a result, a lost worker or a returned claim on one evaluation among the rows of its generation."""

from __future__ import annotations

from collections.abc import Sequence

from sqlalchemy import Connection

from geoswarm.solver.problem.running import Failures, fatal_message
from geoswarm.workers.coordinator.generation_rows import Cell, GenerationRows
from geoswarm.workers.coordinator.work import Result
from geoswarm.workers.states.evaluation import Claimed, LeaseExpired, LeaseReleased, ResultArrived, settle
from geoswarm.workers.store.codec import pack_json, pack_responses, text_of_program
from geoswarm.workers.store.database import Record

__all__ = ["expire_cell", "give_back", "record_result"]

MESSAGE_LENGTH = 2000
SUPPOSED = ("overdue", "superseded", "worker_lost")
"""What is noted of a try of which nothing was heard; replaced when its worker hands in a result after all."""
STOPPED = "stopped"  # killed in mid-run because its job was paused or cancelled, or its worker was asked to end


def record_result(
    connection: Connection, rows: GenerationRows, result: Result, worker: str, failures: Failures
) -> str | None:
    """Store a result; return why it ends the job, or None."""
    cell = rows.cell(result.particle)
    before = cell.status
    if before.attempts == 0:
        before, _ = settle(before, Claimed(worker))  # begun in the worker that dispatched it
    # Counted by the number of its first try, or given to two workers: only the list of tries shows whether it is new.
    doubtful = before.done and before.worker == worker and before.attempts != result.attempt
    if (doubtful or cell.duplicates) and _taken_in(rows.tries(connection, cell), cell, result, worker):
        return None
    evaluation = result.evaluation
    reason = evaluation.reason
    again = False
    if reason is not None and not before.done and failures.retries(reason):
        tries = rows.tries(connection, cell)
        if any((row.number, row.worker, row.outcome) == (result.attempt, worker, reason) for row in tries):
            return None  # handed in before; only the answer was lost
        again = _further_try(tries, reason, failures)
    after, verdict = settle(before, ResultArrived(worker, result.attempt, reason is not None, again))
    message = None if evaluation.message is None else text_of_program(evaluation.message[:MESSAGE_LENGTH])
    log = None if result.log is None else text_of_program(result.log)
    if verdict in ("late", "retried"):
        outcome = reason if verdict == "retried" and reason is not None else "late"
        columns = {"started_at": result.started_at, "message": message, "log": log}
        rows.forget_try(connection, cell, result.attempt, worker, SUPPOSED)
        rows.note_try(cell, result.attempt, worker, outcome, result.finished_at, **columns)
        if after != before:
            cell.set(after, lease_expires_at=None, started_at=None)
        return None
    if verdict != "counted":
        return None
    if (before.state, before.worker, before.attempts) != ("running", worker, result.attempt):
        rows.forget_try(connection, cell, result.attempt, worker, SUPPOSED)
        if before.state == "running":  # it was given to another, and came first
            rows.note_try(cell, before.attempts, before.worker, "superseded", result.finished_at)
    cell.set(
        after,
        objective=evaluation.objective,
        misfits=pack_json(evaluation.misfits) if evaluation.misfits else None,
        responses=pack_responses(evaluation.responses) if evaluation.responses else None,
        reason=reason,
        message=message,
        log=log,
        lease_expires_at=None,
        seconds=evaluation.seconds,
        started_at=result.started_at,
        finished_at=result.finished_at,
    )
    if reason is None or not failures.ends_job(reason):
        return None
    return fatal_message(rows.generation, result.particle, reason, message)


def expire_cell(connection: Connection, rows: GenerationRows, cell: Cell, failures: Failures, now: float) -> str | None:
    """Take a running evaluation from a lost worker; return why that ends the job, or None."""
    before = cell.status
    tries = rows.tries(connection, cell)
    after, verdict = settle(before, LeaseExpired(_further_try(tries, "worker_lost", failures)))
    if verdict == "given_up":
        lost = 1 + sum(row.outcome == "worker_lost" for row in tries)
        message = f"the worker was lost {lost} times, last {before.worker}"
        cell.set(after, reason="worker_lost", message=message, finished_at=now, lease_expires_at=None)
        if failures.ends_job("worker_lost"):
            return fatal_message(rows.generation, cell.particle, "worker_lost", message)
    elif verdict == "redispatched":
        rows.note_try(cell, before.attempts, before.worker, "worker_lost", now)
        cell.set(after, lease_expires_at=None, started_at=None)
    return None


def give_back(rows: GenerationRows, cell: Cell, worker: str, attempt: int, now: float, *, killed: bool) -> None:
    """Take an evaluation back from a worker that has not finished it."""
    after, verdict = settle(cell.status, LeaseReleased(worker, attempt, killed))
    if verdict == "released":
        if killed:
            rows.note_try(cell, attempt, worker, STOPPED, now)
        cell.set(after, lease_expires_at=None, started_at=None)


def _further_try(tries: Sequence[Record], reason: str, failures: Failures) -> bool:
    return failures.tries_again(reason, [row.outcome for row in tries])


def _taken_in(tries: Sequence[Record], cell: Cell, result: Result, worker: str) -> bool:
    """Whether this result of an evaluation that two workers had was handed in before."""
    own = [row.outcome for row in tries if (row.number, row.worker) == (result.attempt, worker)]
    counted = cell.status.done and cell.status.worker == worker and not own
    return counted or any(outcome not in SUPPOSED or outcome == result.evaluation.reason for outcome in own)
