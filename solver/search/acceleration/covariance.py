"""Covariance-adapting moves (CMA-ES, Hansen 2016) for part of a generation, from the ``cmaes`` library.

The library asks and tells a population of its own size; here its points are asked one by one, into as many slots as a
generation offers, and told as soon as a population is complete.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["CovarianceMoves"]

_ARRAYS = "arrays"
_SMALLEST_SPREAD = 1e-5
_FAILED = 1e300  # the library takes finite values only


def _library() -> Any:
    """Import it when these moves are made: with what it needs of SciPy it takes two seconds."""
    from cmaes import CMA

    return CMA


class CovarianceMoves:
    """One run of CMA-ES in the unit box; ``state`` is JSON-able and restores it bit for bit."""

    def __init__(self, state: dict[str, Any]) -> None:
        self._told: list[tuple[list[float], float]] = [(point, value) for point, value in state["told"]]
        attributes = dict(state["plain"])
        attributes.update({name: np.array(value) for name, value in state[_ARRAYS].items()})
        library = _library()
        self._cma = library.__new__(library)
        self._cma.__setstate__(attributes)

    @classmethod
    def begin(cls, mean: FloatArray, spread: float) -> CovarianceMoves:
        """Start around a point of the unit box with a standard deviation."""
        d = mean.size
        size = max(5, 4 + int(3 * math.log(d)))
        box = np.array([[0.0, 1.0]] * d)
        moves = cls.__new__(cls)
        moves._cma = _library()(mean=mean.copy(), sigma=spread, bounds=box, seed=0, population_size=size)
        moves._cma._funhist_values[:] = 0.0  # the library leaves it uninitialised, a snapshot must not
        moves._told = []
        return moves

    def state(self) -> dict[str, Any]:
        """Return the state between two generations."""
        plain: dict[str, Any] = {}
        arrays: dict[str, Any] = {}
        for name, value in sorted(self._cma.__getstate__().items()):
            if isinstance(value, np.ndarray):
                arrays[name] = value.tolist()
            else:
                plain[name] = value.item() if isinstance(value, np.generic) else value
        return {"plain": plain, _ARRAYS: arrays, "told": [[point, value] for point, value in self._told]}

    def ask(self, random: np.random.Generator) -> FloatArray:
        """Return one point of the unit box."""
        self._cma.reseed_rng(int(random.integers(2**32)))
        point: FloatArray = self._cma.ask()
        return np.clip(point, 0.0, 1.0)

    def tell(self, point: FloatArray, objective: float) -> None:
        """Take the objective of an asked point, inf for a failed one."""
        self._told.append((point.tolist(), min(objective, _FAILED)))
        size = self._cma.population_size
        if len(self._told) >= size:
            batch, self._told = self._told[:size], self._told[size:]
            self._cma.tell([(np.array(p), value) for p, value in batch])

    @property
    def exhausted(self) -> bool:
        """Whether it has contracted to a point or cannot go on."""
        widest = self._cma._sigma * math.sqrt(float(np.diag(self._cma._C).max()))
        return bool(widest < _SMALLEST_SPREAD or self._cma.should_stop())
