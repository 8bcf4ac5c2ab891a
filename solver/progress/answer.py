"""What follows a search: the runs that its result needs, down to the minimum and around it.

Part of the job, in generations of their own: one follow-up after the other, planned from what is stored
(:mod:`geoswarm.solver.answering`) and bounded by the section ``answer`` of the problem. The search keeps its state, so
that a job can go on searching afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from geoswarm.solver.methods.base import FollowUpMethod
from geoswarm.solver.methods.registry import find_method
from geoswarm.solver.search.base import Snapshot

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["Answer", "Part"]


@dataclass(frozen=True, slots=True)
class Part:
    """One follow-up.

    Parameters
    ----------
    document
        Section ``method`` of the follow-up.
    generation, evaluations
        Number of its first generation, and evaluations of the job before it.
    snapshot
        State of its search.
    """

    document: Mapping[str, Any]
    generation: int
    evaluations: int
    snapshot: Snapshot

    @property
    def method(self) -> FollowUpMethod:
        """The method of the follow-up."""
        made = find_method(self.document["kind"]).model_validate(self.document)
        assert isinstance(made, FollowUpMethod)
        return made


@dataclass(frozen=True, slots=True)
class Answer:
    """The state of the runs after a search.

    Parameters
    ----------
    most
        Largest number of evaluations.
    objective
        Lowest one of the search.
    reasons
        Why the search ended.
    positions, ahead
        What the search would have asked for next, and ahead of its results: lists, natural values.
    parts
        Follow-ups so far; the last one goes on.
    """

    most: int
    objective: float
    reasons: tuple[str, ...]
    positions: list[list[float]]
    ahead: list[list[float]] | None = None
    parts: tuple[Part, ...] = ()

    @property
    def generation(self) -> int:
        """Number of the first generation."""
        return self.parts[0].generation

    @property
    def evaluations(self) -> int:
        """Evaluations of the search."""
        return self.parts[0].evaluations

    def search_best(self, problem: Problem) -> dict[str, Any]:
        """Return ``objective`` and all ``parameters`` of the best evaluation of the search."""
        at = self.parts[0].document["at"]
        return {"objective": self.objective, "parameters": problem.values([at[name] for name in problem.free_names])}

    def plan(self) -> dict[str, Any]:
        """Return how its evaluations are read, as plain JSON values, without the states of searches."""
        parts = [{key: value for key, value in asdict(part).items() if key != "snapshot"} for part in self.parts]
        return {"most": self.most, "objective": self.objective, "parts": parts}

    @classmethod
    def from_plan(cls, data: Mapping[str, Any]) -> Answer:
        """Restore from :meth:`plan`: for reading alone."""
        parts = tuple(Part(**part, snapshot={}) for part in data["parts"])
        return cls(data["most"], data["objective"], (), [], parts=parts)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Answer:
        """Restore from the plain values of its fields."""
        parts = tuple(Part(**part) for part in data["parts"])
        return cls(**{**data, "reasons": tuple(data["reasons"]), "parts": parts})
