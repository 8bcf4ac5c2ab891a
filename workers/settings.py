"""Settings of the engine, from code or from the environment."""

from __future__ import annotations

import os
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator
from sqlalchemy.engine import URL, make_url
from sqlalchemy.exc import ArgumentError

from geoswarm.environment import listed, read_settings
from geoswarm.workers.errors import SettingsError

__all__ = ["Settings", "mask_url"]

VARIABLES = {
    "database_url": "GEOSWARM_DATABASE_URL",
    "broker_url": "GEOSWARM_BROKER_URL",
    "workers": "GEOSWARM_WORKERS",
    "passed_environment": "GEOSWARM_PASS_ENVIRONMENT",
    "evaluation_seconds": "GEOSWARM_EVALUATION_SECONDS",
    "evaluation_memory_mb": "GEOSWARM_EVALUATION_MEMORY_MB",
    "build_memory_mb": "GEOSWARM_BUILD_MEMORY_MB",
    "check_seconds": "GEOSWARM_CHECK_SECONDS",
    "disk_reserve_mb": "GEOSWARM_DISK_RESERVE_MB",
    "quota_jobs": "GEOSWARM_QUOTA_JOBS",
    "quota_evaluations": "GEOSWARM_QUOTA_EVALUATIONS",
    "quota_mb": "GEOSWARM_QUOTA_MB",
    "quota_total_mb": "GEOSWARM_QUOTA_TOTAL_MB",
    "attachment_mb": "GEOSWARM_ATTACHMENT_MB",
    "attachments_per_job": "GEOSWARM_ATTACHMENTS_PER_JOB",
    "attachments_per_job_mb": "GEOSWARM_ATTACHMENTS_PER_JOB_MB",
    "quota_attachments_mb": "GEOSWARM_QUOTA_ATTACHMENTS_MB",
    "quota_agents": "GEOSWARM_QUOTA_AGENTS",
    "quota_leases": "GEOSWARM_QUOTA_LEASES",
}
"""The variable of each setting that an operator chooses; the others are chosen in code."""

DRIVERS = {
    "sqlite": "sqlite",
    "postgresql": "postgresql+psycopg",
    "postgres": "postgresql+psycopg",
    "postgresql+psycopg": "postgresql+psycopg",
}
BROKER_SCHEMES = ("redis://", "rediss://", "redis+socket://", "unix://")


def mask_url(url: str) -> str:
    """Return a database or broker address fit for messages: without its password."""
    try:
        return make_url(url).render_as_string(hide_password=True)
    except ArgumentError:
        return "(address that cannot be parsed)"


def _limit(value: Any) -> Any:
    """A limit; "none" and 0 stand for no limit."""
    text = value.strip().lower() if isinstance(value, str) else value
    try:
        return None if text in ("none", "") or float(text) == 0.0 else value
    except (TypeError, ValueError):
        return value


