"""Lists and small answers of the routes; larger ones are records (:mod:`geoswarm.records`).

Timestamps are ISO 8601 in UTC. Numbers that are not finite are null: JSON knows no NaN.
"""

from __future__ import annotations

import math
import re
from typing import Annotated, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    SecretStr,
    StringConstraints,
    model_validator,
)

from geoswarm.records.evaluation import Attempt, Evaluation
from geoswarm.records.job import Attachment, Generation, Job
from geoswarm.records.problem import ForwardModelSummary, WarmStart
from geoswarm.records.service import Worker
from geoswarm.solver.problem import Stopping
from geoswarm.solver.problem.sections import ProblemName

__all__ = [
    "AttachmentList",
    "AttemptList",
    "EvaluationPage",
    "ForwardModelList",
    "GenerationList",
    "JobChange",
    "JobPage",
    "Liveness",
    "Number",
    "SignIn",
    "WarmStarts",
    "WorkerList",
]


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


Number = Annotated[float | None, BeforeValidator(_finite)]


class Model(BaseModel):
    """Read from the attributes of a view."""

    model_config = ConfigDict(from_attributes=True)


def _printable(tag: str) -> str:
    if "," in tag or not tag.isprintable():
        raise ValueError(f"a tag has printable characters and no comma, got {tag!r}")
    return tag


def _written(note: str) -> str:
    if re.search(r"[\x00-\x08\x0b\x0c\x0e-\x1f\x7f]", note):
        raise ValueError("a note has no control characters but tabs and ends of lines")
    return note


Tag = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1, max_length=40), AfterValidator(_printable)]
Note = Annotated[str, StringConstraints(max_length=10_000), AfterValidator(_written)]


class JobPage(Model):
    """Jobs, newest first."""

    items: list[Job]
    next_cursor: str | None = Field(description="give it as cursor to get the next page; null at the end")


class AttachmentList(Model):
    """Files of a job, oldest first."""

    items: list[Attachment]


class AttemptList(Model):
    """Attempts in the order in which they started."""

    items: list[Attempt]


class JobChange(BaseModel):
    """What can be changed in an existing job."""

    model_config = ConfigDict(extra="forbid")

    stopping: Stopping | None = Field(None, description="the new stop criteria, instead of all previous ones")
    name: ProblemName | None = Field(None, description="the new name; the stored problem keeps its first one")
    tags: list[Tag] | None = Field(None, max_length=20, description="the new tags, instead of all previous ones")
    note: Note | None = Field(None, description="the new note, in Markdown, instead of the previous one")

    @model_validator(mode="after")
    def _something(self) -> JobChange:
        if not self.labels and self.stopping is None:
            raise ValueError("nothing to change; give stopping, name, tags or note")
        return self

    @property
    def labels(self) -> bool:
        """Whether name, tags or note change."""
        return not (self.name is None and self.tags is None and self.note is None)


class EvaluationPage(Model):
    """Evaluations in the order that was asked for."""

    items: list[Evaluation]
    next_cursor: str | None = Field(description="give it as cursor to get the next page; null at the end")


class GenerationList(Model):
    """Generations in order."""

    items: list[Generation]


class WorkerList(Model):
    """Workers seen recently."""

    items: list[Worker]


class WarmStarts(Model):
    """Earlier jobs that a search can use, newest first, at most five."""

    items: list[WarmStart]


class ForwardModelList(Model):
    """Installed kinds of forward models."""

    items: list[ForwardModelSummary]


class Liveness(Model):
    """The process answers."""

    status: Literal["ok"] = "ok"


class SignIn(BaseModel):
    """What a browser signs in with."""

    model_config = ConfigDict(extra="forbid")

    key: SecretStr = Field(min_length=1, max_length=500, description="an API key")
