"""What follows a search: the runs that its result needs, down to the minimum and around it.

Part of the job, in generations of their own, planned from what is stored; bounded by the section ``answer`` of the
problem. The search keeps its state, so that a job can go on searching afterwards.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.minimum import MinimumSearch

if TYPE_CHECKING:
    from geoswarm.solver.arrays import FloatArray
    from geoswarm.solver.search.space import SearchSpace

__all__ = ["Answer"]


@dataclass(frozen=True, slots=True)
class Answer:
    """The state of the runs after a search.

    Parameters
    ----------
    start
        Where they begin: the best evaluation of the search, shape (d,), natural values.
    objective
        f there.
    generation, evaluations
        Number of the first generation, and evaluations before it.
    most
        Largest number of evaluations.
    reasons
        Why the search ended.
    search
        State of the search with its next generation, as :meth:`geoswarm.solver.progress.Progress.to_json` writes it.
    snapshot
        State of these runs.
    """

    start: FloatArray
    objective: float
    generation: int
    evaluations: int
    most: int
    reasons: tuple[str, ...]
    search: Mapping[str, Any]
    snapshot: Snapshot

    def runs(self, space: SearchSpace) -> MinimumSearch:
        """Return the planned runs in their state."""
        return MinimumSearch(space, self.start, self.most, self.snapshot)

    def after(self, runs: MinimumSearch) -> Answer:
        """Return the state after a generation."""
        return replace(self, snapshot=runs.snapshot())
