"""Asks the database whether it can be read and written: a disk that is full can still be read."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from sqlalchemy import Connection, insert, select, update

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import counters, metadata

__all__ = ["OneAtATime", "Probe"]

EVERY_SECONDS = 2.0
PATIENCE_SECONDS = 2.0
NAME = "probe"


class Probe:
    """Looks into every table and writes the time into a row of its own.

    Parameters
    ----------
    every
        However often it is asked, it does so once in this time at most [s]; between it asks for the time.
    reserve_bytes
        What must be free on the disk of an SQLite file [bytes].
    """

    def __init__(self, store: Store, every: float = EVERY_SECONDS, reserve_bytes: float = 0.0) -> None:
        self._store = store
        self._every = every
        self._reserve = reserve_bytes
        self._lock = threading.Lock()
        self._written_at = -every

    def database(self) -> str:
        """Return ``ok``, or why the database cannot be used; never raises."""
        try:
            self._store.ping()
        except StoreUnavailableError as error:
            return str(error)
        shortage = self._store.shortage(self._reserve)
        if shortage is not None:
            return shortage
        with self._lock:
            if time.monotonic() - self._written_at < self._every:
                return "ok"
            try:
                self._store.read(_look_into_tables)
            except StoreUnavailableError as error:
                return f"can be reached, but not read: {error}"
            try:
                self._store.write(_write)
            except StoreUnavailableError as error:
                return f"can be read, but not written: {error}"
            self._written_at = time.monotonic()
        return "ok"


class OneAtATime:
    """Asks something that may take long in one thread only, however many want to know.

    Parameters
    ----------
    look
        Answers ``ok`` or what is wrong; must not raise.
    patience
        How long a caller waits for the answer [s]; until it comes, others get the same result.
    """

    def __init__(self, look: Callable[[], str], patience: float = PATIENCE_SECONDS) -> None:
        self._look = look
        self._patience = patience
        self._lock = threading.Lock()
        self._began: float | None = None
        self._done = threading.Event()
        self._last: str | None = None

    def answer(self) -> str:
        """Return an answer of now, or the last one while the next is being looked for."""
        with self._lock:
            first = self._began is None
            if first:
                self._began = time.monotonic()
                self._done = threading.Event()
                threading.Thread(target=self._ask, name="geoswarm-probe", daemon=True).start()
            began, done, last = self._began or 0.0, self._done, self._last
        waited = time.monotonic() - began
        if first or last is None:
            done.wait(self._patience - waited)
        elif waited < self._patience:
            return last
        with self._lock:
            if done.is_set() and self._last is not None:
                return self._last
        return f"has not answered for {time.monotonic() - began:.0f} s"

    def _ask(self) -> None:
        answer = self._look()
        with self._lock:
            self._last = answer
            self._began = None
            self._done.set()


def _look_into_tables(connection: Connection) -> None:
    for table in metadata.sorted_tables:  # a row itself, not only an index, but none of its long texts
        connection.execute(select(*(column.is_(None) for column in table.columns)).limit(1)).all()


def _write(connection: Connection) -> None:
    row = {"name": NAME, "label": "", "value": database_now()}
    here = (counters.c.name == NAME, counters.c.label == "")
    if connection.execute(update(counters).where(*here).values(value=database_now())).rowcount == 0:
        connection.execute(insert(counters).values(row))
