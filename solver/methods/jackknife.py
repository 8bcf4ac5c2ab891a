"""The fits without each of several tests."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB, FollowUpMethod, Maker, PlainMaker, Task, in_order

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.search.base import Snapshot
    from geoswarm.solver.search.descent.leaving_out import LeavingOutSearch
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["FEWEST_TESTS", "JackknifeMethod", "lacks_tests", "most_runs"]

FEWEST_TESTS = 3
_EACH = 6  # runs of each parameter and of each fit
_FIRST_STEP = 0.02


def most_runs(free: int, tests: int) -> int:
    """Evaluations that suffice by experience: the optimum, moves of each parameter, and some of each fit."""
    return 1 + _EACH * (free + tests)


def lacks_tests(problem: Problem) -> str | None:
    """Why no test of a problem can be left out; None where one can."""
    names = dict.fromkeys(name for name, _ in problem.series_by_test if name)
    if len(names) >= FEWEST_TESTS:
        return None
    return (
        f"to leave out one test at a time, a combined problem needs at least {FEWEST_TESTS} tests with readings, got "
        f"{', '.join(names) or 'a single one'}"
    )


class JackknifeMethod(FollowUpMethod):
    """The parameters fitted again without each test, all fits from the same runs."""

    title: ClassVar[str] = "leaving out one test at a time"

    kind: Literal["jackknife"] = "jackknife"
    at: dict[str, float] = Field(min_length=1, description="the optimum: values of all free parameters")
    step: dict[str, Annotated[float, Field(gt=0, le=0.1)]] = Field(
        default={}, description=f"first move, in parts of the range; {_FIRST_STEP} where absent"
    )
    runs: int = Field(ge=2, le=100_000, description="evaluations at most; the fits share them")
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    def planned(self, free: int) -> int | None:  # noqa: ARG002  (the form of all methods)
        """Return the number of evaluations at most."""
        return self.runs

    @property
    def learns(self) -> bool:
        """Always: the fits follow the residuals."""
        return True

    def in_words(self) -> str:
        """Name it."""
        return f"follow-up: leaving out one test at a time, at most {self.runs} runs"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare the optimum with the parameters, and look for tests."""
        issues = self.issues_at(self.at, problem)
        lacking = lacks_tests(problem)
        if lacking is not None:
            issues.append(Issue("method", lacking))
        return issues

    def further_issues(self, free: list[str]) -> list[Issue]:
        """Compare the names of steps with the parameters."""
        unknown = [name for name in self.step if name not in free]
        if not unknown:
            return []
        return [Issue("method.step", f"{', '.join(unknown)}: not a free parameter; free: {', '.join(free)}")]

    def search(
        self, space: SearchSpace, tests: Sequence[tuple[str, int]], snapshot: Snapshot | None = None
    ) -> LeavingOutSearch:
        """Begin, or go on; ``tests``: the test and the number of readings of each series."""
        from geoswarm.solver.search.descent.leaving_out import LeavingOutSearch, LeavingOutSettings

        step = in_order(space, self.step, _FIRST_STEP)
        return LeavingOutSearch(space, LeavingOutSettings(in_order(space, self.at), step, tests, self.runs), snapshot)

    def maker(self, task: Task) -> Maker:
        """Prepare to make it for a job."""
        return PlainMaker(partial(self.search, task.space, task.tests))
