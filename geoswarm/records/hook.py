"""Whom to tell when a job has ended."""

from __future__ import annotations

from datetime import datetime
from typing import Literal

from geoswarm.records.record import described, record
from geoswarm.records.states import DeliveryState, EndedState

__all__ = ["Hook", "NewHook"]


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
