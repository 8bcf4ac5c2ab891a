"""API keys: made once and shown once, stored as hashes, found by their public part, expiring and revocable.

A key reads ``gsw_ID_SECRET``. The secret has 256 random bits, so a plain SHA-256 keeps it: that many cannot be tried.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from collections.abc import Callable

from sqlalchemy import Connection

from geoswarm.records.account import ROLES, Key, Role
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import KeyNotFoundError, SettingsError, StoreUnavailableError
from geoswarm.workers.queries import api_keys
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import to_datetime, to_optional_datetime
from geoswarm.workers.store.database import Record

__all__ = ["KEY_PATTERN", "ApiKeys", "holder_of"]

KEY_PATTERN = re.compile(r"gsw_(?P<id>[0-9a-f]{12})_[A-Za-z0-9_-]{43}")
OWNER_PATTERN = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+-]{0,79}")
LONGEST_LABEL = 200
USED_EVERY_SECONDS = 60.0


class ApiKeys:
    """The keys of one store."""

    def __init__(self, store: Store) -> None:
        self.store = store

    def create(
        self,
        owner: str,
        role: Role,
        *,
        label: str = "",
        valid_seconds: float | None = None,
        job_id: str | None = None,
        admit: Callable[[Connection], None] | None = None,
    ) -> tuple[str, Key]:
        """Make a key; return it, this once, and what is stored of it.

        Parameters
        ----------
        owner
            Owner whose jobs the key can access; several keys may have one owner.
        valid_seconds
            Time until it expires [s]; None: never.
        job_id
            The only job of the owner that it can access, as the secret of a read-only link; None: all.
        admit
            Called first in the transaction that stores the key; raises when there may not be another one.

        Raises
        ------
        SettingsError
            When owner, role, label or time is not acceptable.
        StoreUnavailableError
        """
        if job_id is None and OWNER_PATTERN.fullmatch(owner) is None:
            raise SettingsError(
                "owner must be at most 80 letters, digits or . _ @ + -, beginning with a letter or digit; "
                f"got {owner[:80]!r}"
            )
        if role not in ROLES:
            raise SettingsError(f"role must be one of {', '.join(ROLES)}, got {role!r}")
        if len(label) > LONGEST_LABEL or not label.isprintable():
            raise SettingsError(f"label must be at most {LONGEST_LABEL} printable characters")
        if valid_seconds is not None and not valid_seconds > 0:
            raise SettingsError(f"the time until a key expires must be above 0 s, got {valid_seconds:g} s")
        key_id = secrets.token_hex(6)
        key = f"gsw_{key_id}_{secrets.token_urlsafe(32)}"
        values = {"id": key_id, "hash": _hash(key), "owner": owner, "role": role, "label": label, "job_id": job_id}

        def work(connection: Connection) -> Key:
            if api_keys.find_key(connection, key_id) is None:
                if admit is not None:
                    admit(connection)
                api_keys.insert_key(connection, values, valid_seconds)
            return _view(_found(connection, key_id))

        return key, self.store.write(work)

    def list(self, job_id: str | None = None) -> list[Key]:
        """Return all keys, or those of the read-only links of a job, oldest first."""
        return [_view(row) for row in self.store.read(lambda connection: api_keys.list_keys(connection, job_id))]

    def revoke(self, key_id: str, job_id: str | None = None) -> Key:
        """Revoke a key, at once and permanently; with a job only one of its read-only links.

        Raises
        ------
        KeyNotFoundError
        """

        def work(connection: Connection) -> Key:
            row = _found(connection, key_id)
            if job_id not in (None, row.job_id):
                raise KeyNotFoundError(key_id)
            api_keys.revoke_key(connection, key_id)
            return _view(_found(connection, key_id))

        return self.store.write(work)

    def used(self) -> bool:
        """Whether a key was ever made."""
        return self.store.read(api_keys.any_key)

    def principal(self, key: str) -> Principal | None:
        """Return the holder of a key; None when it is unknown, expired or revoked.

        Raises
        ------
        StoreUnavailableError
        """
        match = KEY_PATTERN.fullmatch(key)
        if match is None:
            return None
        row = self.store.read(lambda connection: api_keys.find_key(connection, match["id"]))
        if row is None or not hmac.compare_digest(row.hash, _hash(key)) or row.state != "active":
            return None
        if row.used_at is None or row.now - row.used_at > USED_EVERY_SECONDS:
            self._note_used(row.id)
        return holder_of(row)

    def _note_used(self, key_id: str) -> None:
        try:
            self.store.write(lambda connection: api_keys.note_used(connection, key_id, USED_EVERY_SECONDS))
        except StoreUnavailableError:
            return  # a read-only database still serves reads


def holder_of(row: Record) -> Principal:
    """Return the holder of a stored key."""
    return Principal(row.owner, row.role, row.id, row.job_id)


def _hash(key: str) -> str:
    return hashlib.sha256(key.encode()).hexdigest()


def _found(connection: Connection, key_id: str) -> Record:
    row = api_keys.find_key(connection, key_id)
    if row is None:
        raise KeyNotFoundError(key_id)
    return row


def _view(row: Record) -> Key:
    return Key(
        id=row.id,
        owner=row.owner,
        job=row.job_id,
        role=row.role,
        label=row.label,
        state=row.state,
        created_at=to_datetime(row.created_at),
        expires_at=to_optional_datetime(row.expires_at),
        revoked_at=to_optional_datetime(row.revoked_at),
        used_at=to_optional_datetime(row.used_at),
    )
