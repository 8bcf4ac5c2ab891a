"""From the method of a follow-up to its search."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem import FollowUpMethod, ProfileMethod, SensitivityMethod
from geoswarm.solver.search import Search, SearchSpace, Snapshot
from geoswarm.solver.search.follow_ups import (
    BLIND_STEP,
    DesignSearch,
    GlobalPoints,
    ProfileSearch,
    ProfileSettings,
    SensitivitySearch,
    SensitivitySettings,
)

__all__ = ["DESIGN_COMPLETED", "FollowUp", "profile_search", "sensitivity_search"]

DESIGN_COMPLETED = "design_completed"


def sensitivity_search(
    space: SearchSpace, method: SensitivityMethod, snapshot: Snapshot | None = None
) -> SensitivitySearch:
    """Begin or go on with sensitivities."""
    settings = SensitivitySettings(_ordered(space, method.at), method.step, method.polish)
    return SensitivitySearch(space, settings, snapshot)


def profile_search(space: SearchSpace, method: ProfileMethod, snapshot: Snapshot | None = None) -> ProfileSearch:
    """Begin or go on with profiles."""
    rise = np.array([method.rise.get(name, np.nan) for name in space.names], dtype=np.float64)
    step = np.array([method.step.get(name, BLIND_STEP) for name in space.names], dtype=np.float64)
    return ProfileSearch(space, ProfileSettings(_ordered(space, method.at), rise, step), snapshot)


class FollowUp:
    """The follow-up of one job: makes its search, new or from a snapshot.

    Parameters
    ----------
    space, method, seed
        Of the job.
    """

    def __init__(self, space: SearchSpace, method: FollowUpMethod, seed: int) -> None:
        self._space = space
        self._method = method
        self.points: GlobalPoints | None = None
        """Of a global design; None for the others."""
        if not isinstance(method, SensitivityMethod | ProfileMethod):
            self.points = GlobalPoints(space, method.kind, method.samples, seed)

    @property
    def learns(self) -> bool:
        """Whether the search needs the residuals of all runs so far."""
        method = self._method
        if isinstance(method, SensitivityMethod):
            return method.polish or method.step is None
        return isinstance(method, ProfileMethod)

    def search(self, snapshot: Snapshot | None = None) -> Search:
        """Begin the search, or go on with it."""
        method = self._method
        if isinstance(method, SensitivityMethod):
            return sensitivity_search(self._space, method, snapshot)
        if isinstance(method, ProfileMethod):
            return profile_search(self._space, method, snapshot)
        assert self.points is not None
        return DesignSearch(self.points, method.batch, snapshot)


def _ordered(space: SearchSpace, values: Mapping[str, float]) -> FloatArray:
    return np.array([values[name] for name in space.names], dtype=np.float64)
