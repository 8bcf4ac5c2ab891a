"""The search space of a problem."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.problem import Problem
from geoswarm.solver.search.space import SearchSpace

__all__ = ["search_space"]


def search_space(problem: Problem) -> SearchSpace:
    """Return the space of the free parameters of a problem."""
    return SearchSpace(
        names=problem.free_names,
        lower=np.array([p.lower for p in problem.free], dtype=np.float64),
        upper=np.array([p.upper for p in problem.free], dtype=np.float64),
        log=np.array([p.scale == "log" for p in problem.free], dtype=np.bool_),
        feasible=lambda x: problem.satisfies(problem.values(x.tolist())),
        integer=np.array([p.integer for p in problem.free], dtype=np.bool_),
    )
