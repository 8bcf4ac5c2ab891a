"""Models for administrators: API keys and links, and the state of the installation; and hooks."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.records.account import Hook, Key, Role
from geoswarm.records.states import ENDED_STATES, EndedState

__all__ = ["HookList", "KeyList", "NewHookRequest", "NewKeyRequest", "NewLinkRequest"]


class KeyList(BaseModel):
    """Keys, oldest first."""

    items: list[Key]


class NewKeyRequest(BaseModel):
    """A key to create."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    owner: str = Field(
        min_length=1,
        max_length=80,
        pattern=r"^[A-Za-z0-9][A-Za-z0-9._@+-]*$",
        description="owner whose jobs the key can access; several keys may have one owner",
    )
    role: Role = "submit"
    label: str = Field("", max_length=200, description="what it is for")
    valid_seconds: float | None = Field(None, gt=0, le=3.2e9, description="time until it expires; null: never")


class NewLinkRequest(BaseModel):
    """A read-only link to create."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    label: str = Field("", max_length=200, description="whom it is for")
    valid_days: float = Field(14, gt=0, le=366, description="time until it expires [day]")


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
