"""Records of operations, for administrators, and of the caller."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime

__all__ = ["Operations", "Session"]


@dataclass(frozen=True, slots=True)
class Session:
    """Whose key a request brings, and what it may; ``expires_at`` only of a browser's session."""

    owner: str | None
    role: str
    key_needed: bool
    signed_in: bool
    expires_at: datetime | None


@dataclass(frozen=True, slots=True)
class Operations:
    """How the installation is doing, over all owners.

    Attributes
    ----------
    jobs, workers
        Number by state.
    waiting, running
        Evaluations of running jobs that wait for a worker, and that a worker has.
    oldest_wait
        Age of the oldest job that no worker has begun [s].
    outcomes
        Forward runs since the installation was made: finished, or the kind of failure.
    lost_evaluations
        Evaluations that were taken from a lost worker.
    event_streams
        Open event streams of the process that answered.
    """

    jobs: dict[str, int]
    waiting: int
    running: int
    oldest_wait: float
    workers: dict[str, int]
    outcomes: dict[str, int]
    lost_evaluations: int
    event_streams: int
