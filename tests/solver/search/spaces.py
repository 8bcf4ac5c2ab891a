"""Search spaces shared by the tests of the search methods."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.search.space import SearchSpace

__all__ = ["box", "oedometer_space"]


def box(
    dimension: int, lower: float = -5.0, upper: float = 5.0, feasible: Callable[[FloatArray], bool] = lambda _: True
) -> SearchSpace:
    """A linear box."""
    return SearchSpace(
        names=tuple(f"x{i}" for i in range(dimension)),
        lower=np.full(dimension, lower),
        upper=np.full(dimension, upper),
        log=np.zeros(dimension, dtype=np.bool_),
        feasible=feasible,
    )


def oedometer_space() -> SearchSpace:
    """The published search space: lambda*, kappa* on a log scale with lambda* > kappa*, c linear."""
    return SearchSpace(
        names=("lambda_star", "kappa_star", "c"),
        lower=np.array([0.002, 0.001, 0.001]),
        upper=np.array([1.0, 0.5, 100.0]),
        log=np.array([True, True, False]),
        feasible=lambda x: bool(x[0] > x[1]),
    )
