"""Remarks on problems that are valid, but better otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["warn_of_many_points"]


def warn_of_many_points(problem: Problem) -> None:
    """Warn of series with so many points that they only cost time."""
    from geoswarm.solver.problem.readings.preparation import many_points_warning

    for observation in problem.observations:
        message = many_points_warning(observation.series, len(observation.x))
        if message is not None:
            note(f"Warning: {message}")
