"""Asks the database whether it can be read and written: a disk that is full can still be read."""

from __future__ import annotations

import threading
import time

from sqlalchemy import Connection, insert, update

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.tables import counters

__all__ = ["Probe"]

EVERY_SECONDS = 2.0
NAME = "probe"


class Probe:
    """Writes the time into a row of its own; however often it is asked, at most once in ``every`` seconds."""

    def __init__(self, store: Store, every: float = EVERY_SECONDS) -> None:
        self._store = store
        self._every = every
        self._lock = threading.Lock()
        self._written_at = -every

    def database(self) -> str:
        """Return ``ok``, or why the database cannot be used; never raises."""
        try:
            self._store.ping()
        except StoreUnavailableError as error:
            return str(error)
        with self._lock:
            if time.monotonic() - self._written_at < self._every:
                return "ok"
            try:
                self._store.write(_write)
            except StoreUnavailableError as error:
                return f"can be read, but not written: {error}"
            self._written_at = time.monotonic()
        return "ok"


def _write(connection: Connection) -> None:
    row = {"name": NAME, "label": "", "value": database_now()}
    here = (counters.c.name == NAME, counters.c.label == "")
    if connection.execute(update(counters).where(*here).values(value=database_now())).rowcount == 0:
        connection.execute(insert(counters).values(row))
