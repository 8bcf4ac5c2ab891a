"""Models of what agents send and are sent."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.solver.errors import FailureReason

__all__ = [
    "LONGEST_WAIT",
    "AgentLease",
    "AgentTerms",
    "Announced",
    "Brought",
    "LeaseAnswer",
    "LeaseRequest",
    "ResultsAnswer",
]

LONGEST_WAIT = 600.0
"""Of one request for work [s]."""

AgentId = Annotated[str, Field(pattern=r"^[A-Za-z0-9._-]{1,60}$", description="its own, new for each start")]
Line = Annotated[str, Field(max_length=200, pattern=r"^[^\x00-\x1f\x7f]*$")]
Time = Annotated[float, Field(ge=0.0, le=1e10)]
Count = Annotated[int, Field(ge=0, lt=2**31)]


class _Sent(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Announced(_Sent):
    """An agent, and what it runs."""

    agent: AgentId
    host: Line
    system: Line = Field(description="operating system and processor")
    pid: Count
    slots: int = Field(ge=1, le=1024, description="number of runs that it makes at once")
    versions: dict[Line, Line] = Field(
        max_length=50, description="versions of the packages that calculate there, including geoswarm"
    )
    kinds: list[Line] = Field(max_length=200, description="built-in kinds of forward model")
    models: dict[
        Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$")],
        Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")],
    ] = Field(max_length=1000, description="registered models: SHA-256 of the files of each")


class AgentTerms(BaseModel):
    """Terms for an agent."""

    heartbeat_seconds: float = Field(description="interval of heartbeats")
    lease_seconds: float = Field(description="time without a heartbeat after which a lease goes to others")
    wait_seconds: float = Field(description="longest wait for work in one request")
    accepted: list[str] = Field(
        description="what it may get: kinds if its version is that of the service, registered:NAME:HASH"
    )


class LeaseRequest(_Sent):
    """Request of a slot of an agent."""

    agent: AgentId
    slot: int = Field(ge=0, lt=1024)
    runs: int = Field(1, ge=1, le=10_000, description="the maximum at once")
    wait: float = Field(0.0, ge=0.0, le=LONGEST_WAIT, description="how long to wait for work, seconds")
    seconds: Time | None = Field(None, description="how long the agent still runs; null: unlimited")
    frames: list[Annotated[str, Field(pattern=r"^[0-9a-f]{32}$")]] = Field(
        [], max_length=64, description="runs that it already has"
    )


class LeasedRun(BaseModel):
    """One run to be made."""

    particle: int
    attempt: int
    values: dict[str, float] = Field(description="all parameters by name")
    refused: bool = Field(description="it must not be made, as the constraints are not satisfied there")


class AgentLease(BaseModel):
    """Work for a slot."""

    id: str
    job: str
    frame: str = Field(description="name of the part that all runs of the job share")
    shared: dict[str, Any] | None = Field(
        description="the shared part itself: forward_model, points (x of each series), inputs, limits, keeps_parts; "
        "null: it has it"
    )
    runs: list[LeasedRun]
    typical: float | None = Field(description="seconds that a run usually takes")


class LeaseAnswer(BaseModel):
    """A lease, if there is work."""

    lease: AgentLease | None


class BroughtRun(_Sent):
    """Result of one run."""

    particle: Count
    attempt: Count
    responses: dict[Annotated[str, Field(max_length=500)], list[float]] = Field(
        {},
        max_length=1000,
        description="values of each series at its points, base units; when it failed, those of the parts that "
        "succeeded, where the job keeps_parts",
    )
    reason: FailureReason | None = Field(None, description="kind of failure; null: it succeeded")
    message: str | None = Field(None, max_length=20_000, description="what happened, or a note")
    log: str | None = Field(None, max_length=20_000, description="end of what it printed")
    seconds: Time = Field(description="wall time of the calculation")
    began: Time = Field(description="by the agent's clock, since it was given the lease")
    ended: Time


class Brought(_Sent):
    """Results of a lease; the rest of what it held goes to others."""

    runs: list[BroughtRun] = Field(max_length=10_000)
    killed: Count | None = Field(None, description="particle whose run was started, and killed")
    next: LeaseRequest | None = Field(None, description="what the slot asks for now; its wait does not count")


class ResultsAnswer(LeaseAnswer):
    """Whether results were accepted."""

    taken: bool = Field(description="false: they had been accepted before, or the lease had ended; nothing changed")
