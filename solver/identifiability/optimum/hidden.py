"""Where a basin like that of the optimum could still hide: what no run has come near, or where runs were left alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.identifiability.optimum.linearisation import Linearisation
from geoswarm.solver.identifiability.samples import Samples
from geoswarm.solver.search.space import SearchSpace

__all__ = ["Unseen", "hidden_share", "is_sparse", "places"]

_POINTS = 2000
_DRAWS = 10  # times as many points at most in the search for feasible ones
_EARLY, _MOST_EARLY = 0.25, 100  # part of the history, and runs at most: a long swarm has chosen its place by then
_REACH = 0.5  # of the rise to an ordinary run: one that is lower stands out
_UNEXPLAINED = 0.25  # of the rise that the basin of the optimum has there
_APART = 0.1  # parts of the range to the nearest better run, in the head of a basin
_MOST_HEADS = 50  # that are looked at
_SPARSE = 0.1  # of the space
_FEWEST_AROUND = 5  # runs around a head that show that it goes no lower


@dataclass(frozen=True)
class Unseen:
    """How far a basin like that of the optimum reaches, and which places no run has come near.

    A basin like this one has the curvature of the optimum, f - f_best = |F'u|^2 with u in parts of the range, and
    reaches half as high as an ordinary run of the time when the search had not chosen a place yet: the median of the
    first quarter of the history, or of its first 100 runs if these are fewer. A run inside would have stood out. A
    narrower basin may hide anywhere.

    Parameters
    ----------
    factor
        F, shape (d, d).
    reach
        Largest rise of the objective inside a basin.
    runs
        All that was looked at, parts of the range, shape (n, d); the optimum is the first.
    rises
        Of their objectives above that of the optimum, shape (n,).
    best
        Objective of the optimum.
    made
        This number of runs, the last ones, looked for basins.
    """

    factor: FloatArray
    reach: float
    runs: FloatArray
    rises: FloatArray
    best: float
    made: int = 0

    @classmethod
    def of(
        cls,
        samples: Samples,
        linearisation: Linearisation,
        best: float,
        further: Sequence[tuple[FloatArray, float]] = (),
    ) -> Unseen:
        """Look at successful runs; what failed was not looked at.

        Parameters
        ----------
        best
            Objective at the optimum.
        further
            Parameters, natural values, and objectives of runs that are not among the samples.
        """
        order = np.lexsort((samples.particles, samples.generations))
        early = samples.objectives[order[: max(min(int(_EARLY * samples.size), _MOST_EARLY), 1)]]
        reach = max(_REACH * (float(np.median(early)) - best), 0.0)
        others = [samples.to_unit(p)[None] for p, _ in further]
        runs = np.concatenate([samples.to_unit(linearisation.optimum)[None], samples.unit, *others])
        rises = np.concatenate([[best], samples.objectives, [f for _, f in further]]) - best
        factor = np.asarray(np.linalg.qr(linearisation.model.weighted, mode="r"), dtype=np.float64).T
        return cls(factor, reach, runs, rises, best, len(further))

    def distances(self, unit: FloatArray) -> FloatArray:
        """Distance to the nearest run over the reach of a basin, of places (k, d), parts of the range, shape (k,)."""
        nearest = cKDTree(self.runs @ self.factor).query(unit @ self.factor)[0]
        return np.asarray(nearest / np.sqrt(max(self.reach, np.finfo(float).tiny)))

    def hides(self, unit: FloatArray) -> BoolArray:
        """Whether a basin could hide around places (k, d), parts of the range, shape (k,)."""
        return np.asarray(self.distances(unit) > 1.0)

    def unfinished(
        self, found: float, looked: Sequence[FloatArray] = (), *, height: float = 1.0, made: bool = False
    ) -> IntArray:
        """Rows of ``runs`` that point to another, unexplored basin, the best first.

        Such a run has no better one within a tenth of the ranges (nearest-better clustering, Preuss 2010). It is lower
        than ordinary runs, and much lower than the basins that are known are there. Many runs close around, none of
        them better, say that it does not lead as low as the optimum: if it did, some would lie on the way there.

        Parameters
        ----------
        found
            Rise up to which a run counts as another fit, and is reported as one.
        looked
            Other basins that are known: where descents have begun or ended, parts of the range, each of shape (d,).
        height
            Rise up to which a run points to a basin, over the reach of one.
        made
            Whether runs count that were made to look for basins, which went down where it was worth it.
        """
        moved = self.runs @ self.factor
        known = np.concatenate([moved[:1], *(place[None] @ self.factor for place in looked)])
        expected = cdist(moved, known, "sqeuclidean").min(axis=1)
        strange = (self.rises > found) & (self.rises < np.minimum(height * self.reach, _UNEXPLAINED * expected))
        if self.made and not made:
            strange[-self.made :] = False
        left = np.flatnonzero(strange)
        left = left[np.argsort(self.rises[left], kind="stable")]
        heads: list[int] = []
        for _ in range(_MOST_HEADS):
            if not left.size:
                break
            head, place = int(left[0]), self.runs[left[0]]
            left = left[np.abs(self.runs[left] - place).max(axis=1) > _APART]
            better = self.runs[self.rises < self.rises[head]]
            if np.abs(better - place).max(axis=1).min() <= _APART:
                continue
            around = int((((moved - moved[head]) ** 2).sum(axis=1) <= _UNEXPLAINED * self.rises[head]).sum()) - 1
            if around >= max(2 * len(place), _FEWEST_AROUND):
                continue
            heads.append(head)
        return np.array(heads, dtype=np.int64)

    def places_of(self, space: SearchSpace, rows: IntArray) -> list[tuple[FloatArray, float]]:
        """Parameters, shape (d,), natural values, and objectives of some of the runs."""
        return list(zip(space.from_unit(self.runs[rows]), (self.best + self.rises[rows]).tolist(), strict=True))


def places(space: SearchSpace, count: int, seed: int = 0) -> FloatArray:
    """Random places that satisfy the constraints, parts of the range, shape (at most count, d); always the same."""
    random = np.random.default_rng(seed)
    found: list[FloatArray] = []
    for _ in range(_DRAWS):
        drawn = random.random((count, space.dimension))
        found += [unit for unit, place in zip(drawn, space.from_unit(drawn), strict=True) if space.feasible(place)]
        if len(found) >= count:
            break
    return np.array(found[:count]).reshape(-1, space.dimension)


def is_sparse(hidden: float | None) -> TypeGuard[float]:
    """Whether another basin could hide in so much of the space that "identified" is said of one basin only."""
    return hidden is not None and hidden > _SPARSE


def hidden_share(space: SearchSpace, unseen: Unseen, unfinished: IntArray | None = None) -> float | None:
    """Part of the searched space (search coordinates, constraints) in which a basin could hide, from 2000 places.

    Parameters
    ----------
    unseen
        What was looked at.
    unfinished
        Of :meth:`Unseen.unfinished`: a basin could hide around each of these runs, too.

    Returns
    -------
    float or None
        0 to 1; None where no place satisfies the constraints.
    """
    looked = places(space, _POINTS)
    if not len(looked):
        return None
    hides = unseen.hides(looked)
    for place in unseen.runs[[] if unfinished is None else unfinished]:
        hides |= (((looked - place) @ unseen.factor) ** 2).sum(axis=1) <= unseen.reach
    return float(hides.mean())
