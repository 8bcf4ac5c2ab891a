"""Models of every response, in the words of the project; units: day, m, kPa, degree, seconds where named so.

Timestamps are ISO 8601 in UTC. Numbers that are not finite are null: JSON knows no NaN.
"""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, SecretStr

from geoswarm.records.evaluation import Attempt, Evaluation, Response
from geoswarm.records.job import Generation, Job
from geoswarm.records.statistics import WeightShare
from geoswarm.records.worker import Worker
from geoswarm.solver.problem import Stopping

__all__ = [
    "AttemptList",
    "CheckResult",
    "EvaluationPage",
    "ForwardModelDetail",
    "ForwardModelList",
    "ForwardModelSummary",
    "GenerationList",
    "Health",
    "JobChange",
    "JobPage",
    "Liveness",
    "Number",
    "Parameter",
    "Series",
    "Session",
    "SignIn",
    "TestRun",
    "WarmStart",
    "WarmStarts",
    "WorkerList",
]


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]


class Model(BaseModel):
    """Read from the attributes of a view."""

    model_config = ConfigDict(from_attributes=True)


class JobPage(Model):
    """Jobs, newest first."""

    items: list[Job]
    next_cursor: str | None = Field(description="give it as cursor to get the next page; null at the end")


class AttemptList(Model):
    """Attempts in the order in which they started."""

    items: list[Attempt]


class JobChange(BaseModel):
    """What can be changed in an existing job."""

    model_config = ConfigDict(extra="forbid")

    stopping: Stopping = Field(description="the new stop criteria, instead of all previous ones")


class EvaluationPage(Model):
    """Evaluations ordered by generation and particle."""

    items: list[Evaluation]
    next_cursor: str | None = Field(description="give it as cursor to get the next page; null at the end")


class GenerationList(Model):
    """Generations in order."""

    items: list[Generation]


class WorkerList(Model):
    """Workers seen recently."""

    items: list[Worker]


class TestRun(Model):
    """One forward calculation to test the problem."""

    __test__ = False

    state: Literal["finished", "failed"]
    parameters: dict[str, float] = Field(description="all parameters, by name")
    objective: Number
    misfits: dict[str, Number]
    responses: dict[str, Response] = Field(description="calculated series at their observed points, base units")
    seconds: float
    reason: str | None
    message: str | None


class WarmStart(Model):
    """An earlier job with the same forward model: `warm_start: {jobs: [ID]}` offers its runs to the search."""

    job: str
    name: str
    evaluations: int = Field(description="that could be taken over at no cost, 2000 at most are counted")


class WarmStarts(Model):
    """Earlier jobs that a search can use, newest first, at most five."""

    items: list[WarmStart]


class CheckResult(Model):
    """What a valid problem will run and cost."""

    valid: Literal[True] = True
    name: str
    forward_model: str
    method: str
    free_parameters: list[str]
    data_points: int
    planned_evaluations: int | None = Field(description="null when only time or quality ends the search")
    left_to_answer: int | None = Field(
        description="how many of these the search leaves for minimum and intervals; null without planned_evaluations"
    )
    test_run: TestRun
    estimated_seconds: float | None = Field(
        description="time of all planned evaluations on one worker and of the search itself"
    )
    warnings: list[str] = Field(description="what is probably unintended or not modelled, and what to do")
    notes: dict[str, list[str]] = Field(description="how the readings of each series were processed, if they were")
    assumptions: list[str] = Field(description="what the forward model assumes where the problem says nothing")
    shares: list[WeightShare] = Field(description="what the weights make of each series")
    warm_starts: list[WarmStart] = Field(description="earlier jobs that the search can use, newest first")


class Parameter(Model):
    """A parameter of a forward model; limits in its unit."""

    name: str
    symbol: str
    unit: str
    description: str
    default: float | None = Field(description="null: the problem must give it")
    lower: Number
    upper: Number
    lower_open: bool = Field(description="the lower limit itself is refused")
    upper_open: bool
    typical: tuple[float, float] | None
    source: str = Field(description="source of the typical range; empty: none")


class Series(Model):
    """An output of a forward model: y over x, in base units."""

    name: str
    description: str
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str
    x_lower: Number
    x_upper: Number
    x_integer: bool
    x_increasing: bool


class ForwardModelSummary(Model):
    """A kind of forward model; ``model`` names a registered model, null for all other kinds."""

    kind: str
    description: str
    model: str | None


class ForwardModelList(Model):
    """Installed kinds of forward models."""

    items: list[ForwardModelSummary]


class ForwardModelDetail(ForwardModelSummary):
    """A kind of forward model in full."""

    json_schema: dict[str, Any] = Field(description="JSON schema of the forward_model section")
    example: dict[str, Any] | None = Field(description="a forward_model section of this kind")
    depends_on_section: bool = Field(
        description="parameters and series follow from the section (a formula, a combination); listed for the example"
    )
    note: str | None
    parameters: list[Parameter]
    series: list[Series]


class Liveness(Model):
    """The process answers."""

    status: Literal["ok"] = "ok"


class Health(Model):
    """Whether all that the service needs can be reached."""

    status: Literal["ok", "unavailable"]
    dependencies: dict[str, str] = Field(description="ok, embedded, or why it cannot be used")


class SignIn(BaseModel):
    """What a browser signs in with."""

    model_config = ConfigDict(extra="forbid")

    key: SecretStr = Field(min_length=1, max_length=500, description="an API key")


class Session(BaseModel):
    """Owner and role of the requester."""

    owner: str | None = Field(description="whose jobs are shown; null: those submitted without a key")
    role: Literal["agent", "read", "submit", "admin"]
    key_needed: bool = Field(description="whether this service asks for API keys")
    signed_in: bool = Field(description="whether a session's cookie was used")
    expires_at: datetime | None = Field(description="end of the session")
