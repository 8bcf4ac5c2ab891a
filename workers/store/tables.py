"""Tables of the store.

Times are seconds since 1970 (UTC) in double precision, always from the database's clock. Arrays are bytes (see
:mod:`geoswarm.workers.store.codec`), documents are JSON text without NaN or infinity, so that every float comes back
exactly.
"""

from __future__ import annotations

from sqlalchemy import (
    BigInteger,
    Column,
    Double,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
    text,
)

from geoswarm.records.states import SERVED_STATES

__all__ = [
    "agent_leases",
    "agents",
    "api_keys",
    "attachment_pieces",
    "attachments",
    "attempts",
    "builds",
    "counters",
    "deliveries",
    "evaluations",
    "events",
    "generations",
    "hooks",
    "jobs",
    "metadata",
    "sessions",
    "turns",
    "workers",
]

metadata = MetaData(
    naming_convention={
        "ix": "ix_%(table_name)s_%(column_0_N_name)s",
        "uq": "uq_%(table_name)s_%(column_0_N_name)s",
        "fk": "fk_%(table_name)s_%(column_0_N_name)s_%(referred_table_name)s",
        "pk": "pk_%(table_name)s",
    }
)

Serial = BigInteger().with_variant(Integer(), "sqlite")
"""SQLite numbers rows by itself only in a column of type INTEGER."""

OPEN = f"state IN ({', '.join(map(repr, SERVED_STATES))})"
"""Jobs that wait for workers."""


def _job(*, key: bool) -> Column[str]:
    return Column("job_id", String(32), ForeignKey("jobs.id", ondelete="CASCADE"), primary_key=key, nullable=False)


jobs = Table(
    "jobs",
    metadata,
    Column("id", String(32), primary_key=True),
    Column("name", Text, nullable=False),
    Column("state", String(16), nullable=False),
    Column("forward_model", Text, nullable=False),
    Column("method", Text, nullable=False),
    # what was asked
    Column("problem", Text, nullable=False),
    Column("seed", BigInteger, nullable=False),
    Column("free_parameters", Text, nullable=False),
    Column("grids", Text, nullable=False),  # {series: x of the responses}
    Column("max_evaluations", BigInteger),
    Column("idempotency_key", Text, unique=True),
    Column("body_hash", String(64), nullable=False),
    # where the search is: written only with this row locked
    Column("generation", Integer, nullable=False),  # the one under evaluation, -1 before the start
    Column("progress", Text),
    Column("dispatched_at", Double),  # of this generation
    Column("generations", Integer, nullable=False),
    Column("evaluations", BigInteger, nullable=False),
    Column("failed_evaluations", BigInteger, nullable=False),
    Column("failures", Text, nullable=False),
    Column("objective", Double),
    Column("parameters", Text),
    Column("best_generation", Integer),
    Column("best_particle", Integer),
    Column("stop_reasons", Text, nullable=False),
    Column("error", Text),
    Column("search_evaluations", BigInteger),  # and at most how many follow; null: the search goes on, or none do
    Column("answer_evaluations", BigInteger),
    Column("at_bounds", Text),  # those of the parameters that lie at a bound, with it; null: not recorded
    Column("conclusion", Text),  # intervals, verdicts, fit, best of the search; null: none followed it
    # times; run_seconds is complete up to clock_at
    Column("created_at", Double, nullable=False),
    Column("started_at", Double),
    Column("finished_at", Double),
    Column("run_seconds", Double, nullable=False),
    Column("clock_at", Double),
    # for dispatch
    Column("typical_seconds", Double),  # median forward calculation of the last finished generation
    Column("served_at", Double),  # a worker last took it up
    Column("rung_at", Double),  # a sweep last woke workers for it
    Column("priority", Integer, nullable=False, server_default="0"),  # among the jobs of one owner
    Column("shared_priority", Integer, nullable=False, server_default="0"),  # among owners: an administrator's
    Column("line", String(80), nullable=False, server_default=""),  # the one of its owner, empty: no owner
    Column("place", Double, nullable=False, server_default="0"),  # in this line, the lowest first
    Column(
        "retry_to", String(16)
    ),  # its failures are run again; what it is then: see geoswarm.workers.coordinator.retry
    Column("stopping", Text),  # the stop criteria, where they were changed; null: those of the problem
    Column("versions", Text),  # what it was calculated under: see geoswarm.workers.queries.versions
    Column("forward_hash", String(64)),  # of the forward model's section; null: not looked at since the last upgrade
    Column(
        "needs", Text
    ),  # what runs it: see geoswarm.workers.agents.prepared; null: not looked at since the last upgrade
    Column("tags", Text, nullable=False, server_default=""),  # each between line ends, so that one is found whole
    Column("note", Text, nullable=False, server_default=""),  # Markdown
    Column("owner", String(80)),  # null: submitted without an API key, or with the one of the environment
    Column("parent", String(32)),  # the job whose follow-up it is; null: of none, or of a deleted one
    # what it takes of the disk: the job itself, and each evaluation, about [bytes]
    Column("document_bytes", BigInteger, nullable=False, server_default="0"),
    Column("evaluation_bytes", BigInteger, nullable=False, server_default="0"),
    Index("ix_jobs_created_at_id", "created_at", "id"),
    Index("ix_jobs_state_served_at", "state", "served_at"),
    Index("ix_jobs_owner_created_at_id", "owner", "created_at", "id"),
    Index("ix_jobs_parent", "parent"),
    Index("ix_jobs_line_place", "line", "place", postgresql_where=text(OPEN), sqlite_where=text(OPEN)),
    Index("ix_jobs_place", "place", postgresql_where=text(OPEN), sqlite_where=text(OPEN)),
)

