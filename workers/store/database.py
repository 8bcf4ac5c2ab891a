"""Connections and transactions: SQLite and PostgreSQL behave the same behind :class:`Store`."""

from __future__ import annotations

import logging
import sqlite3
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias, TypeVar

from sqlalchemy import Connection, Engine, create_engine, event, func, select
from sqlalchemy.engine import make_url
from sqlalchemy.exc import DBAPIError, SQLAlchemyError

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import Settings, mask_url
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.file import DatabaseFile, FileIdentity, database_path
from geoswarm.workers.store.migrate import upgrade
from geoswarm.workers.store.statements import commit

__all__ = ["Record", "Store"]

log = logging.getLogger(__name__)

Result = TypeVar("Result")
Record: TypeAlias = Any
"""A row: its columns are attributes, with the types of :mod:`geoswarm.workers.store.tables`."""

SQLITE_BUSY_SECONDS = 20.0
RETRIES = 3  # deadlock, serialisation failure, prepared statements that are gone: the same function simply runs again
JOURNAL_BYTES = 16 * 2**20
SIZE_SECONDS = 5.0  # PostgreSQL looks at every file of the database to tell its size
RETRY_STATES = ("40001", "40P01", "26000")


class Store:
    """The database of jobs. Safe to share between threads, never between processes: open one after a fork.

    Parameters
    ----------
    file
        What the file of an SQLite database must be; it is not made then. None: what is there, or a new one.

    Raises
    ------
    StoreUnavailableError
        When the database cannot be reached, or is not one of this program, within ``connect_seconds``.
    """

    def __init__(self, settings: Settings, file: FileIdentity | None = None) -> None:
        self.url = settings.database_url
        path = database_path(settings)
        self._file = None if path is None else DatabaseFile(path, file)
        self._kept: list[Connection] = []
        self._size: tuple[float, int] | None = None  # when it was asked for, and the answer
        if self._file is not None:
            self._file.check()
            self._file.make()
        self.engine = _create_engine(settings)
        self._writer = self.engine.execution_options(write=True)
        # PostgreSQL gives each statement its own view anyway (read committed): reading needs no transaction around it.
        alone = self.engine.dialect.name == "postgresql"
        self._reader = self.engine.execution_options(isolation_level="AUTOCOMMIT") if alone else self.engine
        try:
            upgrade(self.engine)
        except (SQLAlchemyError, OSError) as error:
            self.engine.dispose()
            raise self._unavailable(error) from error
        except StoreUnavailableError:
            self.engine.dispose()
            raise
        if self._file is not None:
            self._file.remember()

    @property
    def file(self) -> FileIdentity | None:
        """Identity of the file of an SQLite database, for other processes that open it; None if there is no file."""
        return None if self._file is None else self._file.identity

    def free_bytes(self) -> int | None:
        """Return the free space on the disk of an SQLite file [bytes]; None for other databases."""
        try:
            return None if self._file is None else self._file.free_bytes()
        except OSError:  # the folder has gone; the next read or write reports it
            return None

    def shortage(self, reserve_bytes: float) -> str | None:
        """Return why only finished work may be stored (less free disk than the reserve), or None."""
        free = self.free_bytes()
        if free is None or free >= reserve_bytes:
            return None
        return (
            f"database: its disk has {free / 1e6:.0f} MB left; at least {reserve_bytes / 1e6:.0f} MB are kept free"
            " (GEOSWARM_DISK_RESERVE_MB). Delete jobs that are no longer needed, or make room otherwise"
        )

    def size_bytes(self) -> int:
        """Return the size of the database on disk [bytes]; for PostgreSQL it may be some seconds old.

        Raises
        ------
        StoreUnavailableError
        """
        if self._file is not None:
            return self._file.size_bytes()
        now = time.monotonic()
        if self._size is None or now - self._size[0] > SIZE_SECONDS:
            size = select(func.pg_database_size(func.current_database()))
            self._size = (now, self.read(lambda connection: connection.scalar(size)) or 0)
        return self._size[1]

    def read(self, function: Callable[[Connection], Result]) -> Result:
        """Run a function that only reads; retry once if the connection turns out to be dead.

        Raises
        ------
        StoreUnavailableError
            When the database does not answer.
        """
        return self._run(function, write=False)

    def write(self, function: Callable[[Connection], Result]) -> Result:
        """Run a function in one write transaction and commit.

        It may run more than once (dead connection, deadlock), so it must tolerate that an earlier run was committed.

        Raises
        ------
        StoreUnavailableError
            When the database does not answer.
        """
        return self._run(function, write=True)

    def ping(self) -> None:
        """Ask the database for the time.

        Raises
        ------
        StoreUnavailableError
            When it does not answer.
        """
        self.read(lambda connection: connection.scalar(select(database_now())))

    def truncate_journal(self) -> bool:
        """Empty SQLite's journal into its file; False if readers or writers prevent it now.

        The journal holds deleted pages, too, and keeps its size otherwise. Other databases have none.

        Raises
        ------
        StoreUnavailableError
        """
        if self._file is None:
            return True
        self._file.check()
        raw = self.engine.raw_connection()
        try:
            raw.cursor().execute("PRAGMA busy_timeout = 100")  # writers wait meanwhile
            row = raw.cursor().execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchone()
        except sqlite3.Error as error:
            raise self._unavailable(error) from error
        finally:
            raw.invalidate()  # its settings were changed
            raw.close()
        return row is None or row[0] == 0

    def close(self) -> None:
        """Close all connections."""
        while (connection := self._take_kept()) is not None:
            connection.invalidate()
            connection.close()
        self.engine.dispose()

    def _run(self, function: Callable[[Connection], Result], *, write: bool) -> Result:
        for attempt in range(RETRIES + 1):
            if self._file is not None:
                self._file.check()
            try:
                return self._write(function) if write else self._read(function)
            except DBAPIError as error:
                if attempt == RETRIES or not _worth_retrying(error, attempt):
                    raise self._unavailable(error) from error
                if error.connection_invalidated:
                    self.close()  # what cut one connection has cut the others
            except SQLAlchemyError as error:
                raise self._unavailable(error) from error
        raise StoreUnavailableError(f"database {mask_url(self.url)} is busy")

    def _read(self, function: Callable[[Connection], Result]) -> Result:
        with self._reader.begin() as connection:
            return function(connection)

    def _write(self, function: Callable[[Connection], Result]) -> Result:
        """Run it on the connection that is kept for this, as the pool takes as long for one as two statements."""
        connection = self._take_kept() or self._writer.connect()
        try:
            with connection.begin():
                result = function(connection)
                commit(connection)
        except BaseException:
            connection.close()
            raise
        if self._kept:
            connection.close()
        else:
            self._kept.append(connection)
        return result

    def _take_kept(self) -> Connection | None:
        try:
            return self._kept.pop()
        except IndexError:
            return None

    def _unavailable(self, error: Exception) -> StoreUnavailableError:
        cause = error.orig if isinstance(error, DBAPIError) and error.orig is not None else error
        reason = " ".join(str(cause).split()) or type(cause).__name__
        password = make_url(self.url).password
        if password:
            reason = reason.replace(str(password), "***")
        return StoreUnavailableError(f"database {mask_url(self.url)}: {reason}")


