"""Why a curve does not allow a classical evaluation."""

from __future__ import annotations

from geoswarm.solver.errors import SolverError

__all__ = ["NoEvaluationError"]


class NoEvaluationError(SolverError):
    """A curve does not allow an evaluation; the message says what is missing."""
