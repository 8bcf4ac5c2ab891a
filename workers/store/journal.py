"""Empties SQLite's journal after jobs were deleted: it still holds the deleted pages, and keeps its size.

Who reads just now may keep that from happening. So a row tells all processes that it is to be done, until it is.
"""

from __future__ import annotations

from sqlalchemy import Connection, and_, delete, exists, insert, select

from geoswarm.workers.store.database import Store
from geoswarm.workers.store.tables import counters

__all__ = ["empty_journal", "note_deletion"]

NAME = "journal"
NOTE = and_(counters.c.name == NAME, counters.c.label == "")


def note_deletion(connection: Connection) -> None:
    """Note that the journal is to be emptied; inside the transaction that deletes."""
    if connection.dialect.name == "sqlite" and not _noted(connection):
        connection.execute(insert(counters).values(name=NAME, label="", value=1.0))


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
