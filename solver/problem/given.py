"""Values of all parameters from given ones."""

from __future__ import annotations

from collections.abc import Mapping

from geoswarm.solver.problem.parameters import FixedParameter, LinkedParameter
from geoswarm.solver.problem.problem import Problem

__all__ = ["given_mistake", "values_from", "without_value"]


def given_mistake(problem: Problem, name: str) -> str | None:
    """Why a parameter cannot be given a value, or None."""
    from geoswarm.solver.words import did_you_mean

    parameter = problem.parameters.get(name)
    if parameter is None:
        hint = did_you_mean(name, problem.parameters)
        return f"unknown parameter{hint}; known: {', '.join(problem.parameters)}"
    if isinstance(parameter, LinkedParameter):
        return f"it is linked ('{parameter.expression.text}') and follows from the others"
    return None


def without_value(problem: Problem, given: Mapping[str, float]) -> list[str]:
    """Names of free parameters that have neither a given nor an initial value."""
    return [p.name for p in problem.free if p.name not in given and p.initial is None]


def values_from(problem: Problem, given: Mapping[str, float]) -> dict[str, float]:
    """Return the value of every parameter: given ones, else ``initial`` or fixed ones, and linked ones from those.

    Nothing may be :func:`without_value`.
    """
    parameters = problem.parameters.values()
    values = {p.name: p.initial for p in problem.free if p.initial is not None}
    values |= {p.name: p.value for p in parameters if isinstance(p, FixedParameter)} | dict(given)
    pending = [p for p in parameters if isinstance(p, LinkedParameter) and p.name not in given]
    while pending:  # ends: a problem with linked parameters in a circle is refused
        ready = [p for p in pending if p.expression.names <= values.keys()]
        values |= {p.name: float(p.expression.value(values)) for p in ready}
        pending = [p for p in pending if p.name not in values]
    return {name: values[name] for name in problem.parameters}
