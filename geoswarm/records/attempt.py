"""One of several tries at an evaluation."""

from __future__ import annotations

from datetime import datetime

from geoswarm.records.record import record, told

__all__ = ["Attempt"]


@record
class Attempt:
    """One attempt at an evaluation."""

    number: int
    worker: str | None
    outcome: str = told("running, finished, the kind of failure, or why it does not count: late, overdue, stopped")
    counted: bool = told("it gave the evaluation's result")
    message: str | None
    log: str | None = told("end of what the forward model wrote")
    started_at: datetime | None
    finished_at: datetime | None
