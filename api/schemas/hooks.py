"""Models of hooks."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.records.hook import Hook
from geoswarm.records.states import ENDED_STATES, EndedState

__all__ = ["HookList", "NewHookRequest"]


class HookList(BaseModel):
    """Hooks, oldest first."""

    items: list[Hook]


class NewHookRequest(BaseModel):
    """A hook to create."""

    model_config = ConfigDict(extra="forbid")

    target: str = Field(
        min_length=3, max_length=500, description="https://..., or an e-mail address if the service sends e-mail"
    )
    job: str | None = Field(
        None,
        pattern=r"^[A-Za-z0-9_-]{1,64}$",
        description="the only job to report, immediately if it has ended; null: all jobs of the owner",
    )
    states: list[EndedState] = Field(
        list(ENDED_STATES), min_length=1, max_length=3, description="report only jobs that ended in one of these states"
    )
