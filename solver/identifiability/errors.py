"""What can go wrong in the statistics.

::

    SolverError
    └── StatisticsError             the evaluations do not allow what was asked for
        ├── TooFewPointsError       fewer measured points than free parameters
        └── NotExaminedError        the sensitivities at the optimum are needed first
"""

from __future__ import annotations

from geoswarm.solver.errors import StatisticsError

__all__ = ["NotExaminedError", "StatisticsError", "TooFewPointsError"]


class TooFewPointsError(StatisticsError):
    """There are fewer measured points than free parameters: no data can determine them all."""


class NotExaminedError(StatisticsError):
    """The request needs the optimum and its sensitivities, which have not been evaluated yet."""
