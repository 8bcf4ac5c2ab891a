"""What in a valid problem is probably not meant. Every finding is a sentence, a warning and never an error.

================  ============================================================================
``ranges``        values far outside the usual ranges that forms show
``expectations``  bounds that leave out what index properties of the soil let expect
``headings``      units of the problem file against those in the headings of the data
``readings``      size and sign of readings against the specimen
``loads``         loads of a test in stages that the readings do not show
================  ============================================================================
"""

from __future__ import annotations

from geoswarm.solver.plausibility.expectations import unexpected_bounds
from geoswarm.solver.plausibility.headings import contradicted_headings
from geoswarm.solver.plausibility.loads import loads_not_shown
from geoswarm.solver.plausibility.ranges import unusual_values
from geoswarm.solver.plausibility.readings import impossible_readings
from geoswarm.solver.problem import Problem

__all__ = ["implausible"]


def implausible(problem: Problem) -> tuple[str, ...]:
    """Everything about a problem that is probably not meant; runs nothing."""
    return (
        *unusual_values(problem),
        *unexpected_bounds(problem),
        *contradicted_headings(problem),
        *impossible_readings(problem),
        *loads_not_shown(problem),
    )
