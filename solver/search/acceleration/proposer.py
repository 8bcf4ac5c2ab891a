"""Re-aims some particles of a generation at points that all runs so far make promising.

The proposer goes through a pattern of strategies and takes one point from each until its share of the generation is
used; the other particles move as in a textbook swarm. Its share shrinks while its proposals do not pay and grows when
they do; where residuals are known it aims all particles, and a trust region limits how far (``descending``).
It is a pure function of the seed, the generation, the history and its own JSON-able state.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.search.acceleration.basins import Basins
from geoswarm.solver.search.acceleration.candidates import Strategies
from geoswarm.solver.search.acceleration.covariance import CovarianceMoves
from geoswarm.solver.search.acceleration.descending import base_of_simplex, next_of_descent, simplex
from geoswarm.solver.search.acceleration.knowledge import Knowledge, selection
from geoswarm.solver.search.acceleration.proposer_state import MOST_SHARE, Later, Polishing, ProposerState
from geoswarm.solver.search.acceleration.strategies import (
    BEGIN_PATTERN,
    COVARIANCE,
    DESCENT_PATTERN,
    FAR,
    LATE_BEGIN_PATTERN,
    LATE_DESCENT_PATTERN,
    NEAR,
    PARTLY,
    RESTARTED_PATTERN,
    SCALAR_PATTERN,
    STEP,
    VECTOR_PATTERN,
    Pattern,
    Strategy,
    polish_pattern,
)
from geoswarm.solver.search.acceleration.trust_region import TrustRegion
from geoswarm.solver.search.determinism import one_thread, proposer_generator
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Proposer", "ProposerState"]

FIRST_DRAWS = 40
LEAST_SHARE = 0.4
PATIENCE, SCALAR_PATIENCE = 3, 6
LATE = 6  # runs for each slope of a surface from which it is searched around runs, too
NARROW = 8  # particles up to which a generation has no room for that, and below which patience is counted in these
CLOSE = 0.02  # half the width of the box around the end of a descent, of which the place is well known
NEIGHBOURS, MOST_FAILED = 5, 0.7
LONG = 20  # runs for each slope of a surface, after which a descent that goes on is left to least squares, if polished


class Proposer:
    """Proposes points for particles of a swarm.

    Parameters
    ----------
    space, seed
        Where, and what fixes the random numbers together with the generation.
    state
        Of an earlier proposer that this one goes on from.
    polish
        Where a basin is finished: polish the best of all and end, instead of a restart; with residuals that is left to
        others (:attr:`leaving`).
    """

    def __init__(
        self, space: SearchSpace, seed: int, state: ProposerState | None = None, *, polish: bool = False
    ) -> None:
        self._polish = polish
        self.leaving = False
        """A basin is finished and residuals are known: the search may end with least squares."""
        self.state = state or ProposerState()
        self._space = space
        self._seed = seed
        self._lower = space.search_lower
        self._range = space.search_upper - space.search_lower

    @property
    def finished(self) -> bool:
        """Whether the best is polished, where only the objective is known."""
        return self.state.polishing is not None and self.state.polishing.done

    def first(self, drawn: FloatArray, keep: int) -> FloatArray:
        """Return the first generation: a simplex of d + 1 runs, as far as they are that many, then spread-out ones.

        Each of the others is the farthest of 40 random points from those before it.

        Parameters
        ----------
        drawn
            Feasible search coordinates, shape (n, d).
        keep
            This number of the first stay as they are (the user's estimate).
        """
        random = proposer_generator(self._seed, 0)
        chosen = list(self._unit(drawn[: max(keep, 1)]))
        if not keep:
            chosen = [base_of_simplex(random, chosen[0], self._snapped, self._feasible)]
        chosen += simplex(random, chosen[0], self._snapped, self._feasible)[: len(drawn) - 1]
        for fallback in self._unit(drawn[len(chosen) :]):
            draws = [u for u in random.random((FIRST_DRAWS, fallback.size)) if self._feasible(u)]
            points = np.array([*draws, fallback])
            nearest = ((points[:, None, :] - np.array(chosen)[None]) ** 2).sum(axis=2).min(axis=1)
            chosen.append(points[int(np.argmax(nearest))])
        return self._search(np.array(chosen))

    def split(self, count: int) -> None:
        """The first generation was asked together with the next one, which begins at particle ``count``."""
        state = self.state
        later = {particle - count: strategy for particle, strategy in state.aimed.items() if particle >= count}
        aimed = {particle: strategy for particle, strategy in state.aimed.items() if particle < count}
        self.state = replace(state, aimed=aimed, later=Later(later, state.region.promised, count))

    def tell(self, runs: Runs, count: int) -> None:
        """Learn what became of the generation that was asked first of those that were out.

        Parameters
        ----------
        runs
            All evaluations so far; the last ``count`` of them are that generation, in particle order.
        """
        with one_thread():
            state = self.state
            moves = self._tell_covariance(runs.positions[-count:], runs.objectives[-count:])
            steps = [particle for particle, strategy in state.aimed.items() if strategy.startswith("trust")]
            every = self._unit(self._space.to_search(runs.positions))
            region = state.region.after(every, runs.objectives, count, steps, state.unseen)
            later = state.later or Later({}, None, 0)
            self.state = replace(
                state,
                covariance=None if moves is None else moves.state(),
                region=replace(region, promised=later.promised),
                aimed=later.aimed,
                unseen=later.unseen,
                later=None,
            )

    def propose(
        self,
        generation: int,
        moved: FloatArray,
        worst_first: IntArray,
        runs: Runs,
        pending: FloatArray | None = None,
    ) -> dict[int, FloatArray]:
        """Return where particles are aimed instead of where the swarm moved them, search coordinates by particle.

        Parameters
        ----------
        generation
            Number of the generation to come.
        moved
            Search coordinates that the swarm gave it, shape (n, d). A particle that would repeat a run is aimed too.
        worst_first
            Particles in the order in which they are aimed.
        runs
            All evaluations so far. Before the first generation: those that earlier jobs offer.
        pending
            Search coordinates of the generation before this one where it is out, shape (m, d): it is asked ahead.
        """
        with one_thread():
            return self._propose(generation, moved, worst_first, runs, pending)

    def _propose(
        self, generation: int, moved: FloatArray, worst_first: IntArray, runs: Runs, pending: FloatArray | None
    ) -> dict[int, FloatArray]:
        objectives = runs.objectives
        covariance = None if self.state.covariance is None else CovarianceMoves(self.state.covariance)
        every = self._unit(self._space.to_search(runs.positions))
        region = replace(self.state.region, promised=None)
        order = np.argsort(objectives, kind="stable")[: int(runs.succeeded.sum())]
        if order.size < 1:
            self.state = self._asked(self.state, {}, None, pending)
            return {}
        out = np.empty((0, moved.shape[1])) if pending is None else self._unit(pending)
        taken_before = set(map(bytes, self._space.to_natural(pending))) if pending is not None else set[bytes]()
        before = self.state.basins
        chosen = order[selection(before.open_runs(every[order]))]
        known, values, residuals = every[chosen], objectives[chosen], runs.residuals(chosen)
        scalar = residuals.shape[1] == 1 and bool((residuals >= 0.0).all() or (residuals <= 0.0).all())
        whole = bool(self._space.integer.any())
        # responses jump between whole numbers: no descent follows them. Else one ends by its trust region
        descending = not (scalar or whole)
        if descending:
            basins = replace(before, radius=CLOSE)
        else:
            patience = (SCALAR_PATIENCE if scalar else PATIENCE) * -(-NARROW // len(moved))
            basins = before.after(every[order], objectives[order], patience)
        polishing = self.state.polishing
        if polishing is not None:
            polishing = polishing.after(float(objectives[order[0]]))
        elif self._polish and basins.restarts > before.restarts:
            if not scalar:
                self.leaving = True
                return {}
            polishing = Polishing(float(objectives[order[0]]))
        if polishing is not None:
            basins = before  # it stays where it is
        failed = every[~runs.succeeded]

        def strategies_with(basins: Basins) -> Strategies:
            open_ = basins.open_runs(known)

            def admissible(point: FloatArray) -> bool:
                return (
                    basins.admits(point, known, open_)
                    and self._feasible(point)
                    and not self._likely_to_fail(point, every, failed)
                    and not self._repeats(self._search(point), runs, taken_before)
                )

            knowledge = Knowledge(
                known, values, residuals, open_, every, admissible, self._snapped, self._space.integer, chosen
            )
            return Strategies(
                knowledge, proposer_generator(self._seed, generation), covariance, region, taken=[*out], out=len(out)
            )

        strategies = strategies_with(basins)
        hold_out = None if scalar or polishing else strategies.unexplained
        share = 1.0 if polishing or descending else self._share(basins)
        slots = max(1, round(share * len(moved)))
        repeated = [i for i in worst_first[slots:].tolist() if self._repeats(moved[i], runs, taken_before)]
        if polishing:
            pattern = polish_pattern(len(moved))
        elif descending:
            descent = next_of_descent(strategies, len(every) + len(out))
            long = generation > 0 and len(every) >= LONG * (known.shape[1] + 1)
            if self._polish and (descent.left is not None or long):
                self.leaving = True
                return {}
            if descent.left is not None:
                basins = basins.left(descent.left)
                strategies = strategies_with(basins)
            strategies.region, pattern = descent.region, descent.pattern
            partly = pattern == BEGIN_PATTERN and self._partly(basins, strategies.region, known.shape[1])
            if order.size >= LATE * (known.shape[1] + 1) and len(moved) > NARROW:
                pattern = {DESCENT_PATTERN: LATE_DESCENT_PATTERN, BEGIN_PATTERN: LATE_BEGIN_PATTERN}.get(
                    pattern, pattern
                )
            if partly:
                pattern = tuple(PARTLY if strategy == FAR else strategy for strategy in pattern)
        elif scalar:
            pattern = SCALAR_PATTERN
        else:
            pattern = self._whole_pattern(basins, generation)
            pattern = tuple(strategy for k, a in enumerate(pattern) for strategy in ((a, STEP) if k % 3 == 1 else (a,)))
        proposals = self._fill(strategies, pattern, slots + len(repeated), 0 if descending else generation)
        # in particle order, so that the most promising runs come first where runs go one by one
        particles = sorted([*worst_first[:slots].tolist(), *repeated])
        aimed = dict(zip(particles, proposals, strict=False))
        state = replace(
            self.state,
            share=self.state.share if polishing else share,
            basins=basins,
            covariance=None if strategies.covariance is None else strategies.covariance.state(),
            polishing=polishing,
            hold_out=hold_out,
            region=replace(strategies.region, promised=self.state.region.promised),
        )
        names = {particle: str(strategy) for particle, (strategy, _) in aimed.items()}
        self.state = self._asked(state, names, strategies.promised, pending)
        return {particle: point for particle, (_, point) in aimed.items()}

    @staticmethod
    def _asked(
        state: ProposerState, aimed: Mapping[int, str], promised: float | None, pending: FloatArray | None
    ) -> ProposerState:
        """Note what was asked: as the generation under evaluation, or as the one after it."""
        if pending is None:
            return replace(state, aimed=aimed, region=replace(state.region, promised=promised), unseen=0)
        return replace(state, later=Later(aimed, promised, len(pending)))

    def _fill(
        self, strategies: Strategies, pattern: Pattern, slots: int, generation: int
    ) -> list[tuple[Strategy, FloatArray]]:
        # a generation shorter than the pattern continues where the one before stopped: every strategy has its turn
        first = 0 if 2 * slots >= len(pattern) else (generation * slots) % len(pattern)
        proposals: list[tuple[Strategy, FloatArray]] = []
        while len(proposals) < slots:
            before = len(proposals)
            for wanted in (*pattern[first:], *pattern[:first]):
                if len(proposals) == slots:
                    break
                strategy, point = wanted, strategies.take(wanted)
                if point is None:
                    strategy, point = NEAR, strategies.take(NEAR)
                if point is not None:
                    proposals.append((strategy, self._search(point)))
            if len(proposals) == before:
                break
        return proposals

    @staticmethod
    def _partly(basins: Basins, region: TrustRegion, d: int) -> bool:
        """Whether a descent begins at points that share some parameters with the best of all.

        The more parameters there are, the more often: far points can cover a space of few dimensions only.
        """
        return basins.restarts > 0 and bool(np.random.default_rng(region.since).random() < 1.0 - 2.0 / d)

    @staticmethod
    def _whole_pattern(basins: Basins, generation: int) -> Pattern:
        """Strategies with whole numbers: after a restart the residuals have misled once, so every other generation uses
        the objective alone."""
        if basins.restarts:
            return RESTARTED_PATTERN if generation % 2 == 0 else SCALAR_PATTERN
        return VECTOR_PATTERN

    def _share(self, basins: Basins) -> float:
        """It grows with a worthwhile decrease of the objective; without one the swarm takes over step by step."""
        if self.state.basins.best is None and basins.restarts == 0:
            return self.state.share  # the first generation shows nothing yet
        if basins.gained:
            return min(MOST_SHARE, 1.5 * self.state.share)
        return max(LEAST_SHARE, 0.9 * self.state.share)

    def _tell_covariance(self, asked: FloatArray, objectives: FloatArray) -> CovarianceMoves | None:
        if self.state.covariance is None:
            return None
        moves = CovarianceMoves(self.state.covariance)
        points = self._unit(self._space.to_search(asked))
        for particle, strategy in self.state.aimed.items():
            if strategy == str(COVARIANCE):
                moves.tell(points[particle], float(objectives[particle]))
        return None if moves.exhausted else moves

    def _repeats(self, point: FloatArray, runs: Runs, out: Collection[bytes]) -> bool:
        """Whether a point has been evaluated, or is out."""
        natural = self._space.to_natural(point)
        return natural.tobytes() in out or bool((runs.positions == natural).all(axis=1).any())

    @staticmethod
    def _likely_to_fail(point: FloatArray, every: FloatArray, failed: FloatArray) -> bool:
        """Whether most of the nearest evaluations failed, the nearer the weightier."""
        if not len(failed):
            return False
        distances = np.sqrt(((every - point) ** 2).sum(axis=1))
        bad = np.sqrt(((failed - point) ** 2).sum(axis=1))
        reach = np.partition(distances, min(NEIGHBOURS, len(distances)) - 1)[min(NEIGHBOURS, len(distances)) - 1]
        weigh = 1.0 / (distances[distances <= reach] + 1e-9)
        return float((1.0 / (bad[bad <= reach] + 1e-9)).sum()) > MOST_FAILED * float(weigh.sum())

    def _feasible(self, point: FloatArray) -> bool:
        return self._space.is_feasible(self._search(point))

    def _snapped(self, unit: FloatArray) -> FloatArray:
        return self._unit(self._space.snapped(self._search(unit))) if self._space.integer.any() else unit

    def _unit(self, search: FloatArray) -> FloatArray:
        return (search - self._lower) / self._range

    def _search(self, unit: FloatArray) -> FloatArray:
        return self._lower + unit * self._range
