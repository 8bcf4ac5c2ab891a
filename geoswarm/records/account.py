"""What an owner sets up in a service: API keys, and hooks that are called when a job has ended."""

from __future__ import annotations

from datetime import datetime
from typing import Literal, TypeAlias, get_args

from geoswarm.records.record import described, record
from geoswarm.records.states import DeliveryState, EndedState, KeyState

__all__ = ["Hook", "Key", "NewHook", "NewKey", "NewLink", "ROLES", "Role"]

Role: TypeAlias = Literal["agent", "read", "submit", "admin"]

ROLES: tuple[Role, ...] = get_args(Role)
"""An agent runs what is calculated and sees nothing else. Of the others each may what the ones before it may: look at
one's own jobs; also submit and steer them; everything, for all."""


@record
class Key:
    """An API key, without its secret."""

    id: str
    owner: str
    job: str | None = described("the only job that it shows, as a read-only link; null: all jobs of the owner")
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


@record
class NewLink:
    """A new read-only link to a job."""

    path: str = described("address of the link in this service, with its secret, shown only now", repr=False)
    view: Key


@record
class Hook:
    """An address that is notified when jobs end, and the state of the last message."""

    id: str
    kind: Literal["web", "mail"]
    target: str = described("address to notify: https://... or an e-mail address")
    states: list[EndedState] = described("only jobs that ended in one of these states")
    job: str | None = described("the only job to report; null: all jobs of the owner")
    owner: str | None
    created_at: datetime
    last_state: DeliveryState | None = described("state of the newest message; null: there was none")
    last_at: datetime | None = described("when that message was made")
    last_tries: int | None
    last_error: str | None = described("why its last attempt failed")


@record
class NewHook:
    """A new hook."""

    secret: str | None = described(
        "secret that signs its requests, shown only now; null for e-mail, which is not signed", repr=False
    )
    view: Hook
