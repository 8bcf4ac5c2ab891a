"""What one evaluation may use on the workers of an operator."""

from __future__ import annotations

from geoswarm.solver.problem import Problem
from geoswarm.solver.runner.evaluator import RunLimits
from geoswarm.workers.settings import Settings

__all__ = ["limits_of"]


def limits_of(problem: Problem, settings: Settings) -> RunLimits:
    """Return the limits of a problem, and of these workers where they are tighter."""
    most = (settings.evaluation_seconds, settings.evaluation_memory_mb)
    return RunLimits.of(problem).within(*most, of_time="GEOSWARM_EVALUATION_SECONDS of the workers")
