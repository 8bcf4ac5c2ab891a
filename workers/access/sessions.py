"""Sessions of browsers: signed in with an API key once, known by a random token afterwards.

The token has 256 random bits and only its hash is stored, so that a reader of the database cannot use it. A session
ends when it is ended, after :data:`SESSION_SECONDS`, and as soon as its key is revoked, expired or replaced.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import Connection

from geoswarm.workers.access.keys import holder_of
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.queries import api_keys, sessions
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import to_datetime

__all__ = ["SESSION_SECONDS", "SignInSessions", "SessionView"]

SESSION_SECONDS = 12 * 3600.0
TOKEN_PATTERN = re.compile(r"[A-Za-z0-9_-]{43}")


@dataclass(frozen=True, slots=True)
class SessionView:
    """Whose session it is, and until when."""

    principal: Principal
    expires_at: datetime


class SignInSessions:
    """The sessions of one store.

    Parameters
    ----------
    environment_key
        The key that is not in the database, and whom it stands for; None when there is none.
    """

    def __init__(self, store: Store, environment_key: tuple[bytes, Principal] | None = None) -> None:
        self.store = store
        self._environment = None if environment_key is None else (_hash(environment_key[0]), environment_key[1])

    def open(self, key: bytes, principal: Principal) -> str:
        """Begin a session after a valid key was shown; return its token, this once.

        The principal has the id of the key.

        Raises
        ------
        StoreUnavailableError
        """
        token, key_id = secrets.token_urlsafe(32), principal.key_id or ""

        def work(connection: Connection) -> None:
            sessions.insert_session(connection, _hash(token.encode()), key_id, _hash(key), SESSION_SECONDS)

        self.store.write(work)
        return token

    def find(self, token: str) -> SessionView | None:
        """Return the session of a token; None when it is unknown or over.

        Raises
        ------
        StoreUnavailableError
        """
        if TOKEN_PATTERN.fullmatch(token) is None:
            return None
        return self.store.read(lambda connection: self._find(connection, _hash(token.encode())))

    def close(self, token: str) -> None:
        """End a session; nothing happens when it is over already.

        Raises
        ------
        StoreUnavailableError
        """
        self.store.write(lambda connection: sessions.delete_session(connection, _hash(token.encode())))

    def _find(self, connection: Connection, token_hash: str) -> SessionView | None:
        row = sessions.find_session(connection, token_hash)
        if row is None:
            return None
        expires_at = to_datetime(row.expires_at)
        if self._environment is not None and row.key_id == self._environment[1].key_id:
            same = hmac.compare_digest(row.key_hash, self._environment[0])
            return SessionView(self._environment[1], expires_at) if same else None
        key = api_keys.find_key(connection, row.key_id)
        if key is None or key.state != "active" or not hmac.compare_digest(row.key_hash, key.hash):
            return None
        return SessionView(holder_of(key), expires_at)


def _hash(secret: bytes) -> str:
    return hashlib.sha256(secret).hexdigest()
