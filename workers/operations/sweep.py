"""The sweep: finds what was lost and wakes for it. Every API and worker process can; one begins each interval."""

from __future__ import annotations

import logging
import signal
import threading
from collections.abc import Callable, Collection, Sequence
from functools import partial
from types import FrameType

from sqlalchemy import ColumnElement, Connection, and_, delete, exists, insert, not_, or_, select
from sqlalchemy.dialects import postgresql

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.identity import is_dead, this_machine
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.queries.agents import (
    any_old_leases,
    end_lease,
    forget_agent,
    forget_old_leases,
    leases_of_dead_keys,
)
from geoswarm.workers.queries.evaluations import overdue
from geoswarm.workers.queries.jobs import account_running_time, clocks_overdue, get_job
from geoswarm.workers.queries.queue import claimable_jobs, mark_rung
from geoswarm.workers.queries.workers import (
    any_lost_before,
    busy_workers,
    count_live,
    forget_workers_lost_before,
    mark_lost,
    overdue_workers,
)
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import unpack_json
from geoswarm.workers.store.database import Record, Store
from geoswarm.workers.store.tables import counters
from geoswarm.workers.waker import Waker

__all__ = ["Sweeper", "begin_sweep", "due_sweeps", "empty_journal", "forget_marks", "note_deletion", "with_signals"]

log = logging.getLogger(__name__)

REMEMBER_LOST_SECONDS = 3600.0
LONGEST_WAIT_SECONDS = 30.0
EVERYWHERE = "everywhere"


SWEEP = "sweep"
FORGET_SECONDS = 3600.0  # machines that have gone
JOURNAL = "journal"
NOTE = and_(counters.c.name == JOURNAL, counters.c.label == "")


class Sweeper:
    """Looks after one store, by :meth:`sweep` once or by a thread of its own."""

    def __init__(self, runtime: Runtime, waker: Waker) -> None:
        self.runtime = runtime
        self.waker = waker
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def look(self) -> None:
        """Sweep, if no other process has in this interval; one process of each machine sees which others are dead.

        An SQLite file has few processes, and no marks: to write them would not leave it in peace.

        Raises
        ------
        StoreUnavailableError
        """
        if self.runtime.store.engine.dialect.name == "sqlite":
            self.sweep()
        else:
            self._sweep_in_turn()
        process_counters.flush(self.runtime.store)

    def _sweep_in_turn(self) -> None:
        settings, store = self.runtime.settings, self.runtime.store
        since = 0.9 * settings.sweep_seconds
        labels = EVERYWHERE, this_machine()
        due = store.read(lambda c: due_sweeps(c, labels, since))
        mine = [label for label in due if store.write(partial(begin_sweep, label=label, seconds=since))]
        if EVERYWHERE in mine:
            store.write(lambda c: forget_marks(c, labels))
            self.sweep()
        elif mine:
            self._free_lost(this_machine())

    def sweep(self) -> None:
        """Give up silent workers, free their evaluations, keep the clocks of jobs, notify workers of unknown work.

        And empty the journal of an SQLite file when readers kept that from happening after a deletion.

        Raises
        ------
        StoreUnavailableError
        """
        settings, store = self.runtime.settings, self.runtime.store
        gap = settings.lease_seconds
        self._free_lost()
        # A write transaction only when there is something to write: an idle service leaves its database in peace.
        if store.read(lambda c: clocks_overdue(c, gap / 4)):
            store.write(lambda c: account_running_time(c, gap / 4, gap))
        if store.read(lambda c: any_lost_before(c, REMEMBER_LOST_SECONDS)):
            store.write(lambda c: forget_workers_lost_before(c, REMEMBER_LOST_SECONDS))
        self._end_leases_of_dead_keys()
        self._wake()
        empty_journal(store)

    def release(self, job_id: str, generation: int, lost_workers: list[str]) -> None:
        """Free the overdue evaluations of one generation, and those of lost workers, and wake workers for the job."""
        expired = self.runtime.expire(job_id, generation, lost_workers)
        if expired:
            log.warning(
                "%d evaluations of job %s, generation %d, go to other workers: their lease expired",
                expired,
                job_id,
                generation,
                extra={"job": job_id, "generation": generation},
            )
            process_counters.add("lease_expirations", "", expired)
            row = self.runtime.store.read(lambda c: get_job(c, job_id))
            if row is not None:
                self.waker.wake(job_id, expired, kind=row.forward_model)

    def start(self) -> None:
        """Look every ``sweep_seconds`` in a thread."""
        self._thread = threading.Thread(target=self.run, name="geoswarm-sweep", daemon=True)
        self._thread.start()

    def run(self) -> None:
        """Look until :meth:`stop`; while the database does not answer, ever more rarely."""
        wait = self.runtime.settings.sweep_seconds
        while not self._stop.wait(wait):
            try:
                self.look()
            except StoreUnavailableError as error:
                wait = min(2 * wait, LONGEST_WAIT_SECONDS)
                log.warning("sweep: %s", error)
            else:
                wait = self.runtime.settings.sweep_seconds

    def end(self) -> None:
        """Let :meth:`run` end soon."""
        self._stop.set()

    def stop(self) -> None:
        """End the thread."""
        self.end()
        if self._thread is not None:
            self._thread.join()
            self._thread = None

    def _free_lost(self, machine: str | None = None) -> None:
        """Free what lost workers held; with a machine, only what its dead workers held."""
        lost = self._give_up_workers(machine)
        if lost or machine is None:
            for row in self.runtime.store.read(lambda c: overdue(c, lost)):
                self.release(row.job_id, row.generation, lost)

    def _give_up_workers(self, machine: str | None) -> list[str]:
        store, lease = self.runtime.store, self.runtime.settings.lease_seconds
        known = store.read(lambda c: overdue_workers(c, lease, machine))
        lost = [row.id for row in known if row.overdue or is_dead(row.pid, row.machine)]
        if lost:
            log.warning("workers lost: %s", ", ".join(lost))
            store.write(lambda c: mark_lost(c, lost))
            process_counters.add("sweep_actions", "worker_given_up", len(lost))
        return lost

    def _end_leases_of_dead_keys(self) -> None:
        """Take back what agents hold whose key was revoked or has expired, and forget what is long over."""
        store = self.runtime.store
        for lease in store.read(leases_of_dead_keys):
            held = list(zip(unpack_json(lease.particles), unpack_json(lease.attempts), strict=True))
            self.runtime.take_back(lease.job_id, lease.generation, held, lease.worker)
            store.write(partial(end_lease, lease_id=lease.id))
            store.write(partial(forget_agent, agent_id=lease.agent))
            log.warning("agent %s lost a lease: its key is no longer valid", lease.agent)
            row = store.read(partial(get_job, job_id=lease.job_id))
            if row is not None:
                self.waker.wake(lease.job_id, len(held), kind=row.forward_model)
        if store.read(any_old_leases):
            store.write(forget_old_leases)

    def _wake(self) -> None:
        store, settings = self.runtime.store, self.runtime.settings

        def forgotten(connection: Connection) -> Sequence[Record]:
            idle = count_live(connection, settings.lease_seconds) - len(busy_workers(connection))
            # Without an idle worker a wake-up would only wait in the queue; a later sweep wakes idle workers.
            late = (settings.overdue_seconds, settings.overdue_factor)
            since = 0.9 * settings.sweep_seconds
            return claimable_jobs(connection, idle, overdue=late, not_woken_for=since) if idle > 0 else []

        rows = store.read(forgotten)
        if rows:
            store.write(lambda c: mark_rung(c, [row.id for row in rows]))
            for row in rows:
                self.waker.wake(row.id, kind=row.forward_model)


