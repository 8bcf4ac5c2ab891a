"""Monte Carlo sampling of the search space: random, Latin hypercube and Sobol points; and points that are given."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.determinism import design_generator, particle_generator
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["GivenSearch", "MonteCarlo", "MonteCarloSettings", "SamplingDesign"]

_LARGEST_DESIGN = 2**21  # points drawn at most in the search for feasible ones


@dataclass(frozen=True, slots=True)
class MonteCarloSettings:
    """What to sample: number of ``samples``, kind of ``sampling``, and particles a generation (``batch``)."""

    samples: int
    sampling: Literal["random", "latin_hypercube", "sobol"] = "random"
    batch: int = 50


@dataclass(frozen=True)
class SamplingDesign:
    """The points of a Latin hypercube or Sobol sampling, which are drawn as a whole.

    With constraints the feasible points of a larger design are taken in its order: a Latin hypercube is drawn with as
    many more points as the feasible fraction demands (its strata then hold for the bounded box, not for the feasible
    part), a Sobol sequence is continued. Keep one design for all restores of a search: it costs more than a generation.
    """

    space: SearchSpace
    settings: MonteCarloSettings
    seed: int

    @cached_property
    def points(self) -> FloatArray:
        """Points in search coordinates, shape (samples, d), all feasible.

        Raises
        ------
        InfeasibleSpaceError
            When a bounded number of points holds too few feasible ones.
        """
        wanted = self.settings.samples
        size = wanted
        while size <= max(_LARGEST_DESIGN, wanted):
            points = self._draw(size)
            feasible = np.array([self.space.feasible(point) for point in self.space.to_natural(points)])
            if feasible.sum() >= wanted:
                chosen: FloatArray = points[feasible][:wanted]
                return chosen
            size *= 2
        raise InfeasibleSpaceError(
            f"only {int(feasible.sum())} of {len(points)} {self.settings.sampling} points inside the bounds of "
            f"{', '.join(self.space.names)} satisfy the constraints, {wanted} are needed; widen the bounds, relax the "
            "constraints or ask for fewer samples"
        )

    def _draw(self, size: int) -> FloatArray:
        from scipy.stats import qmc  # takes 0.4 s, which a worker of a swarm need not wait for

        random, dimension = design_generator(self.seed), self.space.dimension
        unit: FloatArray
        if self.settings.sampling == "latin_hypercube":
            unit = qmc.LatinHypercube(dimension, rng=random).random(size)
        else:  # the balance of Sobol points needs a power of two
            unit = qmc.Sobol(dimension, rng=random).random_base2(math.ceil(math.log2(size)))
        return self.space.search_lower + unit * (self.space.search_upper - self.space.search_lower)


class MonteCarlo:
    """Ask / tell Monte Carlo sampling; learns nothing from the objectives.

    Random points are drawn for each (generation, particle) until feasible; the others come from ``design``.

    Parameters
    ----------
    space, settings, seed
        Where and what to sample.
    design
        Shared between restores for ``latin_hypercube`` and ``sobol``; made when not given.
    """

    def __init__(
        self, space: SearchSpace, settings: MonteCarloSettings, seed: int, design: SamplingDesign | None = None
    ) -> None:
        self._space = space
        self._settings = settings
        self._seed = seed
        self._design = design or SamplingDesign(space, settings, seed)
        self.generation = 0

    @classmethod
    def restore(
        cls,
        space: SearchSpace,
        settings: MonteCarloSettings,
        seed: int,
        snapshot: Snapshot,
        design: SamplingDesign | None = None,
    ) -> MonteCarlo:
        """Rebuild the sampling from ``snapshot``."""
        sampling = cls(space, settings, seed, design)
        sampling.generation = snapshot["generation"]
        return sampling

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {"generation": self.generation}

    def ask(self) -> FloatArray | None:
        """Positions of the current generation, shape (n, d), natural values; None when all samples are drawn."""
        first = self.generation * self._settings.batch
        count = min(self._settings.batch, self._settings.samples - first)
        if count <= 0:
            return None
        if self._settings.sampling == "random":
            streams = (particle_generator(self._seed, self.generation, i) for i in range(count))
            points = np.array([self._space.draw(random) for random in streams])
        else:
            points = self._design.points[first : first + count]
        return self._space.to_natural(points)

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:  # noqa: ARG002  (it does not learn)
        """Close the current generation."""
        self.generation += 1


class GivenSearch:
    """Points, shape (n, d), natural values, ``batch`` of them in a generation; learns nothing from the objectives."""

    def __init__(self, points: FloatArray, batch: int, snapshot: Snapshot | None = None) -> None:
        self._points, self._batch = points, batch
        self.generation: int = 0 if snapshot is None else snapshot["generation"]

    def ask(self) -> FloatArray | None:
        """Positions of the current generation; None when all points have been asked for."""
        first = self.generation * self._batch
        positions = self._points[first : first + self._batch]
        return positions if len(positions) else None

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:  # noqa: ARG002  (it does not learn)
        """Close the current generation."""
        self.generation += 1

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able."""
        return {"generation": self.generation}
