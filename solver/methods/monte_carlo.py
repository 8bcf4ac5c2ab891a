"""Monte Carlo sampling."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.methods.base import Maker, Method, Role, Task

if TYPE_CHECKING:
    from geoswarm.solver.search.base import Search, Snapshot
    from geoswarm.solver.search.monte_carlo import MonteCarlo

__all__ = ["SAMPLES_COMPLETED", "MonteCarloMethod"]

SAMPLES_COMPLETED = "samples_completed"

LARGEST_DESIGN = 1_000_000
"""Samples that a Latin hypercube or Sobol design may have."""


class MonteCarloMethod(Method):
    """Monte Carlo sampling of the space between the bounds, for the statistics."""

    role: ClassVar[Role] = "sampling"
    title: ClassVar[str] = "Monte Carlo sampling"

    kind: Literal["monte_carlo"] = "monte_carlo"
    samples: int = Field(ge=1, le=10_000_000, description="number of evaluations")
    sampling: Literal["random", "latin_hypercube", "sobol"] = Field("random", description="how the points are chosen")
    batch: int = Field(50, ge=1, le=1000, description="evaluations in a generation")

    @model_validator(mode="after")
    def _design_fits(self) -> MonteCarloMethod:
        if self.sampling != "random" and self.samples > LARGEST_DESIGN:
            raise PydanticCustomError(
                "design",
                "sampling {sampling} draws its points as a whole and takes at most {most} samples, got {samples}; "
                "sampling: random has no such limit",
                {"sampling": self.sampling, "most": LARGEST_DESIGN, "samples": self.samples},
            )
        return self

    @property
    def drawn_at_once(self) -> int:
        """All samples of a design."""
        return 0 if self.sampling == "random" else self.samples

    def planned(self, free: int) -> int | None:  # noqa: ARG002  (the form of all methods)
        """Number of samples."""
        return self.samples

    def in_words(self) -> str:
        """Sampling, number."""
        return f"Monte Carlo sampling ({self.sampling.replace('_', ' ')}), {self.samples} samples"

    def end_reason(self, search: Search, evaluations: int, *, over: bool) -> str | None:  # noqa: ARG002  others need it
        """It ends with its samples."""
        return SAMPLES_COMPLETED if evaluations == self.samples else None

    def maker(self, task: Task) -> Maker:
        """Prepare to make the sampling of a job; no more points than can be evaluated are ever drawn."""
        return _SamplingMaker(self, task)


class _SamplingMaker:
    def __init__(self, method: MonteCarloMethod, task: Task) -> None:
        from geoswarm.solver.search.monte_carlo import MonteCarloSettings, SamplingDesign

        self._task = task
        self._settings = MonteCarloSettings(task.most or method.samples, method.sampling, method.batch)
        self._design = SamplingDesign(task.space, self._settings, task.seed)

    def start(self, slots: int) -> MonteCarlo:  # noqa: ARG002  (the form of all makers)
        from geoswarm.solver.search.monte_carlo import MonteCarlo

        return MonteCarlo(self._task.space, self._settings, self._task.seed, self._design)

    def restore(self, snapshot: Snapshot) -> MonteCarlo:
        from geoswarm.solver.search.monte_carlo import MonteCarlo

        return MonteCarlo.restore(self._task.space, self._settings, self._task.seed, snapshot, self._design)
