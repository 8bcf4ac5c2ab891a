"""Queries on the sessions of browsers."""

from __future__ import annotations

from sqlalchemy import Connection, delete, insert, select

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import sessions

__all__ = ["delete_session", "find_session", "insert_session"]


def insert_session(connection: Connection, token_hash: str, key_id: str, key_hash: str, valid_seconds: float) -> None:
    """Enter a session that is valid for some time [s]; those that are over go."""
    connection.execute(delete(sessions).where(sessions.c.expires_at <= database_now()))
    values = {"hash": token_hash, "key_id": key_id, "key_hash": key_hash}
    connection.execute(
        insert(sessions).values(**values, created_at=database_now(), expires_at=database_now() + valid_seconds)
    )


def find_session(connection: Connection, token_hash: str) -> Record | None:
    """Return a session that is not over."""
    statement = select(sessions).where(sessions.c.hash == token_hash, sessions.c.expires_at > database_now())
    return connection.execute(statement).one_or_none()


def delete_session(connection: Connection, token_hash: str) -> None:
    """End a session; nothing happens when there is none."""
    connection.execute(delete(sessions).where(sessions.c.hash == token_hash))
