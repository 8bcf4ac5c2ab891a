"""Who runs forward calculations."""

from __future__ import annotations

from datetime import datetime

from geoswarm.records.record import record, told

__all__ = ["Worker"]


@record
class Worker:
    """A process that runs forward calculations."""

    id: str
    host: str
    pid: int
    engine: str
    state: str
    job: str | None = told("what it works on; null: on nothing, or on a job of somebody else")
    generation: int | None
    evaluations: int | None = told("number of evaluations that it has claimed")
    busy_since: datetime | None
    started_at: datetime
    seen_at: datetime