def _worth_retrying(error: DBAPIError, attempt: int) -> bool:
    """A dead connection is worth one new one; a deadlock's victim is to try again."""
    if error.connection_invalidated:
        return attempt == 0
    return getattr(error.orig, "sqlstate", None) in RETRY_STATES


def _create_engine(settings: Settings) -> Engine:
    url = make_url(settings.database_url)
    if url.drivername == "sqlite":
        folder = Path(url.database or "").expanduser().absolute().parent
        if not folder.is_dir():
            raise StoreUnavailableError(f"database {mask_url(settings.database_url)}: there is no folder {folder}")
        engine = create_engine(url, connect_args={"timeout": SQLITE_BUSY_SECONDS, "check_same_thread": False})
        _prepare_sqlite(engine)
        return engine
    return create_engine(
        url,
        connect_args={"connect_timeout": max(2, round(settings.connect_seconds)), "application_name": "geoswarm"},
        pool_size=5,
        max_overflow=20,
        pool_timeout=settings.connect_seconds,
    )


def _prepare_sqlite(engine: Engine) -> None:
    """Take transactions out of the driver's hands: a writer must lock first (BEGIN IMMEDIATE).

    A deferred transaction that reads and then writes fails at once when another has written in between, whatever the
    busy timeout.
    """

    @event.listens_for(engine, "connect")
    def _connect(connection: Any, _record: Any) -> None:
        connection.isolation_level = None
        cursor = connection.cursor()
        cursor.execute("PRAGMA foreign_keys = ON")
        cursor.execute("PRAGMA synchronous = NORMAL")  # with WAL: survives a crash of the program, consistent always
        cursor.execute(f"PRAGMA journal_size_limit = {JOURNAL_BYTES}")  # it shrinks when it begins anew
        cursor.close()

    @event.listens_for(engine, "begin")
    def _begin(connection: Connection) -> None:
        write = connection.get_execution_options().get("write", False)
        connection.exec_driver_sql("BEGIN IMMEDIATE" if write else "BEGIN")
