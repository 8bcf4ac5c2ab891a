"""Whether the method of a follow-up fits the parameters and measurements of its problem."""

from __future__ import annotations

from geoswarm.solver.errors import Issue
from geoswarm.solver.extras import has, needs_extra
from geoswarm.solver.problem.follow_ups import ProfileMethod, SensitivityMethod
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.sections import MonteCarloMethod, ParticleSwarmMethod

__all__ = ["follow_up_issues"]


def follow_up_issues(problem: Problem) -> list[Issue]:
    """Why the method of a follow-up does not fit the rest of the problem; empty when it does, or is none."""
    method, free = problem.method, problem.free
    if isinstance(method, ParticleSwarmMethod | MonteCarloMethod):
        return []
    names = [p.name for p in free]
    if not isinstance(method, SensitivityMethod | ProfileMethod):
        if not has("SALib"):
            return [Issue("method.kind", needs_extra(f"the method {method.kind}", "SALib"))]
        return []
    issues = []
    if set(method.at) != set(names):
        issues.append(
            Issue("method.at", f"must name the free parameters {', '.join(names)}, not {', '.join(method.at)}")
        )
    for parameter in free:
        value = method.at.get(parameter.name, parameter.lower)
        if not parameter.lower <= value <= parameter.upper:
            bounds = f"between the bounds {parameter.lower:g} and {parameter.upper:g}"
            issues.append(Issue(f"method.at.{parameter.name}", f"must be {bounds}, not {value:g}"))
    if isinstance(method, ProfileMethod):
        for key, section in (("rise", method.rise), ("step", method.step)):
            unknown = [name for name in section if name not in names]
            if unknown:
                message = f"{', '.join(unknown)}: no free parameter; free: {', '.join(names)}"
                issues.append(Issue(f"method.{key}", message))
    points = sum(int((o.point_weights > 0).sum()) for o in problem.observations if o.weight > 0)
    if points < len(names):
        message = (
            f"{points} measured point{'' if points == 1 else 's'} cannot determine {len(names)} free parameters "
            f"({', '.join(names)}); fix or link some of them, or add measurements"
        )
        issues.append(Issue("method", message))
    if not issues and not problem.satisfies(problem.values([method.at[name] for name in names])):
        issues.append(Issue("method.at", "does not satisfy the constraints, or the limits of the forward model"))
    return issues
