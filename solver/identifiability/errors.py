"""What can go wrong in the statistics.

::

    SolverError
    └── StatisticsError             the evaluations do not allow what was asked for
        └── TooFewPointsError       fewer measured points than free parameters
"""

from __future__ import annotations

from geoswarm.solver.errors import SolverError

__all__ = ["StatisticsError", "TooFewPointsError"]


class StatisticsError(SolverError):
    """The evaluations at hand do not allow what was asked for; the message says what is missing."""


class TooFewPointsError(StatisticsError):
    """There are fewer measured points than free parameters: no data can determine them all."""
