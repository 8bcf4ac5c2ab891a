"""Processes that run forward calculations."""

from __future__ import annotations

from datetime import datetime

from geoswarm.records.record import described, record

__all__ = ["AgentSlot", "Worker"]


@record
class AgentSlot:
    """An agent: a worker without the database. Each of its slots is a worker."""

    id: str
    slots: int = described("number of runs that it makes at once")
    system: str = described("its operating system and processor")
    version: str = described("version of geoswarm there")
    models: dict[str, str] = described("registered models that it has: SHA-256 of the files of each")


@record
class Worker:
    """A process that runs forward calculations."""

    id: str
    host: str
    pid: int
    engine: str
    state: str
    job: str | None = described("its job; null: none, or a job of another owner")
    generation: int | None
    evaluations: int | None = described("number of evaluations that it has claimed")
    busy_since: datetime | None
    started_at: datetime
    seen_at: datetime
    agent: AgentSlot | None = described("the agent whose slot it is; null: a process of the installation", default=None)
