"""The part of both clients about keys and operations, for administrators, and about who one is."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal, TypeAlias, TypeVar
from urllib.parse import quote

from geoswarm.client.calls import API, JSON_BODY, Call, present, reader

__all__ = ["Administration", "AsyncAdministration", "Key", "NewKey", "Operations", "Role", "Session"]

T = TypeVar("T")

Role: TypeAlias = Literal["read", "submit", "admin"]
"""What a key may: look at its owner's jobs; also submit and steer them; everything, for all."""


@dataclass(frozen=True, slots=True)
class Session:
    """Whose key a request brings, and what it may; ``expires_at`` only of a browser's session."""

    owner: str | None
    role: str
    key_needed: bool
    signed_in: bool
    expires_at: datetime | None


@dataclass(frozen=True, slots=True)
class Key:
    """An API key without its secret; ``state`` is active, expired or revoked, ``used_at`` to a minute."""

    id: str
    owner: str
    role: str
    label: str
    state: str
    created_at: datetime
    expires_at: datetime | None
    revoked_at: datetime | None
    used_at: datetime | None


@dataclass(frozen=True, slots=True)
class NewKey:
    """A key that was made: ``key`` is the secret, which nobody can show again, so keep it; ``repr`` leaves it out."""

    view: Key
    key: str = field(repr=False)


@dataclass(frozen=True, slots=True)
class Operations:
    """How the installation is doing, over all owners.

    Attributes
    ----------
    jobs, workers
        Number by state.
    waiting, running
        Evaluations of running jobs that wait for a worker, and that a worker has.
    oldest_wait
        Age of the oldest job that no worker has begun [s].
    outcomes
        Forward runs since the installation was made: finished, or the kind of failure.
    lost_evaluations
        Evaluations that were taken from a lost worker.
    event_streams
        Open event streams of the process that answered.
    """

    jobs: dict[str, int]
    waiting: int
    running: int
    oldest_wait: float
    workers: dict[str, int]
    outcomes: dict[str, int]
    lost_evaluations: int
    event_streams: int


def _session() -> Call[Session]:
    return Call("GET", f"{API}/session", reader(Session))


def _operations() -> Call[Operations]:
    return Call("GET", f"{API}/operations", reader(Operations))


def _keys() -> Call[tuple[Key, ...]]:
    return Call("GET", f"{API}/keys", reader(tuple[Key, ...], "items"))


def _create_key(owner: str, role: Role, label: str, valid_seconds: float | None) -> Call[NewKey]:
    content = json.dumps(present(owner=owner, role=role, label=label, valid_seconds=valid_seconds))
    return Call("POST", f"{API}/keys", reader(NewKey), headers=JSON_BODY, content=content)


def _revoke_key(key_id: str) -> Call[Key]:
    if not key_id:
        raise ValueError("key_id is empty; give the id of a key, the part of 12 digits between its underscores")
    return Call("POST", f"{API}/keys/{quote(key_id, safe='')}/revoke", reader(Key))


class Administration(ABC):
    """Keys and operations; part of :class:`geoswarm.client.Client`."""

    @abstractmethod
    def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    def session(self) -> Session:
        """Show whose key this client uses, and what it may."""
        return self._send(_session())

    def operations(self) -> Operations:
        """Show what waits, what runs and how forward runs have ended; administrators only."""
        return self._send(_operations())

    def keys(self) -> tuple[Key, ...]:
        """List all API keys without their secrets; administrators only."""
        return self._send(_keys())

    def create_key(
        self, owner: str, role: Role = "submit", *, label: str = "", valid_seconds: float | None = None
    ) -> NewKey:
        """Make an API key; the answer is the only place where its secret can be read. Administrators only.

        Parameters
        ----------
        owner
            Whose jobs it opens; several keys may have one owner.
        label
            What it is for.
        valid_seconds
            Time until it expires [s]; None: never.
        """
        return self._send(_create_key(owner, role, label, valid_seconds))

    def revoke_key(self, key_id: str) -> Key:
        """Make an API key invalid with the next request, for ever; administrators only."""
        return self._send(_revoke_key(key_id))


class AsyncAdministration(ABC):
    """Keys and operations; part of :class:`geoswarm.client.AsyncClient`."""

    @abstractmethod
    async def _send(self, call: Call[T]) -> T:
        """Send a request and read its answer."""

    async def session(self) -> Session:
        """Show whose key this client uses, and what it may."""
        return await self._send(_session())

    async def operations(self) -> Operations:
        """Show what waits, what runs and how forward runs have ended; administrators only."""
        return await self._send(_operations())

    async def keys(self) -> tuple[Key, ...]:
        """List all API keys without their secrets; administrators only."""
        return await self._send(_keys())

    async def create_key(
        self, owner: str, role: Role = "submit", *, label: str = "", valid_seconds: float | None = None
    ) -> NewKey:
        """Make an API key; the answer is the only place where its secret can be read. Administrators only.

        Parameters
        ----------
        owner
            Whose jobs it opens; several keys may have one owner.
        label
            What it is for.
        valid_seconds
            Time until it expires [s]; None: never.
        """
        return await self._send(_create_key(owner, role, label, valid_seconds))

    async def revoke_key(self, key_id: str) -> Key:
        """Make an API key invalid with the next request, for ever; administrators only."""
        return await self._send(_revoke_key(key_id))
