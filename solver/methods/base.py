"""What every method declares."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, Protocol, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.widths import NEXT, Next, Situation
from geoswarm.solver.section import Section
from geoswarm.solver.sentences import setting

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem, Stopping
    from geoswarm.solver.search.base import Search, Snapshot
    from geoswarm.solver.search.runs import Runs
    from geoswarm.solver.search.space import SearchSpace

__all__ = [
    "DESIGN_COMPLETED",
    "OF_JOB",
    "FollowUpMethod",
    "Maker",
    "Method",
    "PlainMaker",
    "Role",
    "SearchMethod",
    "Task",
    "in_order",
]

Role: TypeAlias = Literal["search", "sampling", "follow_up"]
"""A search goes for the lowest objective, a sampling draws independently of it, a follow-up examines an optimum."""

DESIGN_COMPLETED = "design_completed"
OF_JOB = "id of the job whose optimum this is; its findings are shown there"


@dataclass(frozen=True, slots=True)
class Task:
    """What the search of a job is made from.

    Parameters
    ----------
    space, seed
        Where to search, and what fixes all random numbers.
    initial
        Initial values in natural units, shape (d,); NaN where a parameter has none.
    most
        Number of evaluations after which the job ends at the latest; None when no number limits it.
    offered
        Runs of earlier jobs; for methods that take offers.
    quick
        Runs of the forward model take milliseconds.
    tests
        Name of the test and number of readings of each series, in the order of residuals.
    """

    space: SearchSpace
    seed: int
    initial: FloatArray
    most: int | None
    offered: Runs | None
    quick: bool = False
    tests: tuple[tuple[str, int], ...] = ()


class Maker(Protocol):
    """Makes the search of one job, new or from a snapshot; keeps what all of them share."""

    def start(self, slots: int) -> Search:
        """Begin the search; this number of evaluations can run at once."""

    def restore(self, snapshot: Snapshot) -> Search:
        """Go on with the search that gave a snapshot, bit for bit alike."""


@dataclass(frozen=True, slots=True)
class PlainMaker:
    """Makes a search that is the same whatever can run at once; ``search`` begins it, or goes on after a snapshot."""

    search: Callable[[Snapshot | None], Search]

    def start(self, slots: int) -> Search:  # noqa: ARG002  (the form of all makers)
        """Begin the search."""
        return self.search(None)

    def restore(self, snapshot: Snapshot) -> Search:
        """Go on with it."""
        return self.search(snapshot)


class Method(Section, ABC):
    """A section ``method`` of the problem file; subclasses add ``kind: Literal[...]``, their fields and their words."""

    role: ClassVar[Role]
    title: ClassVar[str]
    """What it is called in sentences: "particle swarm"."""
    bias: ClassVar[str] = ""
    """What to keep in mind when its evaluations are taken for samples; empty: nothing."""

    keeps_parts: ClassVar[bool] = False
    """Whether a combined run of which a part failed keeps the series of the others."""

    kind: str

    @abstractmethod
    def maker(self, task: Task) -> Maker:
        """Prepare to make the search of a job."""

    @abstractmethod
    def in_words(self) -> str:
        """Describe it with its most important settings, in a few words."""

    def planned(self, free: int) -> int | None:  # noqa: ARG002  (the form of all methods)
        """Return the number of evaluations after which it ends by itself, of ``free`` parameters; None: not known."""
        return None

    @property
    def learns(self) -> bool:
        """Whether its search needs the residuals of all runs so far."""
        return False

    @property
    def takes_offers(self) -> bool:
        """Whether its search can begin with what runs of earlier jobs have shown."""
        return False

    @property
    def drawn_at_once(self) -> int:
        """Number of points that are drawn as a whole before the first evaluation."""
        return 0

    @property
    def follows_slots(self) -> bool:
        """Whether the size of a generation follows the runs that can be under way at once."""
        return False

    @property
    def may_overlap(self) -> bool:
        """Whether a generation may be begun before the one in front of it is complete."""
        return False

    def asks_next(self, situation: Situation | None, lengths: Sequence[float], *, quick: bool) -> Next:  # noqa: ARG002
        """Return what an engine asks for when it has closed a generation.

        Parameters
        ----------
        situation
            What the engine sees; None: nothing, and sizes stay as they are.
        lengths
            What the last runs took [s], those of the closed generation included.
        quick
            Runs of the forward model take milliseconds.
        """
        return NEXT

    def issues(self, problem: Problem) -> list[Issue]:  # noqa: ARG002  others need it
        """Return why it does not fit the parameters and measurements of a problem."""
        return []

    def stopping_issues(self, stopping: Stopping) -> list[Issue]:  # noqa: ARG002  others need it
        """Return why stop criteria do not fit it."""
        return []

    def end_reason(self, search: Search, evaluations: int, *, over: bool) -> str | None:  # noqa: ARG002  others need it
        """Return the reason when it has ended by itself; ``over``: its search asks for nothing more."""
        return None


class SearchMethod(Method):
    """A method that goes for the lowest objective until a stop criterion is satisfied."""

    role: ClassVar[Role] = "search"
    bias: ClassVar[str] = (
        "The samples are those of a search, which are dense where it searched: correlations and widths reflect its "
        "path as well as the data. Only the lower envelope is free of this."
    )

    @property
    @abstractmethod
    def least(self) -> tuple[int, str]:
        """How many evaluations a generation has at least, and what they are called."""

    def stopping_issues(self, stopping: Stopping) -> list[Issue]:
        """It needs a criterion, and a generation must fit."""
        least, name = self.least
        if stopping.is_empty:
            criteria = [part for key in type(stopping).model_fields for part in (", ", setting(f"stopping.{key}"))]
            return [Issue.about("stopping", (f"a {self.title} needs at least one criterion: ", *criteria[1:]))]
        most = stopping.max_evaluations
        if most is not None and most < least:
            message = f"must be at least the number of {name} ({least}), got {most}"
            return [Issue("stopping.max_evaluations", message)]
        return []


class FollowUpMethod(Method):
    """A method that examines an optimum, or the space around it, by planned evaluations."""

    role: ClassVar[Role] = "follow_up"
    bias: ClassVar[str] = (
        "The evaluations are planned positions of a follow-up, neither sampled nor searched: their correlations and "
        "widths describe the plan. Their purpose is described under uncertainty."
    )

    compares: ClassVar[bool] = True
    """Whether its evaluations are compared with readings, so that objectives mean something."""

    if TYPE_CHECKING:  # each declares the field at its place in the section
        of: str | None

    def end_reason(self, search: Search, evaluations: int, *, over: bool) -> str | None:  # noqa: ARG002  others need it
        """It ends with its design."""
        return DESIGN_COMPLETED if over else None

    def issues_at(self, at: Mapping[str, float], problem: Problem) -> list[Issue]:
        """Return why values ``at`` of all free parameters do not fit the problem, or its measurements are too few."""
        free = problem.free
        names = [p.name for p in free]
        issues = []
        if set(at) != set(names):
            message = f"must name the free parameters {', '.join(names)}, got {', '.join(at)}"
            issues.append(Issue("method.at", message))
        for parameter in free:
            value = at.get(parameter.name, parameter.lower)
            if not parameter.lower <= value <= parameter.upper:
                bounds = f"between the bounds {parameter.lower:g} and {parameter.upper:g}"
                issues.append(Issue(f"method.at.{parameter.name}", f"must be {bounds}, got {value:g}"))
        issues += self.further_issues(names)
        points = sum(int((o.point_weights > 0).sum()) for o in problem.observations if o.weight > 0)
        if points < len(names):
            message = (
                f"{points} measured point{'' if points == 1 else 's'} cannot determine {len(names)} free parameters "
                f"({', '.join(names)}); fix or link some of them, or add measurements"
            )
            issues.append(Issue("method", message))
        if not issues and not problem.satisfies(problem.values([at[name] for name in names])):
            issues.append(Issue("method.at", "does not satisfy the constraints, or the limits of the forward model"))
        return issues

    def further_issues(self, free: list[str]) -> list[Issue]:  # noqa: ARG002  others need it
        """Return what else does not fit the names of the free parameters."""
        return []


def by_name(space: SearchSpace, values: FloatArray) -> dict[str, float]:
    """Return values in the order of a space, shape (d,), by name: the inverse of :func:`in_order`."""
    return dict(zip(space.names, values.tolist(), strict=True))


def in_order(space: SearchSpace, values: Mapping[str, float], missing: float | None = None) -> FloatArray:
    """Return values by name in the order of a space, shape (d,).

    Raises
    ------
    KeyError
        When a value is missing and ``missing`` is None.
    """
    if missing is None:
        return np.array([values[name] for name in space.names], dtype=np.float64)
    return np.array([values.get(name, missing) for name in space.names], dtype=np.float64)
