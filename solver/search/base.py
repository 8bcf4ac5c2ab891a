"""The protocol of a search method."""

from __future__ import annotations

from typing import Any, Protocol, TypeAlias

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.runs import Runs

__all__ = ["Search", "Snapshot", "WideSearch"]

Snapshot: TypeAlias = dict[str, Any]
"""State of a search between two generations; JSON-able, restores bit for bit."""


class Search(Protocol):
    """Proposes parameter vectors generation by generation.

    ``ask`` gives the current generation and may be called any number of times; ``tell`` closes it and moves on.
    """

    @property
    def generation(self) -> int:
        """Number of the current generation, counted from 0."""

    def ask(self) -> FloatArray | None:
        """Positions of the current generation, shape (n, d), natural values; None when the method has no more."""

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:
        """Take the objectives of the current generation, shape (n,), in particle order; inf for a failed evaluation.

        ``runs`` are all evaluations so far, the current generation included, for searches that learn from them.
        """

    def snapshot(self) -> Snapshot:
        """State from which the same class restores a search that continues bit for bit alike."""


class WideSearch(Search, Protocol):
    """A search whose generations may have any size, and may overlap."""

    def ask_ahead(self) -> FloatArray | None:
        """Positions of the generation after the current one, if it has been asked for; else None."""

    def tell(
        self, objectives: FloatArray, runs: Runs | None = None, *, particles: int | None = None, ahead: bool = False
    ) -> None:
        """Close the current generation and ask for one of the given size, ``ahead`` of results or not."""
