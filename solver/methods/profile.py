"""Profile objectives."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB, FollowUpMethod, Maker, PlainMaker, Task, in_order

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Snapshot
    from geoswarm.solver.search.descent.planned import ProfileSearch
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["ProfileMethod"]

_Positive = Annotated[float, Field(gt=0)]


class ProfileMethod(FollowUpMethod):
    """Profile objectives: the lowest objective for every value of one parameter, all parameters and sides at once."""

    title: ClassVar[str] = "profile objectives"

    kind: Literal["profile"] = "profile"
    at: dict[str, float] = Field(min_length=1, description="the optimum: values of all free parameters")
    rise: dict[str, _Positive] = Field(
        min_length=1, description="rise of the objective at the ends of the interval, of each parameter to profile"
    )
    step: dict[str, Annotated[float, Field(gt=0, le=0.1)]] = Field(
        default={}, description="first step away from the optimum, in parts of the range; 0.05 where absent"
    )
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    @property
    def learns(self) -> bool:
        """Always."""
        return True

    def in_words(self) -> str:
        """Name it."""
        return "follow-up: profile objectives"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare the optimum with the parameters."""
        return self.issues_at(self.at, problem)

    def further_issues(self, free: list[str]) -> list[Issue]:
        """Compare the names of rises and steps with the parameters."""
        issues = []
        for key, section in (("rise", self.rise), ("step", self.step)):
            unknown = [name for name in section if name not in free]
            if unknown:
                message = f"{', '.join(unknown)}: not a free parameter; free: {', '.join(free)}"
                issues.append(Issue(f"method.{key}", message))
        return issues

    def search(self, space: SearchSpace, snapshot: Snapshot | None = None) -> ProfileSearch:
        """Begin, or go on."""
        from geoswarm.solver.search.descent.planned import BLIND_STEP, ProfileSearch, ProfileSettings

        rise, step = in_order(space, self.rise, np.nan), in_order(space, self.step, BLIND_STEP)
        return ProfileSearch(space, ProfileSettings(in_order(space, self.at), rise, step), snapshot)

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""
        return PlainMaker(partial(self.search, task.space))