def with_signals(stop: Callable[[], None]) -> None:
    """Let SIGINT and SIGTERM call ``stop``."""

    def handle(_number: int, _frame: FrameType | None) -> None:
        stop()

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handle)


def due_sweeps(connection: Connection, labels: Collection[str], seconds: float) -> list[str]:
    """Return those of the labels whose sweep has not begun in these seconds."""
    marks = counters.c.name == SWEEP, counters.c.label.in_(labels), not_(_old(seconds))
    fresh = set(connection.scalars(select(counters.c.label).where(*marks)))
    return [label for label in labels if label not in fresh]


def begin_sweep(connection: Connection, label: str, seconds: float) -> bool:
    """Note that this process sweeps now; False if another one has begun in these seconds."""
    statement = postgresql.insert(counters).values(name=SWEEP, label=label, value=database_now())
    statement = statement.on_conflict_do_update(
        index_elements=[counters.c.name, counters.c.label], set_={"value": database_now()}, where=_old(seconds)
    )
    return connection.scalar(statement.returning(counters.c.label)) is not None


def forget_marks(connection: Connection, kept: Collection[str]) -> None:
    """Delete the marks of machines that have gone."""
    gone = counters.c.name == SWEEP, counters.c.label.not_in(kept), _old(FORGET_SECONDS)
    connection.execute(delete(counters).where(*gone))


def _old(seconds: float) -> ColumnElement[bool]:
    """Whether a mark is older than this, or of a clock that was set back since."""
    now = database_now()
    return or_(counters.c.value < now - seconds, counters.c.value > now + seconds)


def note_deletion(connection: Connection) -> None:
    """Note that the journal is to be emptied; inside the transaction that deletes."""
    if connection.dialect.name == "sqlite" and not _noted(connection):
        connection.execute(insert(counters).values(name=JOURNAL, label="", value=1.0))


def empty_journal(store: Store) -> bool:
    """Empty the journal if noted; False if it is not possible now.

    Raises
    ------
    StoreUnavailableError
    """
    if store.file is None or not store.read(_noted):
        return True
    if not store.truncate_journal():
        return False
    store.write(lambda connection: connection.execute(delete(counters).where(NOTE)))
    return True


def _noted(connection: Connection) -> bool:
    return bool(connection.scalar(select(exists().where(NOTE))))
