"""The life of one evaluation as a pure state machine: what a claim, a result or a lost lease does to it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, assert_never

__all__ = [
    "Claimed",
    "EvaluationEvent",
    "EvaluationStatus",
    "LeaseExpired",
    "LeaseReleased",
    "ResultArrived",
    "Verdict",
    "settle",
]

Verdict: TypeAlias = Literal["claimed", "counted", "late", "redispatched", "given_up", "released", "ignored"]


@dataclass(frozen=True, slots=True)
class EvaluationStatus:
    """State (pending, running, finished or failed), tries so far, and who holds or held it."""

    state: Literal["pending", "running", "finished", "failed"] = "pending"
    attempts: int = 0
    worker: str | None = None

    @property
    def done(self) -> bool:
        """Whether a result has been counted."""
        return self.state in ("finished", "failed")


@dataclass(frozen=True, slots=True)
class Claimed:
    """A worker takes it up."""

    worker: str


@dataclass(frozen=True, slots=True)
class ResultArrived:
    """A worker hands in the outcome of its attempt."""

    worker: str
    attempt: int
    failed: bool


@dataclass(frozen=True, slots=True)
class LeaseExpired:
    """Nothing was heard of the worker for longer than its lease, or it is known to be dead."""

    max_attempts: int


@dataclass(frozen=True, slots=True)
class LeaseReleased:
    """The worker gives it back untouched."""

    worker: str
    attempt: int


EvaluationEvent: TypeAlias = Claimed | ResultArrived | LeaseExpired | LeaseReleased


def settle(status: EvaluationStatus, event: EvaluationEvent) -> tuple[EvaluationStatus, Verdict]:
    """Apply one event; pure. An event that comes twice, or too late, is ignored or recorded as late."""
    match event:
        case Claimed(worker):
            if status.state == "running" and status.worker == worker:
                return status, "claimed"  # the answer to the first claim was lost
            if status.state != "pending":
                return status, "ignored"
            return EvaluationStatus("running", status.attempts + 1, worker), "claimed"
        case ResultArrived(worker, attempt, failed):
            if not status.done:
                # The first result counts, whoever holds the lease now.
                return EvaluationStatus("failed" if failed else "finished", status.attempts, worker), "counted"
            same = status.worker == worker and status.attempts == attempt
            return status, "ignored" if same else "late"
        case LeaseExpired(max_attempts):
            if status.state != "running":
                return status, "ignored"
            if status.attempts >= max_attempts:
                return replace(status, state="failed"), "given_up"
            return replace(status, state="pending", worker=None), "redispatched"
        case LeaseReleased(worker, attempt):
            if status.state != "running" or (status.worker, status.attempts) != (worker, attempt):
                return status, "ignored"
            return EvaluationStatus("pending", status.attempts - 1, None), "released"
        case _:
            assert_never(event)
