"""What a PostgreSQL server has done so far, for benchmarks that run beside it."""

from __future__ import annotations

import psutil
import psycopg


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
