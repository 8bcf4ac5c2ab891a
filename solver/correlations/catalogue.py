"""All correlations, and what they say about one soil."""

from __future__ import annotations

from geoswarm.solver.correlations.compressibility import COMPRESSIBILITY
from geoswarm.solver.correlations.correlation import Correlated, Correlation
from geoswarm.solver.correlations.properties import IndexProperties
from geoswarm.solver.correlations.relative_density import SAND
from geoswarm.solver.correlations.strength import STRENGTH

__all__ = ["CORRELATIONS", "correlated"]

CORRELATIONS: tuple[Correlation, ...] = (*COMPRESSIBILITY, *STRENGTH, *SAND)


def correlated(soil: IndexProperties) -> tuple[Correlated, ...]:
    """What all correlations that its properties allow say about a soil."""
    return tuple(told for one in CORRELATIONS if (told := one.told(soil)) is not None)
