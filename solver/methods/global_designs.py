"""Designs for global sensitivity: Sobol indices, elementary effects of Morris."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB, FollowUpMethod, Maker, PlainMaker, Task
from geoswarm.solver.system.extras import has, needs_extra

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Search, Snapshot
    from geoswarm.solver.search.descent.planned import GlobalPoints
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["GlobalMethod", "MorrisMethod", "SobolMethod"]


class GlobalMethod(FollowUpMethod):
    """A design over the whole space."""

    further: ClassVar[int]
    """Evaluations of a base point, or a trajectory, beside one a parameter."""

    if TYPE_CHECKING:  # each declares its fields in its own order
        kind: Literal["sobol", "morris"]
        samples: int
        batch: int

    def planned(self, free: int) -> int | None:
        """Return the number of evaluations."""
        return self.samples * (free + self.further)

    def in_words(self) -> str:
        """Name it."""
        return f"follow-up: {self.title}"

    def issues(self, problem: Problem) -> list[Issue]:  # noqa: ARG002  others need it
        """It needs a library."""
        return [] if has("SALib") else [Issue("method.kind", needs_extra(f"the method {self.kind}", "SALib"))]

    def points(self, space: SearchSpace, seed: int) -> GlobalPoints:
        """Draw the points of the design."""
        from geoswarm.solver.search.descent.planned import GlobalPoints

        return GlobalPoints(space, self.kind, self.samples, seed)

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""
        points = self.points(task.space, task.seed)

        def search(snapshot: Snapshot | None) -> Search:
            from geoswarm.solver.search.descent.planned import DesignSearch

            return DesignSearch(points, self.batch, snapshot)

        return PlainMaker(search)


class SobolMethod(GlobalMethod):
    """Sobol indices over the whole space, the share of the variation by parameter; samples (d + 2) evaluations."""

    title: ClassVar[str] = "Sobol indices"

    kind: Literal["sobol"] = "sobol"
    samples: int = Field(256, ge=8, le=2**17, description="base points, a power of two")
    batch: int = Field(200, ge=1, le=1000, description="evaluations in a generation")
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)
    further: ClassVar[int] = 2
    """Evaluations of a base point beside one a parameter."""

    @field_validator("samples")
    @classmethod
    def _power_of_two(cls, value: int) -> int:
        if value & (value - 1):
            raise PydanticCustomError("power_of_two", "must be a power of two, got {value}", {"value": value})
        return value


class MorrisMethod(GlobalMethod):
    """Elementary effects of Morris over the whole space, a cheap screening; samples (d + 1) evaluations."""

    title: ClassVar[str] = "Morris' elementary effects"

    kind: Literal["morris"] = "morris"
    samples: int = Field(20, ge=8, le=100_000, description="trajectories")
    batch: int = Field(200, ge=1, le=1000, description="evaluations in a generation")
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)
    further: ClassVar[int] = 1
    """Evaluations of a trajectory beside one a parameter."""