turns = Table(
    "turns",
    metadata,
    Column("line", String(80), primary_key=True),
    Column("served_at", Double),  # a worker last took up one of its jobs
)
"""The lines in which jobs wait, one for each owner; they are served in turn."""

generations = Table(
    "generations",
    metadata,
    _job(key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("evaluations", BigInteger, nullable=False),
    Column("failed", BigInteger, nullable=False),
    Column("best_objective", Double),
    Column("objective", Double),
    Column("parameters", Text),
    Column("created_at", Double, nullable=False),
    Column("finished_at", Double, nullable=False),
    Index("ix_generations_best", "job_id", "number", "best_objective"),  # finds good evaluations
)

evaluations = Table(
    "evaluations",
    metadata,
    _job(key=True),
    Column("generation", Integer, primary_key=True, autoincrement=False),
    Column("particle", Integer, primary_key=True, autoincrement=False),
    Column("state", String(16), nullable=False),
    Column("parameters", LargeBinary, nullable=False),
    Column("objective", Double),
    Column("misfits", Text),
    Column("responses", LargeBinary),
    Column("reason", String(32)),
    Column("message", Text),
    Column("log", Text),  # end of what a failed forward model wrote
    Column("attempts", Integer, nullable=False),
    Column("duplicates", Integer),  # how often it was given to another worker because it was overdue
    Column("worker", String(80)),
    Column("lease_expires_at", Double),
    Column("started_at", Double),
    Column("finished_at", Double),
    Column("seconds", Double),
    # small whatever the history: only what runs now
    Index(
        "ix_evaluations_running",
        "lease_expires_at",
        postgresql_where=text("state = 'running'"),
        sqlite_where=text("state = 'running'"),
    ),
    Index(
        "ix_evaluations_failed",
        "job_id",
        "generation",
        "particle",
        postgresql_where=text("state = 'failed'"),
        sqlite_where=text("state = 'failed'"),
    ),
    Index(
        "ix_evaluations_reopened",
        "job_id",
        "generation",
        postgresql_where=text("state = 'pending' AND reason IS NOT NULL"),
        sqlite_where=text("state = 'pending' AND reason IS NOT NULL"),
    ),
)

offers = Table(
    "offers",
    metadata,
    _job(key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("parameters", LargeBinary, nullable=False),
    Column("responses", LargeBinary, nullable=False),
)
"""Runs of earlier jobs that a job learns from, as they were when it was submitted: its history depends on them."""

attempts = Table(
    "attempts",
    metadata,
    Column("id", Serial, primary_key=True, autoincrement=True),
    _job(key=False),
    Column("generation", Integer, nullable=False),
    Column("particle", Integer, nullable=False),
    Column("number", Integer, nullable=False),
    Column("worker", String(80)),
    Column("started_at", Double),
    Column("finished_at", Double, nullable=False),
    Column("outcome", String(32), nullable=False),
    Column("message", Text),
    Column("log", Text),
    Index("ix_attempts_evaluation", "job_id", "generation", "particle"),
    sqlite_autoincrement=True,
)
"""Tries that did not count: failed but tried again, too late, stopped. The counted one is the evaluation's own row."""

events = Table(
    "events",
    metadata,
    Column("id", Serial, primary_key=True, autoincrement=True),
    _job(key=False),
    Column("kind", String(32), nullable=False),
    Column("data", Text, nullable=False),
    Column("created_at", Double, nullable=False),
    Index("ix_events_job_id_id", "job_id", "id"),
    sqlite_autoincrement=True,
)

workers = Table(
    "workers",
    metadata,
    Column("id", String(80), primary_key=True),
    Column("host", Text, nullable=False),
    Column("pid", Integer, nullable=False),
    Column("machine", Text, nullable=False),  # where this pid means something: boot and pid namespace
    Column("engine", String(16), nullable=False),
    Column("started_at", Double, nullable=False),
    Column("seen_at", Double, nullable=False),
    Column("lost_at", Double),
    Column("agent", String(60)),  # whose slot it is; null: a process of this installation
    Index("ix_workers_agent", "agent"),
)

agents = Table(
    "agents",
    metadata,
    Column("id", String(60), primary_key=True),
    Column("key_id", String(16), nullable=False),
    Column("host", Text, nullable=False),
    Column("system", Text, nullable=False),
    Column("pid", Integer, nullable=False),
    Column("slots", Integer, nullable=False),
    Column("versions", Text, nullable=False),  # of what calculates there
    Column("offers", Text, nullable=False),  # what it runs, one a list item
    Column("models", Text, nullable=False),  # {name: hash} of the registered ones, for people
    Column("started_at", Double, nullable=False),
    Column("seen_at", Double, nullable=False),
    Index("ix_agents_key_id", "key_id"),
)
"""Workers without the database, as they have announced themselves."""

agent_leases = Table(
    "agent_leases",
    metadata,
    Column("id", String(32), primary_key=True),
    _job(key=False),
    Column("key_id", String(16), nullable=False),
    Column("agent", String(60), nullable=False),
    Column("worker", String(80), nullable=False),
    Column("generation", Integer, nullable=False),
    Column("particles", Text, nullable=False),
    Column("attempts", Text, nullable=False),
    Column("refused", Text, nullable=False),  # particles that a follow-up must not ask for
    Column("created_at", Double, nullable=False),
    Column("taken_up_at", Double, nullable=False),  # when this slot turned to the job
    Column("expires_at", Double, nullable=False),
    Column("ended_at", Double),  # its results were taken in, or it was taken back
    Index("ix_agent_leases_key_id", "key_id"),
    Index("ix_agent_leases_ended_at", "ended_at"),
    Index("ix_agent_leases_job_id", "job_id"),
)
"""What agents hold. A result counts only for a lease that was given to the key that brings it."""

api_keys = Table(
    "api_keys",
    metadata,
    Column("id", String(16), primary_key=True),  # part of the key itself, so that it is found without its secret
    Column("hash", String(64), nullable=False),  # SHA-256 of the whole key, which has 256 random bits
    Column("owner", String(80), nullable=False),
    Column("job_id", String(32)),  # the only job that it shows, as a read-only link; null: all of its owner
    Column("role", String(16), nullable=False),
    Column("label", Text, nullable=False),
    Column("created_at", Double, nullable=False),
    Column("expires_at", Double),
    Column("revoked_at", Double),
    Column("used_at", Double),
)

sessions = Table(
    "sessions",
    metadata,
    Column("hash", String(64), primary_key=True),  # SHA-256 of the token, which has 256 random bits
    Column("key_id", String(16), nullable=False),  # "environment" for the key that is not in the database
    Column("key_hash", String(64), nullable=False),  # of the key at sign-in: another key ends the session
    Column("created_at", Double, nullable=False),
    Column("expires_at", Double, nullable=False),
    Index("ix_sessions_expires_at", "expires_at"),
)
"""Browsers that are signed in."""

hooks = Table(
    "hooks",
    metadata,
    Column("id", String(16), primary_key=True),
    Column("owner", String(80)),  # whose jobs it announces; null: those without an owner
    Column("job_id", String(32), ForeignKey("jobs.id", ondelete="CASCADE")),  # null: all jobs of the owner
    Column("kind", String(8), nullable=False),  # web, mail
    Column("target", Text, nullable=False),  # address
    Column("secret", Text),  # what requests are signed with; it must be known to sign
    Column("states", Text, nullable=False),  # in which of these a job has ended, JSON list
    Column("created_at", Double, nullable=False),
    Index("ix_hooks_owner", "owner"),
    Index("ix_hooks_job_id", "job_id"),
)
"""Whom to tell when a job has ended."""

deliveries = Table(
    "deliveries",
    metadata,
    Column("id", Serial, primary_key=True, autoincrement=True),
    Column("hook_id", String(16), ForeignKey("hooks.id", ondelete="CASCADE"), nullable=False),
    Column("job_id", String(32), ForeignKey("jobs.id", ondelete="CASCADE")),  # null: only a test of the hook
    Column("job_state", String(16), nullable=False),  # in which it ended, or "test"
    Column("state", String(16), nullable=False),  # waiting, delivered, given_up
    Column("tries", Integer, nullable=False),
    Column("due_at", Double, nullable=False),  # the next try
    Column("held_until", Double),  # a process is trying, or was lost in mid-try
    Column("body", Text),  # made at the first try, so that every try sends the same
    Column("error", Text),
    Column("created_at", Double, nullable=False),
    Column("ended_at", Double),
    Index(
        "ix_deliveries_waiting",
        "due_at",
        postgresql_where=text("state = 'waiting'"),
        sqlite_where=text("state = 'waiting'"),
    ),
    Index("ix_deliveries_hook_id_id", "hook_id", "id"),
    Index("ix_deliveries_job_id", "job_id"),
    sqlite_autoincrement=True,
)
"""What hooks are still to be told, and were; entered in the transaction that ends a job."""

builds = Table(
    "builds",
    metadata,
    _job(key=True),
    Column("worker", String(80), primary_key=True),
)
"""Workers that are building the problem of a job, or in which its method of another package acts.

One that has ended meanwhile may have ended by that.
"""

attachments = Table(
    "attachments",
    metadata,
    _job(key=True),
    Column("sha256", String(64), primary_key=True),  # of the content
    Column("name", Text, nullable=False),
    Column("media_type", Text, nullable=False),
    Column("size", BigInteger, nullable=False),
    Column("created_at", Double, nullable=False),
)
"""Files that people attach to a job."""

attachment_pieces = Table(
    "attachment_pieces",
    metadata,
    Column("job_id", String(32), primary_key=True),
    Column("sha256", String(64), primary_key=True),
    Column("number", Integer, primary_key=True, autoincrement=False),
    Column("content", LargeBinary, nullable=False),
    ForeignKeyConstraint(["job_id", "sha256"], ["attachments.job_id", "attachments.sha256"], ondelete="CASCADE"),
)

counters = Table(
    "counters",
    metadata,
    Column("name", String(40), primary_key=True),
    Column("label", String(40), primary_key=True),
    Column("value", Double, nullable=False),
)
"""What all processes of an installation have counted since it was made, for the metrics."""
