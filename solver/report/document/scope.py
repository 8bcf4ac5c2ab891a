"""What the forward model of a laboratory test does not contain, for a report to say."""

from __future__ import annotations

from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.checks.consolidation import find_consolidation
from geoswarm.solver.problem.stages import section_of_test, stage_times

__all__ = ["not_modelled"]


def not_modelled(problem: Problem) -> tuple[str, ...]:
    """Sentences on primary consolidation in readings over the time of a test in stages; empty for other problems."""
    spec = problem.forward_model
    timed = [
        o
        for o in problem.observations
        if stage_times(spec, o.series).size and not section_of_test(spec, o.series)[1].consolidates
    ]
    if not timed:
        return ()
    counts = ", ".join(f"{o.left_out} of {len(o.points.x)} of {o.series}" for o in timed)
    general = (
        "Primary consolidation is not modelled: readings before its end in a stage make the parameters wrong. Readings "
        f"that were left out: {counts}."
    )
    return (general, *(found.sentence for found in find_consolidation(problem)))