class Settings(BaseModel):
    """How the engine works; everything but the two addresses has a sensible default.

    Parameters
    ----------
    database_url
        ``sqlite:///file.db`` or ``postgresql://user:password@host/database``.
    broker_url
        ``redis://host:6379/0``; None: the embedded engine runs the workers.
    workers
        Worker processes of the embedded engine.
    lease_seconds, heartbeat_seconds
        A worker that is silent for longer than its lease [s] is lost; it renews the lease every heartbeat [s].
    sweep_seconds
        Time between two sweeps [s].
    poll_seconds
        How long an embedded worker waits for the waker before it looks by itself [s].
    slice_seconds
        After this time [s] a worker lets other jobs in.
    chunk_seconds
        A worker hands in what it has at least this often [s], as long as single evaluations allow it.
    cheap_seconds, single_seconds
        Evaluations that typically take less than the first [s] go out in one chunk a worker, those that take longer
        than the second one by one, those between in chunks that get smaller.
    local_batch_seconds
        Generations that take less in total [s] are run several at a time inside one worker; 0 turns that off.
    watch_seconds
        How often a worker looks whether what it runs is still wanted [s].
    pause_seconds
        How long an evaluation may still take when its job is paused [s]; then it is killed, to be run again.
    overdue_seconds, overdue_factor
        An evaluation that runs longer than both this time [s] and this multiple of the typical time is also given to
        a worker that has nothing else to do.
    isolate
        Evaluate in a process of its own, which can be killed; False is for debugging: nothing is limited.
    passed_environment
        Names of environment variables that forward models get beside the usual ones (``PATH``, ``HOME``, ...), with
        ``*`` for any letters.
    evaluation_seconds, evaluation_memory_mb
        Limits [s], [MiB] that no problem may exceed; None (0 or "none" in the environment): what the problem says.
    build_memory_mb
        Memory [MiB] that building the forward model of another package may take.
    check_seconds
        Longest test run of a problem that is not a job yet [s].
    kinds
        Kinds of forward model that these workers run; empty: all.
    slots
        How many evaluations of a kind may run at once in these workers, as far as that is fewer than there are
        workers (licences).
    connect_seconds
        How long to wait for a database or broker that does not answer [s].
    disk_reserve_mb
        Free disk [MB] below which the service is not ready, takes no job and gives out no evaluation, while what is
        finished is still handed in; of an SQLite database.
    grace_seconds
        How long a stopping engine waits for an evaluation that is being calculated [s].
    quota_jobs, quota_evaluations
        Jobs that have not ended, and stored or planned evaluations, that one owner of API keys may have.
    quota_mb, quota_total_mb
        Stored or planned data [MB] of one owner of API keys, and size of the database with all that is planned [MB]
        above which owners of API keys submit nothing more.
    attachment_mb, attachments_per_job, attachments_per_job_mb
        Size of one file that is attached to a job [MB], number of files of a job (0: none), and their size [MB].
    quota_attachments_mb
        Size of all files attached to the jobs of one owner of API keys [MB].
    quota_agents, quota_leases
        Agents that are there at once with one API key, and leases that they hold.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", hide_input_in_errors=True)

    database_url: str = "sqlite:///geoswarm.db"
    broker_url: str | None = None
    workers: int = Field(default_factory=lambda: os.cpu_count() or 1, ge=0, le=1024)
    lease_seconds: float = Field(10.0, gt=0)
    heartbeat_seconds: float = Field(2.5, gt=0)
    sweep_seconds: float = Field(2.0, gt=0)
    poll_seconds: float = Field(0.5, gt=0)
    slice_seconds: float = Field(1.0, gt=0)
    chunk_seconds: float = Field(0.5, gt=0)
    cheap_seconds: float = Field(0.05, ge=0)
    single_seconds: float = Field(1.0, ge=0)
    local_batch_seconds: float = Field(0.02, ge=0)
    watch_seconds: float = Field(0.5, gt=0)
    pause_seconds: float = Field(1.0, ge=0)
    overdue_seconds: float = Field(30.0, gt=0)
    overdue_factor: float = Field(4.0, ge=1)
    isolate: bool = True
    passed_environment: Annotated[tuple[str, ...], BeforeValidator(listed)] = ()
    evaluation_seconds: Annotated[float | None, BeforeValidator(_limit)] = Field(3600.0, gt=0)
    evaluation_memory_mb: Annotated[float | None, BeforeValidator(_limit)] = Field(None, ge=16)
    build_memory_mb: float = Field(4096.0, ge=64)
    check_seconds: float = Field(60.0, gt=0)
    kinds: tuple[str, ...] = ()
    slots: dict[str, Annotated[int, Field(ge=1)]] = {}
    connect_seconds: float = Field(3.0, gt=0)
    disk_reserve_mb: float = Field(100.0, ge=0, allow_inf_nan=False)
    grace_seconds: float = Field(3.0, ge=0)
    quota_jobs: int = Field(100, ge=0)
    quota_evaluations: int = Field(10_000_000, ge=0)
    quota_mb: float = Field(20_000.0, ge=0, allow_inf_nan=False)
    quota_total_mb: float = Field(100_000.0, ge=0, allow_inf_nan=False)
    attachment_mb: float = Field(20.0, gt=0, allow_inf_nan=False)
    attachments_per_job: int = Field(20, ge=0)
    attachments_per_job_mb: float = Field(100.0, ge=0, allow_inf_nan=False)
    quota_attachments_mb: float = Field(2_000.0, ge=0, allow_inf_nan=False)
    quota_agents: int = Field(1000, ge=0)
    quota_leases: int = Field(4000, ge=0)

    @field_validator("database_url")
    @classmethod
    def _known_database(cls, value: str) -> str:
        try:
            url: URL = make_url(value)
        except ArgumentError:
            raise ValueError(
                "is not an address; accepted: sqlite:///file.db, postgresql://user:password@host/name"
            ) from None
        if url.drivername not in DRIVERS:
            raise ValueError(f"names the database {url.drivername!r}; accepted: sqlite, postgresql")
        if url.drivername == "sqlite" and url.database in (None, "", ":memory:"):
            raise ValueError("must name a file (sqlite:///geoswarm.db): worker processes share the database")
        return url.set(drivername=DRIVERS[url.drivername]).render_as_string(hide_password=False)

    @field_validator("broker_url")
    @classmethod
    def _known_broker(cls, value: str | None) -> str | None:
        if value is not None and not value.startswith(BROKER_SCHEMES):
            raise ValueError(f"must be a Redis address; accepted: {', '.join(BROKER_SCHEMES)}")
        return value

    @model_validator(mode="after")
    def _heartbeat_keeps_lease(self) -> Settings:
        if self.heartbeat_seconds * 2 > self.lease_seconds:
            raise ValueError(
                f"heartbeat_seconds {self.heartbeat_seconds} must be at most half of lease_seconds {self.lease_seconds}"
            )
        return self

    @classmethod
    def from_environment(cls, **overrides: Any) -> Settings:
        """Read the variables of :data:`VARIABLES`; overrides that are not None win.

        Raises
        ------
        SettingsError
            Names the setting, its value unless it is secret, and what would be accepted.
        """
        return read_settings(cls, VARIABLES, overrides, SettingsError)
