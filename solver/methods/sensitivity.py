"""Sensitivities at an optimum."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB, FollowUpMethod, Maker, PlainMaker, Task, in_order

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Snapshot
    from geoswarm.solver.search.descent.minimum import MinimumSearch
    from geoswarm.solver.search.descent.planned import SensitivitySearch
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["SensitivityMethod"]


class SensitivityMethod(FollowUpMethod):
    """Sensitivities at an optimum by differences of fourth order, 4 d + 1 evaluations a step.

    Without a step, one is found for each parameter: further generations move only those parameters whose derivative is
    not certain yet, and a last one, of 2 d evaluations, lies at the ends of the intervals that they give.
    """

    title: ClassVar[str] = "sensitivities at an optimum"

    kind: Literal["sensitivity"] = "sensitivity"
    at: dict[str, float] = Field(min_length=1, description="the optimum: values of all free parameters")
    step: float | None = Field(
        None,
        gt=0,
        le=0.1,
        description="largest difference, in parts of the range in search coordinates; found for each parameter if "
        "absent, which takes some more evaluations",
    )
    polish: bool = Field(
        False, description="go to the minimum first by Levenberg-Marquardt steps, one generation of 2 d + 1 each"
    )
    runs: int | None = Field(
        None,
        ge=1,
        description="evaluations at most, with polish: differences first, which give the steps to the minimum, and "
        "again there if it is far",
    )
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    def planned(self, free: int) -> int | None:
        """Number of evaluations at most; None when it is not known before."""
        return None if self.polish or self.step is None else 4 * free + 1

    @property
    def learns(self) -> bool:
        """Unless all differences are known before."""
        return self.polish or self.step is None

    def in_words(self) -> str:
        """Name it."""
        return "follow-up: sensitivities at an optimum"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare the optimum with the parameters."""
        return self.issues_at(self.at, problem)

    def search(self, space: SearchSpace, snapshot: Snapshot | None = None) -> SensitivitySearch | MinimumSearch:
        """Begin, or go on."""
        from geoswarm.solver.search.descent.minimum import MinimumSearch
        from geoswarm.solver.search.descent.planned import SensitivitySearch, SensitivitySettings

        if self.polish and self.runs is not None:
            return MinimumSearch(space, in_order(space, self.at), self.runs, snapshot)
        settings = SensitivitySettings(in_order(space, self.at), self.step, self.polish)
        return SensitivitySearch(space, settings, snapshot)

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""
        return PlainMaker(partial(self.search, task.space))
