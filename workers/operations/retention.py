"""Deletes jobs so that they are gone: overwritten in the file, out of the journal, their space given back.

What backups, replicas and snapshots of the disk hold is beyond this program (docs/operations.md).
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Collection
from dataclasses import dataclass

from sqlalchemy import Connection

from geoswarm.records.states import ENDED_STATES
from geoswarm.workers.errors import InvalidTransitionError, JobNotFoundError, StoreUnavailableError
from geoswarm.workers.operations.sweep import empty_journal, note_deletion, with_signals
from geoswarm.workers.queries import jobs
from geoswarm.workers.queries.attachments import delete_attachment
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["Pruned", "delete_job", "empty_journal_now", "overwrite_deleted", "prune", "run_prune"]

log = logging.getLogger(__name__)

ROWS_A_TRANSACTION = 5000
AGAIN_SECONDS = 300.0  # after a round in which the database did not answer


@dataclass(frozen=True, slots=True)
class Pruned:
    """A job that was, or would be, deleted."""

    id: str
    name: str
    state: str
    evaluations: int


def delete_job(store: Store, job_id: str) -> None:
    """Remove a job that has ended, with all that belongs to it.

    Other work goes on meanwhile: no transaction holds the database for long. Killed in between, the job is still
    there without its last evaluations, and can be deleted again.

    Raises
    ------
    JobNotFoundError
    InvalidTransitionError
        When it has not ended.
    StoreUnavailableError
    """
    while store.write(lambda connection: _delete_some(connection, job_id)):
        pass
    empty_journal_now(store)


def prune(
    store: Store,
    older_than: float,
    states: Collection[str] = ENDED_STATES,
    *,
    dry_run: bool = False,
    on_deleted: Callable[[Pruned], None] | None = None,
) -> list[Pruned]:
    """Delete all jobs that ended longer than ``older_than`` [s] ago, and give the space back.

    Raises
    ------
    StoreUnavailableError
    """
    rows = store.read(lambda connection: jobs.ended_before(connection, older_than, states))
    pruned = []
    for row in rows:
        job = Pruned(row.id, row.name, row.state, row.evaluations)
        if not dry_run:
            try:
                delete_job(store, job.id)
            except (JobNotFoundError, InvalidTransitionError):  # somebody was faster, or revived it
                continue
        pruned.append(job)
        if on_deleted is not None:
            on_deleted(job)
    if pruned and not dry_run:
        _vacuum(store)
    return pruned


def run_prune(settings: Settings, older_than: float, states: Collection[str], every: float) -> None:
    """Delete old jobs now and then every ``every`` [s] until SIGINT or SIGTERM: ``geoswarm prune --every``.

    Between two rounds no connection to the database is kept. When it does not answer, the next try comes earlier.

    Raises
    ------
    StoreUnavailableError
        When the database cannot be reached at the start.
    """
    stop = threading.Event()
    with_signals(stop.set)
    _round(settings, older_than, states)
    wait = every
    while not stop.wait(wait):
        try:
            _round(settings, older_than, states)
            wait = every
        except StoreUnavailableError as error:
            log.warning("prune: %s", error)
            wait = min(every, AGAIN_SECONDS)


def _round(settings: Settings, older_than: float, states: Collection[str]) -> None:
    store = Store(settings)
    try:
        pruned = prune(store, older_than, states)
    finally:
        store.close()
    log.info("prune: %d jobs deleted", len(pruned))


def _delete_some(connection: Connection, job_id: str) -> bool:
    """Delete a part; whether something is left."""
    overwrite_deleted(connection)
    locked = jobs.lock_job(connection, job_id)
    if locked is None:
        raise JobNotFoundError(job_id)
    if locked.row.state not in ENDED_STATES:
        raise InvalidTransitionError("delete", locked.row.state, ENDED_STATES)
    if jobs.delete_evaluations(connection, job_id, ROWS_A_TRANSACTION) == ROWS_A_TRANSACTION:
        return True
    if delete_attachment(connection, job_id):
        return True
    jobs.delete_job(connection, job_id)
    return False


def overwrite_deleted(connection: Connection) -> None:
    """Let SQLite overwrite with zeros what this transaction deletes, and note that its journal is to be emptied."""
    if connection.dialect.name == "sqlite":
        connection.exec_driver_sql("PRAGMA secure_delete = ON")
    note_deletion(connection)


def empty_journal_now(store: Store) -> None:
    """Empty the journal after a deletion, or leave that to the next sweep."""
    if not empty_journal(store):
        log.info("the journal of the database cannot be emptied while it is read; the next sweep tries again")


def _vacuum(store: Store) -> None:
    if store.engine.dialect.name == "sqlite":
        _alone(store, "VACUUM")
        store.truncate_journal()
        return
    for table in ("evaluations", "generations", "events", "attempts", "attachment_pieces", "jobs"):
        _alone(store, f"VACUUM (ANALYZE) {table}")


def _alone(store: Store, statement: str) -> None:
    """Run a statement that no transaction may hold; that it is not possible now does no harm."""
    connection = store.engine.raw_connection()
    try:
        driver = connection.driver_connection
        if store.engine.dialect.name == "postgresql" and driver is not None:
            driver.autocommit = True
        cursor = connection.cursor()
        try:
            cursor.execute(statement)
        finally:
            cursor.close()
    except store.engine.dialect.loaded_dbapi.Error as error:
        log.warning("%s is not possible now: %s", statement, error)
    finally:
        connection.invalidate()  # its settings were changed
        connection.close()
