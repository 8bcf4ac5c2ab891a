"""API keys, and what they may."""

from __future__ import annotations

from datetime import datetime
from typing import Literal, TypeAlias, get_args

from geoswarm.records.record import described, record
from geoswarm.records.states import KeyState

__all__ = ["ROLES", "Key", "NewKey", "Role"]

Role: TypeAlias = Literal["agent", "read", "submit", "admin"]

ROLES: tuple[Role, ...] = get_args(Role)
"""An agent runs what is calculated and sees nothing else. Of the others each may what the ones before it may: look at
one's own jobs; also submit and steer them; everything, for all."""


@record
class Key:
    """An API key, without its secret."""

    id: str
    owner: str
    role: Role
    label: str
    state: KeyState
    created_at: datetime
    expires_at: datetime | None
    revoked_at: datetime | None
    used_at: datetime | None = described("to a minute")


@record
class NewKey:
    """A new key."""

    key: str = described("the key itself, shown only now", repr=False)
    view: Key
