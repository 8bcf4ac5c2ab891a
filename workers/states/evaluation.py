"""The life of one evaluation as a pure state machine: what a claim, a result or a lost lease does to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, assert_never

from geoswarm.records.states import DONE_STATES, EvaluationState

__all__ = [
    "Claimed",
    "Duplicated",
    "EvaluationEvent",
    "EvaluationStatus",
    "LeaseExpired",
    "LeaseReleased",
    "Reopened",
    "ResultArrived",
    "Verdict",
    "settle",
]

Verdict: TypeAlias = Literal[
    "claimed",
    "counted",
    "duplicated",
    "given_up",
    "ignored",
    "late",
    "redispatched",
    "released",
    "reopened",
    "retried",
]


@dataclass(frozen=True, slots=True)
class EvaluationStatus:
    """State (pending, running, finished or failed), tries so far, and the worker that holds or held it."""

    state: EvaluationState = "pending"
    attempts: int = 0
    worker: str | None = None

    @property
    def done(self) -> bool:
        """Whether a result has been counted."""
        return self.state in DONE_STATES


@dataclass(frozen=True, slots=True)
class Claimed:
    """A worker takes it up."""

    worker: str


@dataclass(frozen=True, slots=True)
class Duplicated:
    """Another worker takes it up as well, because it is overdue; the first answer counts."""

    worker: str


@dataclass(frozen=True, slots=True)
class ResultArrived:
    """A worker hands in the outcome of its attempt; ``again``: it failed, and there is a further try for its reason."""

    worker: str
    attempt: int
    failed: bool
    again: bool = False


@dataclass(frozen=True, slots=True)
class LeaseExpired:
    """Nothing was heard of the worker for longer than its lease, or it is known to be dead.

    ``again``: there is a further try for lost workers.
    """

    again: bool


@dataclass(frozen=True, slots=True)
class LeaseReleased:
    """The worker gives it back, untouched or ``begun``."""

    worker: str
    attempt: int
    begun: bool = False


@dataclass(frozen=True, slots=True)
class Reopened:
    """The user wants another try at it although it has failed."""


EvaluationEvent: TypeAlias = Claimed | Duplicated | ResultArrived | LeaseExpired | LeaseReleased | Reopened


def settle(status: EvaluationStatus, event: EvaluationEvent) -> tuple[EvaluationStatus, Verdict]:
    """Apply one event; pure. An event that comes twice, or too late, is ignored or recorded as late."""
    match event:
        case Claimed(worker):
            if status.state == "running" and status.worker == worker:
                return status, "claimed"  # the answer to the first claim was lost
            if status.state != "pending":
                return status, "ignored"
            return EvaluationStatus("running", status.attempts + 1, worker), "claimed"
        case Duplicated(worker):
            if status.state != "running" or status.worker == worker:
                return status, "ignored"
            return EvaluationStatus("running", status.attempts + 1, worker), "duplicated"
        case ResultArrived():
            return _result(status, event)
        case LeaseExpired(again):
            if status.state != "running":
                return status, "ignored"
            if not again:
                return replace(status, state="failed"), "given_up"
            return replace(status, state="pending", worker=None), "redispatched"
        case LeaseReleased(worker, attempt, begun):
            if not _holds(status, worker, attempt):
                return status, "ignored"
            return EvaluationStatus("pending", status.attempts - (not begun), None), "released"
        case Reopened():
            if status.state != "failed":
                return status, "ignored"
            return EvaluationStatus("pending", status.attempts, None), "reopened"
        case _:
            assert_never(event)


def _result(status: EvaluationStatus, event: ResultArrived) -> tuple[EvaluationStatus, Verdict]:
    holds = _holds(status, event.worker, event.attempt)
    if status.done:
        same = status.worker == event.worker and status.attempts == event.attempt
        return status, "ignored" if same else "late"
    if event.failed and event.again:
        if event.attempt > status.attempts:
            return status, "ignored"
        # Another worker that is at it continues.
        return (replace(status, state="pending", worker=None) if holds else status), "retried"
    if event.failed and status.state == "running" and not holds:
        return status, "retried"  # the other try under way may still succeed
    # The first result counts, whichever worker holds the lease now.
    return EvaluationStatus("failed" if event.failed else "finished", status.attempts, event.worker), "counted"


def _holds(status: EvaluationStatus, worker: str, attempt: int) -> bool:
    return status.state == "running" and (status.worker, status.attempts) == (worker, attempt)
