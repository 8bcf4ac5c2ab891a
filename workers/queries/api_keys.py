"""Queries on API keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import Connection, and_, case, exists, insert, or_, select, update

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import api_keys

__all__ = ["any_key", "find_key", "insert_key", "list_keys", "note_used", "revoke_key"]

_EXPIRED = and_(api_keys.c.expires_at.is_not(None), api_keys.c.expires_at <= database_now())
_STATE = case((api_keys.c.revoked_at.is_not(None), "revoked"), (_EXPIRED, "expired"), else_="active").label("state")


def insert_key(connection: Connection, values: Mapping[str, Any], valid_seconds: float | None) -> None:
    """Store a key that is valid for a time [s], None for unlimited."""
    expires = None if valid_seconds is None else database_now() + valid_seconds
    connection.execute(insert(api_keys).values(**values, created_at=database_now(), expires_at=expires))


def find_key(connection: Connection, key_id: str) -> Record | None:
    """Return a key with its ``state`` and the time ``now``."""
    statement = select(api_keys, _STATE, database_now().label("now")).where(api_keys.c.id == key_id)
    return connection.execute(statement).one_or_none()


def list_keys(connection: Connection, job_id: str | None = None) -> Sequence[Record]:
    """Return all keys, or those of the read-only links of a job, with their ``state``, oldest first."""
    statement = select(api_keys, _STATE).order_by(api_keys.c.created_at, api_keys.c.id)
    return connection.execute(statement if job_id is None else statement.where(api_keys.c.job_id == job_id)).all()


def revoke_key(connection: Connection, key_id: str) -> None:
    """Revoke a key permanently."""
    condition = and_(api_keys.c.id == key_id, api_keys.c.revoked_at.is_(None))
    connection.execute(update(api_keys).where(condition).values(revoked_at=database_now()))


def note_used(connection: Connection, key_id: str, older_than: float) -> None:
    """Note that a key is used now, unless that was noted less than ``older_than`` [s] ago."""
    old = or_(api_keys.c.used_at.is_(None), api_keys.c.used_at < database_now() - older_than)
    connection.execute(update(api_keys).where(api_keys.c.id == key_id, old).values(used_at=database_now()))


def any_key(connection: Connection) -> bool:
    """Whether a key was ever made; revoking the last one does not open the door again."""
    return bool(connection.scalar(select(exists().select_from(api_keys))))
