"""Announces committed events immediately, if the database can; listeners may sleep in between."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

from sqlalchemy import Connection, bindparam, func, insert
from sqlalchemy.exc import SQLAlchemyError

from geoswarm.workers.store.database import Store
from geoswarm.workers.store.statements import Statement
from geoswarm.workers.store.tables import events

__all__ = ["EventListener", "insert_events"]

log = logging.getLogger(__name__)

CHANNEL = "geoswarm_events"
LOOK_SECONDS = 0.5  # how soon the thread notices that it is to end
AGAIN_SECONDS = 2.0
EVENT: dict[str, Any] = {name: bindparam(name) for name in ("job_id", "kind", "data", "created_at")}
INSERTED = Statement(insert(events).values(EVENT).inline())
ANNOUNCED = Statement(insert(events).values(EVENT).returning(func.pg_notify(CHANNEL, "")))


def insert_events(connection: Connection, rows: list[dict[str, Any]]) -> None:
    """Write events. PostgreSQL notifies all listeners on commit, in the same statement."""
    (ANNOUNCED if connection.dialect.name == "postgresql" else INSERTED).write(connection, rows)


class EventListener:
    """Listens for events of any job in a thread of its own.

    Parameters
    ----------
    ring
        Called in that thread whenever there may be news.
    """

    def __init__(self, store: Store, ring: Callable[[], object]) -> None:
        self._store = store
        self._ring = ring
        self._ended = threading.Event()
        self.live = False
        """Whether the database announces events now; if not, query it."""

    def start(self) -> None:
        """Start listening; does nothing if the database cannot notify."""
        if self._store.engine.dialect.name == "postgresql":
            threading.Thread(target=self._listen, name="geoswarm-event-bell", daemon=True).start()

    def stop(self) -> None:
        """End soon; does not wait."""
        self._ended.set()
        self.live = False

    def _listen(self) -> None:
        while not self._ended.is_set():
            try:
                self._answer()
            except (SQLAlchemyError, self._store.engine.dialect.loaded_dbapi.Error) as error:
                self.live = False
                log.info("polling for events, because the database does not announce them: %s", error)
                self._ended.wait(AGAIN_SECONDS)

    def _answer(self) -> None:
        with self._store.engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            try:
                connection.exec_driver_sql(f"LISTEN {CHANNEL}")
                driver: Any = connection.connection.driver_connection
                self.live = not self._ended.is_set()
                self._ring()  # for what came before
                while not self._ended.is_set():
                    for _ in driver.notifies(timeout=LOOK_SECONDS, stop_after=1):
                        self._ring()
            finally:
                self.live = False
                connection.invalidate()  # so that the pool does not return a connection that listens
