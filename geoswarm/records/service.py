"""The service itself: its health and workers, what it has to do, and who asks."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from geoswarm.records.account import Role
from geoswarm.records.record import described, record

__all__ = ["AgentSlot", "Health", "Operations", "Session", "Worker"]


@record
class Health:
    """Whether all that the service needs can be reached."""

    status: Literal["ok", "unavailable"]
    dependencies: dict[str, str] = described("ok, embedded, or why it cannot be used")

    @property
    def ok(self) -> bool:
        """Whether all that the service needs can be reached."""
        return self.status == "ok"


@record
class Session:
    """Owner and role of the requester."""

    owner: str | None = described("whose jobs are shown; null: those submitted without a key")
    role: Role
    key_needed: bool = described("whether this service asks for API keys")
    signed_in: bool = described("whether a session's cookie was used")
    expires_at: datetime | None = described("end of the session")


@record
class Operations:
    """State of the installation, over all owners and processes."""

    jobs: dict[str, int] = described("number by state")
    waiting: int = described("evaluations of running jobs that wait for a worker")
    running: int = described("evaluations that a worker has")
    oldest_wait: float = described("age of the oldest job that no worker has started, seconds")
    workers: dict[str, int] = described("number by state")
    outcomes: dict[str, int] = described(
        "forward runs since the installation was made: finished, or the kind of failure"
    )
    lost_evaluations: int = described("evaluations that were taken from a lost worker")
    event_streams: int = described("open event streams of this process")


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
