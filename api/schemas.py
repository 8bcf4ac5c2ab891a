"""Models of every response, in the words of the project; units: day, m, kPa, degree, seconds where named so.

Timestamps are ISO 8601 in UTC. Numbers that are not finite are null: JSON knows no NaN.
"""

from __future__ import annotations

import math
from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, SecretStr

from geoswarm.records.evaluation import Evaluation, Response
from geoswarm.records.states import JobState
from geoswarm.solver.problem import Stopping

__all__ = [
    "Attempt",
    "AttemptList",
    "CheckResult",
    "EvaluationPage",
    "ForwardModelDetail",
    "ForwardModelList",
    "ForwardModelSummary",
    "Generation",
    "GenerationList",
    "Health",
    "Job",
    "JobChange",
    "JobPage",
    "Liveness",
    "Number",
    "Parameter",
    "Retry",
    "Series",
    "Session",
    "SignIn",
    "TestRun",
    "WarmStart",
    "WarmStarts",
    "Worker",
    "WorkerList",
]


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]


class Model(BaseModel):
    """Read from the attributes of a view."""

    model_config = ConfigDict(from_attributes=True)


class Job(Model):
    """A submitted problem and how far it is; ``objective`` and ``parameters`` are the best so far."""

    id: str
    name: str
    state: JobState
    forward_model: str
    method: str
    stop_reasons: list[str] = Field(description="every stop criterion that was satisfied at the end")
    objective: Number = Field(description="lowest objective f so far; null before the first success")
    parameters: dict[str, float] | None = Field(description="all parameters (free, fixed, linked) at that objective")
    evaluations: int = Field(description="counted in finished generations")
    generations: int
    failed_evaluations: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    seconds: float | None = Field(description="running time so far")
    error: str | None = Field(description="why the job failed")
    seed: int
    free_parameters: list[str]
    max_evaluations: int | None = Field(description="planned number of evaluations, when there is one")
    priority: int
    retrying: bool = Field(description="its failed evaluations are run again; then it is what it was before")
    owner: str | None = Field(description="whose key submitted it; null: none, or that of the environment")
    last_event: int = Field(description="id of its newest event: follow the events after it")
    trend: list[Number] | None = Field(
        None, description="lowest objective so far at evenly spaced generations; only in lists, when asked for"
    )
    versions: dict[str, str] | None = Field(
        description="of geoswarm, python and what calculates, when it was begun; null: not begun, or not recorded"
    )
    warnings: list[str] = Field(description="other versions that took part; what it waits for, when there is no room")


class JobPage(Model):
    """Jobs, newest first."""

    items: list[Job]
    next_cursor: str | None = Field(description="give it as cursor to get what follows; null at the end")


class Attempt(Model):
    """One try at an evaluation."""

    number: int
    worker: str | None
    outcome: str = Field(
        description="running, finished, the kind of failure, or why it does not count: late, overdue, stopped"
    )
    counted: bool = Field(description="it gave the evaluation's result")
    message: str | None
    log: str | None = Field(description="end of what the forward model wrote")
    started_at: datetime | None
    finished_at: datetime | None


class AttemptList(Model):
    """Tries in the order in which they were begun."""

    items: list[Attempt]


class JobChange(BaseModel):
    """What can be changed of a job that is there."""

    model_config = ConfigDict(extra="forbid")

    stopping: Stopping = Field(description="the stop criteria from now on, in place of all there were")


class Retry(Model):
    """Failed evaluations that are run again."""

    evaluations: int = Field(description="their number")
    job: Job


class EvaluationPage(Model):
    """Evaluations ordered by generation and particle."""

    items: list[Evaluation]
    next_cursor: str | None = Field(description="give it as cursor to get what follows; null at the end")


class Generation(Model):
    """One finished generation."""

    number: int
    evaluations: int = Field(description="total so far")
    failed: int = Field(description="failed evaluations so far")
    best_objective: Number = Field(description="lowest objective inside this generation")
    objective: Number = Field(description="lowest objective so far")
    parameters: dict[str, float] | None = Field(description="parameters of the lowest objective so far")
    created_at: datetime
    finished_at: datetime
    diversity: float | None = Field(
        description="scatter of the particles: near 1 all over the space, 0 at one point; null: not asked for"
    )


class GenerationList(Model):
    """Generations in order."""

    items: list[Generation]


class Worker(Model):
    """A process that runs forward calculations."""

    id: str
    host: str
    pid: int
    engine: str
    state: str
    job: str | None = Field(description="what it works on; null: on nothing, or on a job of somebody else")
    generation: int | None
    evaluations: int | None = Field(description="number of evaluations that it has claimed")
    busy_since: datetime | None
    started_at: datetime
    seen_at: datetime


class WorkerList(Model):
    """Workers that have been seen lately."""

    items: list[Worker]


class TestRun(Model):
    """One forward calculation, made to see whether the problem works."""

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
    """Earlier jobs that a problem could learn from, newest first, five at most."""

    items: list[WarmStart]


class CheckResult(Model):
    """What a valid problem would do and cost."""

    valid: Literal[True] = True
    name: str
    forward_model: str
    method: str
    free_parameters: list[str]
    data_points: int
    planned_evaluations: int | None = Field(description="null when only time or quality ends the search")
    test_run: TestRun
    estimated_seconds: float | None = Field(
        description="time of all planned evaluations on one worker and of the search itself"
    )
    warnings: list[str] = Field(description="what is probably not meant or not modelled, and what to do")
    warm_starts: list[WarmStart] = Field(description="earlier jobs that it could learn from, newest first")


class Parameter(Model):
    """A parameter that a forward model knows; limits in its unit."""

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
    """A kind of forward model."""

    kind: str
    description: str


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
    """Whether everything that the service needs can be reached."""

    status: Literal["ok", "unavailable"]
    dependencies: dict[str, str] = Field(description="ok, embedded, or why it cannot be used")


class SignIn(BaseModel):
    """What a browser signs in with."""

    model_config = ConfigDict(extra="forbid")

    key: SecretStr = Field(min_length=1, max_length=500, description="an API key")


class Session(BaseModel):
    """Who asks, and what they may."""

    owner: str | None = Field(description="whose jobs are shown; null: nobody's, as submitted without a key")
    role: Literal["read", "submit", "admin"]
    key_needed: bool = Field(description="whether this service asks for API keys")
    signed_in: bool = Field(description="whether a session's cookie was used")
    expires_at: datetime | None = Field(description="end of the session")
