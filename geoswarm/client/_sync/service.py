# Generated from geoswarm/client/_async/service.py by scripts/generate_client.py; `make format` renews it.
"""The service itself: forward models, workers, health, and keys and operations for administrators."""

from __future__ import annotations

import json
from urllib.parse import quote

from geoswarm.client._sync.connection import Connection
from geoswarm.client.administration import Operations, Session
from geoswarm.client.calls import API, JSON_BODY, Call, present, reader
from geoswarm.client.models import ForwardModel, ForwardModelInfo, Health
from geoswarm.records.key import Key, NewKey, Role
from geoswarm.records.worker import Worker

__all__ = [
    "create_key",
    "forward_model",
    "forward_models",
    "health",
    "keys",
    "operations",
    "revoke_key",
    "session",
    "workers",
]


def forward_models(self: Connection) -> tuple[ForwardModelInfo, ...]:
    """List the kinds of forward model that the service has."""
    return self._send(Call("GET", f"{API}/forward-models", reader(tuple[ForwardModelInfo, ...], "items")))


def forward_model(self: Connection, kind: str) -> ForwardModel:
    """Show a kind of forward model: schema, parameters, series, units."""
    return self._send(Call("GET", f"{API}/forward-models/{quote(kind, safe='')}", reader(ForwardModel)))


def workers(self: Connection) -> tuple[Worker, ...]:
    """List the workers."""
    return self._send(Call("GET", f"{API}/workers", reader(tuple[Worker, ...], "items")))


def health(self: Connection) -> Health:
    """Show whether the service can work."""
    unavailable = frozenset({503})  # is an answer, not an error
    return self._send(Call("GET", "/health/ready", reader(Health), accepted=unavailable))


def session(self: Connection) -> Session:
    """Show whose key this client uses, and what it may."""
    return self._send(Call("GET", f"{API}/session", reader(Session)))


def operations(self: Connection) -> Operations:
    """Show what waits, what runs and how forward runs have ended; administrators only."""
    return self._send(Call("GET", f"{API}/operations", reader(Operations)))


def keys(self: Connection) -> tuple[Key, ...]:
    """List all API keys without their secrets; administrators only."""
    return self._send(Call("GET", f"{API}/keys", reader(tuple[Key, ...], "items")))


def create_key(
    self: Connection, owner: str, role: Role = "submit", *, label: str = "", valid_seconds: float | None = None
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
    content = json.dumps(present(owner=owner, role=role, label=label, valid_seconds=valid_seconds))
    return self._send(Call("POST", f"{API}/keys", reader(NewKey), headers=JSON_BODY, content=content))


def revoke_key(self: Connection, key_id: str) -> Key:
    """Make an API key invalid with the next request, for ever; administrators only."""
    if not key_id:
        raise ValueError("key_id is empty; give the id of a key, the part of 12 digits between its underscores")
    return self._send(Call("POST", f"{API}/keys/{quote(key_id, safe='')}/revoke", reader(Key)))
