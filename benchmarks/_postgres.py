"""What a PostgreSQL server has done so far, for benchmarks that run beside it."""

from __future__ import annotations

import threading
import time
from typing import Any

import psutil
import psycopg
from sqlalchemy import Connection, event, text

from geoswarm.workers.coordinator import runtime
from geoswarm.workers.store import Store


class PostgresWork:
    """Counters of a server, read over a connection of their own.

    Parameters
    ----------
    url
        Of a database of the server, in the form of SQLAlchemy.
    pid
        The server's process.
    """

    def __init__(self, url: str, pid: int) -> None:
        self.connection = psycopg.connect(url.replace("+psycopg", ""), autocommit=True)
        self.process = psutil.Process(pid)

    def seconds(self) -> float:
        """Return the processor time of all processes of the server [s]."""
        total = 0.0
        for process in (self.process, *self.process.children(recursive=True)):
            try:
                times = process.cpu_times()
            except psutil.NoSuchProcess:
                continue
            total += times.user + times.system
        return total

    def number(self, statement: str) -> int:
        """Return the number that a query gives."""
        row = self.connection.execute(statement).fetchone()
        assert row is not None
        return int(row[0])

    def transactions(self) -> int:
        """Return the number of transactions of this database."""
        return self.number("SELECT xact_commit FROM pg_stat_database WHERE datname = current_database()")

    def wal(self) -> int:
        """Return the bytes written ahead."""
        return self.number("SELECT pg_current_wal_lsn() - '0/0'::pg_lsn")


class LockTimes:
    """How long transactions have the row of a job locked [s]: from the answer to its lock to its commit."""

    def __init__(self, store: Store) -> None:
        self.seconds: list[float] = []
        self._engine = store.engine
        self._local = threading.local()
        self._lock_job = runtime.lock_job
        runtime.lock_job = self._lock  # type: ignore[assignment]  # it stands around the function
        event.listen(self._engine, "commit", self._commit)

    def _lock(self, *given: Any, **more: Any) -> Any:
        locked = self._lock_job(*given, **more)
        self._local.since = time.perf_counter()
        return locked

    def _commit(self, _connection: object) -> None:
        since, self._local.since = getattr(self._local, "since", None), None
        if since is not None:
            self.seconds.append(time.perf_counter() - since)

    def close(self) -> None:
        """Lock as before."""
        runtime.lock_job = self._lock_job
        event.remove(self._engine, "commit", self._commit)


def accounts(store: Store) -> tuple[int, str]:
    """Return the number of leases that ended before their run, and what is wrong with the accounts of jobs."""

    def look(connection: Connection) -> tuple[int, str]:
        lost = connection.scalar(text("SELECT sum(value) FROM counters WHERE name = 'lease_expirations'"))
        wrong = connection.execute(
            text(
                "SELECT jobs.id FROM jobs LEFT JOIN"
                " (SELECT e.job_id, count(*) AS ended, count(DISTINCT e.generation) AS n"
                " FROM evaluations e JOIN jobs j ON j.id = e.job_id AND e.generation < j.generation"
                " WHERE e.state = 'finished' GROUP BY e.job_id) AS found ON found.job_id = jobs.id"
                " WHERE (jobs.evaluations, jobs.generations) <> (coalesce(found.ended, 0), coalesce(found.n, 0))"
            )
        ).all()
        return int(lost or 0), f"{len(wrong)} jobs disagree" if wrong else "agree"

    return store.read(look)
