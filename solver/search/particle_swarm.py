"""The synchronous particle swarm of the published study (Meier et al. 2008, Algorithm 1).

One cycle: find each particle's own best and the best of its neighbourhood; new velocity, then new position, for each
particle; the whole generation is evaluated; join; update the bests. After Eberhart & Kennedy (1995); the constriction
form after Clerc & Kennedy (2002), the inertia weight after Shi & Eberhart (1998).

With position x, velocity v, personal best p, neighbourhood best g, r1 and r2 uniform in [0, 1) for each component:

    inertia_weight:  v <- w v + c1 r1 (p - x) + c2 r2 (g - x)
    constriction:    v <- chi (v + c1 r1 (p - x) + c2 r2 (g - x))
                     chi = 2 / |2 - s - sqrt(s^2 - 4 s)|,  s = c1 + c2 > 4
    x <- x + v       all in search coordinates
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import compress
from typing import Literal

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.search.acceleration import Proposer, ProposerState
from geoswarm.solver.search.base import Snapshot
from geoswarm.solver.search.descent.ending import Ending
from geoswarm.solver.search.determinism import one_thread, particle_generator
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["ParticleSwarm", "SwarmSettings"]

_REDRAWS = 20  # of a particle that repeats another; a space of few whole numbers may have no other
_HALVINGS = 40  # a step is halved this often before the particle stays where it was


@dataclass(frozen=True, slots=True)
class SwarmSettings:
    """How the swarm moves.

    Parameters
    ----------
    particles
        Number n of particles in a generation; a restored swarm keeps the number that it has.
    form
        ``constriction`` or ``inertia_weight``, see the module's equations.
    cognitive_coefficient, social_coefficient
        Pull c1 towards the personal best, c2 towards the best of the neighbourhood.
    inertia_weight
        w; used by the inertia-weight form only.
    topology
        ``global``: every particle knows the best of all; ``ring``: its own and its two neighbours' personal bests.
    boundary
        What happens to a component that leaves the bounds. ``reflect``: it is mirrored at the bound and its velocity
        reversed. ``absorb``: it stays at the bound with velocity zero. ``resample``: it is drawn anew between the
        bounds, its velocity zero.
    max_velocity
        Limit of each velocity component as a fraction of the parameter's range in search coordinates.
    acceleration
        ``none``: the textbook swarm. ``response_surface``: the worst particles of a generation are aimed at points that
        all runs so far promise (:mod:`geoswarm.solver.search.acceleration`).
    polish
        An accelerated swarm that would restart goes down from its best particle by least squares instead, and ends.
    """

    particles: int = 10
    form: Literal["constriction", "inertia_weight"] = "constriction"
    cognitive_coefficient: float = 2.05
    social_coefficient: float = 2.05
    inertia_weight: float = 0.7298
    topology: Literal["global", "ring"] = "global"
    boundary: Literal["reflect", "absorb", "resample"] = "reflect"
    max_velocity: float = 0.5
    acceleration: Literal["none", "response_surface"] = "none"
    polish: bool = False

    @property
    def weights(self) -> tuple[float, float, float]:
        """Factors of the old velocity, the cognitive and the social term."""
        c1, c2 = self.cognitive_coefficient, self.social_coefficient
        if self.form == "inertia_weight":
            return self.inertia_weight, c1, c2
        s = c1 + c2
        chi = 2.0 / abs(2.0 - s - math.sqrt(s * s - 4.0 * s))
        return chi, chi * c1, chi * c2


@dataclass(frozen=True, slots=True)
class _Moves:
    """Where particles go and how fast, search coordinates, both of shape (n, d)."""

    position: FloatArray
    velocity: FloatArray


class ParticleSwarm:
    """Ask / tell particle swarm.

    Every proposal satisfies bounds and constraints, the first included: the initial positions are drawn until feasible;
    later a step that ends at an infeasible point is halved towards the particle's previous position, which is feasible.
    While no particle of a neighbourhood has had a successful evaluation its particles are drawn anew.
    Of equal bests the particle with the lowest index counts.

    Parameters
    ----------
    space, settings
        Where and how to move.
    seed
        Together with generation and particle it fixes every random number.
    initial
        The user's estimate, natural values, shape (d,), nan where not given; becomes particle 0.
    offered
        Runs of earlier jobs; an accelerated swarm aims its first generation by them, and runs the best of them again.

    Raises
    ------
    InfeasibleSpaceError
        When no feasible initial position is found.
    """

    def __init__(
        self,
        space: SearchSpace,
        settings: SwarmSettings,
        seed: int,
        initial: FloatArray | None = None,
        offered: Runs | None = None,
    ) -> None:
        self._space = space
        self._settings = settings
        self._seed = seed
        self.generation = 0
        n, d = settings.particles, space.dimension
        self._position = np.empty((n, d))
        self._velocity = np.empty((n, d))
        for i in range(n):
            random = particle_generator(seed, 0, i)
            self._position[i], self._velocity[i] = self._draw(random, initial if i == 0 else None)
        self._best_objective = np.full(n, np.inf)
        self._proposer = _proposer(space, settings, seed)
        if self._proposer is not None:
            estimated = initial is not None and not np.isnan(initial).all()
            self._position = self._proposer.first(self._position, keep=int(estimated))
            if offered is not None:
                self._take_offer(self._proposer, offered, first=int(estimated))
        self._separate()
        self._best_position = self._position.copy()
        self._ending: Ending | None = None
        self._ahead: _Moves | None = None

    @classmethod
    def begin_overlapping(
        cls,
        space: SearchSpace,
        settings: SwarmSettings,
        seed: int,
        initial: FloatArray | None = None,
        offered: Runs | None = None,
    ) -> ParticleSwarm:
        """Start with two generations at once: the first, and the next one, which is asked ahead."""
        n = settings.particles
        swarm = cls(space, replace(settings, particles=2 * n), seed, initial, offered)
        swarm._settings = settings
        swarm._ahead = _Moves(swarm._position[n:], swarm._velocity[n:])
        swarm._position, swarm._velocity = swarm._position[:n], swarm._velocity[:n]
        swarm._best_position, swarm._best_objective = swarm._best_position[:n], swarm._best_objective[:n]
        if swarm._proposer is not None:
            swarm._proposer.split(n)
        return swarm

    @classmethod
    def restore(cls, space: SearchSpace, settings: SwarmSettings, seed: int, snapshot: Snapshot) -> ParticleSwarm:
        """Rebuild the swarm from ``snapshot``; it continues bit for bit alike."""
        swarm = cls.__new__(cls)
        swarm._space, swarm._settings, swarm._seed = space, settings, seed
        swarm.generation = snapshot["generation"]
        swarm._position = np.array(snapshot["position"])
        swarm._velocity = np.array(snapshot["velocity"])
        swarm._best_position = np.array(snapshot["best_position"])
        swarm._best_objective = np.array([np.inf if f is None else f for f in snapshot["best_objective"]])
        state = snapshot.get("proposer")  # absent in what earlier versions stored
        swarm._proposer = _proposer(space, settings, seed, None if state is None else ProposerState.from_json(state))
        ending = snapshot.get("ending")
        swarm._ending = None if ending is None else Ending.from_json(ending)
        ahead = snapshot.get("ahead")
        swarm._ahead = None if ahead is None else _Moves(*(np.array(ahead[name]) for name in ("position", "velocity")))
        return swarm

    def snapshot(self) -> Snapshot:
        """State between two generations, JSON-able; an objective not yet known is None."""
        snapshot: Snapshot = {
            "generation": self.generation,
            "position": self._position.tolist(),
            "velocity": self._velocity.tolist(),
            "best_position": self._best_position.tolist(),
            "best_objective": [f if math.isfinite(f) else None for f in self._best_objective.tolist()],
            "proposer": None if self._proposer is None else self._proposer.state.to_json(),
        }
        if self._ending is not None:
            snapshot["ending"] = self._ending.to_json()
        if self._ahead is not None:
            snapshot["ahead"] = {
                "position": self._ahead.position.tolist(),
                "velocity": self._ahead.velocity.tolist(),
            }
        return snapshot

    def ask(self) -> FloatArray | None:
        """Positions of the current generation, shape (n, d), natural values; None when the best is polished."""
        if self._ending is not None:
            return None if self._ending.finished else self._ending.positions(self._space)
        if self._proposer is not None and self._proposer.finished:
            return None
        return self._space.to_natural(self._position)

    def ask_ahead(self) -> FloatArray | None:
        """Positions of the generation after the current one, natural values, if it has been asked for."""
        return None if self._ahead is None else self._space.to_natural(self._ahead.position)

    def tell(
        self,
        objectives: FloatArray,
        runs: Runs | None = None,
        *,
        particles: int | None = None,
        ahead: bool = False,
    ) -> None:
        """Take the objectives of the current generation, shape (n,), and move every particle.

        Parameters
        ----------
        objectives
            f of each particle; inf where its run failed.
        runs
            All evaluations so far; they let an accelerated swarm aim.
        particles
            How many the generation that is asked for now has, as many as the one before it if None: the best stay, new
            ones are drawn. The history depends on it.
        ahead
            Two generations are to be under way from now on: besides the next one the one after it is asked for, which
            knows nothing of the results of the next one. The history depends on it. Only of an accelerated swarm that
            is not polished.
        """
        if self._ending is not None:
            if runs is None:
                raise ValueError("the end of a polished search needs the runs so far")
            with one_thread():
                self._ending = self._ending.advance(self._space, runs)
            self.generation += 1
            return
        if objectives.shape != self._best_objective.shape:
            raise ValueError(f"objectives has shape {objectives.shape}, expected {self._best_objective.shape}")
        better = objectives < self._best_objective
        self._best_objective = np.where(better, objectives, self._best_objective)
        self._best_position = np.where(better[:, None], self._position, self._best_position)
        if self._proposer is not None and runs is not None:
            self._proposer.tell(runs, len(objectives))
        if self._ahead is None:
            self._move_on(runs, particles, None)
        else:
            self._resize(len(self._ahead.position))
            self._position, self._velocity = self._ahead.position, self._ahead.velocity
            self.generation += 1
            self._ahead = None
        if ahead and self._ending is None:
            self._ask_ahead(runs, particles)

    def _ask_ahead(self, runs: Runs | None, particles: int | None) -> None:
        """Ask for the generation after the current one, of which nothing is known yet."""
        if self._proposer is None or self._settings.polish:
            raise ValueError("only an accelerated swarm that is not polished asks ahead")
        beyond = copy(self)
        beyond._move_on(runs, particles, self._position)
        self._ahead = _Moves(beyond._position, beyond._velocity)

    def _move_on(self, runs: Runs | None, particles: int | None, pending: FloatArray | None) -> None:
        """Move every particle; ``pending``: positions of the generation before, where they are out."""
        if particles is not None:
            self._resize(particles)
        self.generation += 1
        before, informants = self._position, self._informants()
        randoms = [particle_generator(self._seed, self.generation, i) for i in range(len(before))]
        led = np.isfinite(self._best_objective[informants])
        position, velocity = np.empty_like(before), np.empty_like(before)
        position[led], velocity[led] = self._moved(led, informants[led], list(compress(randoms, led)))
        for i in np.flatnonzero(~led).tolist():
            position[i], velocity[i] = self._draw(randoms[i], None)
        self._position, self._velocity = position, velocity
        if self._proposer is not None and runs is not None:
            worst_first = np.argsort(-self._best_objective, kind="stable").astype(np.int64)
            aimed = self._proposer.propose(self.generation, self._position, worst_first, runs, pending)
            for i, point in aimed.items():
                self._position[i], self._velocity[i] = point, self._limit(point - before[i])
            if self._proposer.leaving:
                with one_thread():
                    self._ending = Ending.begin(self._space, runs)
                return
        self._separate()

    @property
    def converged(self) -> bool:
        """Whether a polished search ended at a minimum, as far as it can tell."""
        return self._ending is None or self._ending.converged

    def _resize(self, particles: int) -> None:
        """Keep the particles with the best personal bests, or draw more, up to a number."""
        if particles < 1:
            raise ValueError(f"particles must be at least 1, got {particles}")
        n = len(self._position)
        kept = np.sort(np.argsort(self._best_objective, kind="stable")[:particles])
        new = [self._draw(particle_generator(self._seed, self.generation, i), None) for i in range(n, particles)]
        drawn = np.array(new).reshape(-1, 2, self._space.dimension)
        self._position = np.concatenate([self._position[kept], drawn[:, 0]])
        self._velocity = np.concatenate([self._velocity[kept], drawn[:, 1]])
        self._best_position = np.concatenate([self._best_position[kept], drawn[:, 0]])
        self._best_objective = np.concatenate([self._best_objective[kept], np.full(len(drawn), np.inf)])

    def _take_offer(self, proposer: Proposer, offered: Runs, first: int) -> None:
        """Aim generation 0 by offered runs; of the particles from ``first`` on, the first one repeats the best run."""
        if not offered.succeeded.any():
            return
        others = np.arange(len(self._position) - 1, first, -1)
        for i, point in proposer.propose(0, self._position, others, offered).items():
            self._position[i] = point
        best = offered.positions[int(np.argmin(offered.objectives))]
        self._position[first] = self._space.snapped(self._space.to_search(best))

    def _separate(self) -> None:
        """Draw a particle anew that rounds to the same whole numbers as one before it."""
        if not self._space.integer.any():
            return
        n = len(self._position)
        taken: set[bytes] = set()
        for i in range(n):
            random = particle_generator(self._seed, self.generation, n + i)
            for _ in range(_REDRAWS):
                if self._space.to_natural(self._position[i]).tobytes() not in taken:
                    break
                self._position[i], self._velocity[i] = self._draw(random, None)
            taken.add(self._space.to_natural(self._position[i]).tobytes())

    def _informants(self) -> IntArray:
        """Index of the best personal best in the neighbourhood of each particle; the lowest index of equal ones."""
        n = len(self._best_objective)
        if self._settings.topology == "global":
            return np.full(n, np.argmin(self._best_objective))
        neighbours = np.sort((np.arange(n)[:, None] + [-1, 0, 1]) % n, axis=1)
        best: IntArray = neighbours[np.arange(n), np.argmin(self._best_objective[neighbours], axis=1)]
        return best

    def _draw(self, random: np.random.Generator, initial: FloatArray | None) -> tuple[FloatArray, FloatArray]:
        """Draw a feasible position and a velocity: half the way to another random point (Clerc's SPSO 2007)."""
        space = self._space
        position = space.draw(random, initial)
        target = space.search_lower + random.random(space.dimension) * (space.search_upper - space.search_lower)
        return position, self._limit(0.5 * (target - position))

    def _limit(self, velocity: FloatArray) -> FloatArray:
        largest = self._settings.max_velocity * (self._space.search_upper - self._space.search_lower)
        return np.clip(velocity, -largest, largest)

    def _moved(
        self, which: BoolArray, informants: IntArray, randoms: Sequence[np.random.Generator]
    ) -> tuple[FloatArray, FloatArray]:
        """Return new positions and velocities of some particles, both of shape (k, d), in the order of ``which``."""
        x, v, p = self._position[which], self._velocity[which], self._best_position[which]
        g = self._best_position[informants]
        inertia, cognitive, social = self._settings.weights
        drawn = np.array([random.random((2, x.shape[1])) for random in randoms]).reshape(-1, 2, x.shape[1])
        r1, r2 = drawn[:, 0], drawn[:, 1]
        velocity = self._limit(inertia * v + cognitive * r1 * (p - x) + social * r2 * (g - x))
        position = x + velocity
        outside = (position < self._space.search_lower) | (position > self._space.search_upper)
        for i in np.flatnonzero(outside.any(axis=1)).tolist():
            position[i], velocity[i] = self._keep_inside(position[i], velocity[i], randoms[i])
        for i, natural in enumerate(self._space.to_natural(position)):
            if not self._space.feasible(natural):
                position[i], velocity[i] = self._shortened(x[i], position[i] - x[i])
        return position, velocity

    def _shortened(self, start: FloatArray, step: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Halve a step to an infeasible position until one is feasible; return that, and the step, or stay."""
        for _ in range(_HALVINGS):
            step = 0.5 * step
            if self._space.is_feasible(start + step):
                return start + step, step
        return start, np.zeros_like(start)

    def _keep_inside(
        self, position: FloatArray, velocity: FloatArray, random: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Treat the components of a particle that left the bounds as ``boundary`` says."""
        lower, upper = self._space.search_lower, self._space.search_upper
        outside = (position < lower) | (position > upper)
        if self._settings.boundary == "reflect":
            mirrored = np.where(position < lower, 2.0 * lower - position, 2.0 * upper - position)
            position = np.where(outside, mirrored, position)
            velocity = np.where(outside, -velocity, velocity)
            # max_velocity may exceed the range, then one mirror image is outside again
            return np.clip(position, lower, upper), velocity
        if self._settings.boundary == "absorb":
            return np.clip(position, lower, upper), np.where(outside, 0.0, velocity)
        anew = lower + random.random(position.size) * (upper - lower)
        return np.where(outside, anew, position), np.where(outside, 0.0, velocity)


def _proposer(
    space: SearchSpace, settings: SwarmSettings, seed: int, state: ProposerState | None = None
) -> Proposer | None:
    if settings.acceleration == "none":
        return None
    return Proposer(space, seed, state, polish=settings.polish)
