"""Differential evolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.methods.base import Maker, SearchMethod, Task

if TYPE_CHECKING:
    from geoswarm.solver.search.base import Snapshot
    from geoswarm.solver.search.differential_evolution import DifferentialEvolution, EvolutionSettings

__all__ = ["DifferentialEvolutionMethod"]


class DifferentialEvolutionMethod(SearchMethod):
    """Differential evolution (Storn and Price 1997, DE/rand/1/bin): robust, for rough objectives and many runs."""

    title: ClassVar[str] = "differential evolution"

    kind: Literal["differential_evolution"] = "differential_evolution"
    members: int | None = Field(
        None, ge=4, le=1000, description="NP, evaluations in a generation; 10 for each free parameter if absent"
    )
    weight: float = Field(0.5, gt=0, le=2, description="F, factor of the difference between two members")
    crossover: float = Field(
        0.9, ge=0, le=1, description="CR, probability that a trial takes a parameter of the mutant"
    )

    @property
    def least(self) -> tuple[int, str]:
        """Members."""
        return (4 if self.members is None else self.members), "members"

    def in_words(self) -> str:
        """Control variables."""
        count = "10 members a free parameter" if self.members is None else f"{self.members} members"
        return f"differential evolution (DE/rand/1/bin, F = {self.weight:g}, CR = {self.crossover:g}), {count}"

    def maker(self, task: Task) -> Maker:
        """Prepare to make the search of a job."""
        return _EvolutionMaker(self, task)


@dataclass(frozen=True, slots=True)
class _EvolutionMaker:
    method: DifferentialEvolutionMethod
    task: Task

    def start(self, slots: int) -> DifferentialEvolution:  # noqa: ARG002  (the form of all makers)
        from geoswarm.solver.search.differential_evolution import DifferentialEvolution

        return DifferentialEvolution(self.task.space, self._settings(), self.task.seed, self.task.initial)

    def restore(self, snapshot: Snapshot) -> DifferentialEvolution:
        from geoswarm.solver.search.differential_evolution import DifferentialEvolution

        return DifferentialEvolution.restore(self.task.space, self._settings(), self.task.seed, snapshot)

    def _settings(self) -> EvolutionSettings:
        from geoswarm.solver.search.differential_evolution import EvolutionSettings

        members = self.method.members or min(10 * self.task.space.dimension, 1000)
        return EvolutionSettings(members, self.method.weight, self.method.crossover)
