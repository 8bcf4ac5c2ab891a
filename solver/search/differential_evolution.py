"""Differential evolution as Storn and Price (1997) give it: DE/rand/1/bin, one trial a member and generation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.determinism import particle_generator
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["DifferentialEvolution", "EvolutionSettings"]

_HALVINGS = 30  # of a step that ends where no point is feasible


@dataclass(frozen=True, slots=True)
class EvolutionSettings:
    """Control variables, with the names of Storn and Price.

    Parameters
    ----------
    members
        NP, number of members of the population, at least 4.
    weight
        F, factor of the difference between two members.
    crossover
        CR, probability that a trial takes a parameter of the mutant.
    """

    members: int
    weight: float = 0.5
    crossover: float = 0.9


class DifferentialEvolution:
    """Ask / tell differential evolution in search coordinates.

    Generation 0 are the members, drawn until feasible. Later ones are trials: for member i, with three others a, b, c,
    the mutant x_a + F (x_b - x_c) gives each parameter with probability CR, and one in any case; the other parameters
    are those of the member. A trial that is not worse takes the member's place. Of a trial beyond a bound the
    parameter is mirrored there; one that violates a constraint is moved halfway to its member until it does not.

    Parameters
    ----------
    space, settings
        Where and how to search.
    seed
        Together with generation and member it fixes every random number.
    initial
        The user's estimate, natural values, shape (d,), nan where not given; becomes member 0.

    Raises
    ------
    InfeasibleSpaceError
        When no feasible member is found.
    """

    def __init__(
        self, space: SearchSpace, settings: EvolutionSettings, seed: int, initial: FloatArray | None = None
    ) -> None:
        self._space, self._settings, self._seed = space, settings, seed
        self.generation = 0
        given = [initial, *[None] * (settings.members - 1)]
        self._trials = np.array([space.draw(particle_generator(seed, 0, i), at) for i, at in enumerate(given)])
        self._members = self._trials.copy()
        self._objectives = np.full(settings.members, np.inf)

    @classmethod
    def restore(
        cls, space: SearchSpace, settings: EvolutionSettings, seed: int, snapshot: Snapshot
    ) -> DifferentialEvolution:
        """Rebuild the search from ``snapshot``; it continues bit for bit alike."""
        search = cls.__new__(cls)
        search._space, search._settings, search._seed = space, settings, seed
        search.generation = snapshot["generation"]
        search._trials = np.array(snapshot["trials"])
        search._members = np.array(snapshot["members"])
        search._objectives = np.array([np.inf if f is None else f for f in snapshot["objectives"]])
        return search

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able; an objective not yet known is None."""
        return {
            "generation": self.generation,
            "trials": self._trials.tolist(),
            "members": self._members.tolist(),
            "objectives": [f if np.isfinite(f) else None for f in self._objectives.tolist()],
        }

    def ask(self) -> FloatArray:
        """Positions of the current generation, shape (members, d), natural values."""
        return self._space.to_natural(self._trials)

    def tell(self, objectives: FloatArray, runs: Runs | None = None) -> None:  # noqa: ARG002  (it does not learn)
        """Take the objectives of the trials, shape (members,); make the trials of the next generation."""
        if objectives.shape != self._objectives.shape:
            raise ValueError(f"objectives has shape {objectives.shape}, expected {self._objectives.shape}")
        taken = objectives <= self._objectives
        self._members = np.where(taken[:, None], self._trials, self._members)
        self._objectives = np.where(taken, objectives, self._objectives)
        self.generation += 1
        self._trials = np.array([self._trial(member) for member in range(len(self._members))])

    def _trial(self, member: int) -> FloatArray:
        """Return the trial of a member, shape (d,)."""
        random = particle_generator(self._seed, self.generation, member)
        x, dimension = self._members, self._space.dimension
        others = [i for i in range(len(x)) if i != member]
        a, b, c = random.choice(others, 3, replace=False)
        crossed = random.random(dimension) < self._settings.crossover
        crossed[random.integers(dimension)] = True
        trial = np.where(crossed, x[a] + self._settings.weight * (x[b] - x[c]), x[member])
        return self._kept(trial, x[member])

    def _kept(self, trial: FloatArray, member: FloatArray) -> FloatArray:
        """Move a trial inside the bounds and to where it is feasible."""
        lower, upper = self._space.search_lower, self._space.search_upper
        trial = np.where(trial < lower, 2.0 * lower - trial, np.where(trial > upper, 2.0 * upper - trial, trial))
        trial = np.clip(trial, lower, upper)
        for _ in range(_HALVINGS):
            if self._space.is_feasible(trial):
                return trial
            trial = 0.5 * (trial + member)
        return member.copy()
