"""Bounds that leave out what all correlations with the index properties of the soil let expect."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from geoswarm.solver.problem import FreeParameter, Problem
from geoswarm.solver.sentences import Key, Sentence, setting
from geoswarm.solver.units import with_unit

if TYPE_CHECKING:
    from geoswarm.solver.parameter_estimates.index import ParameterEstimate

__all__ = ["unexpected_bounds"]


_UNKNOWN = 1.0 / 3.0
"""Scatter, relative, of correlations that were published without one."""


def unexpected_bounds(problem: Problem) -> Iterator[Sentence]:
    """Free parameters whose bounds exclude every estimate from the index properties, scatter included.

    Correlations outside their published range take no part; one without a published scatter counts with a third.
    """
    if problem.index_properties is None and not any(
        part.index_properties_of_soils for part in problem.forward_model.by_part().values()
    ):
        return
    from geoswarm.solver.parameter_estimates.index import (
        estimates_of,  # with Numba, for which a formula should not wait
    )

    by_name: dict[str, list[ParameterEstimate]] = {}
    for one in estimates_of(problem):
        if not one.correlated.outside:
            by_name.setdefault(one.parameter, []).append(one)
    for name, estimates in by_name.items():
        parameter = problem.parameters.get(name)
        if isinstance(parameter, FreeParameter):
            yield from _sentence(name, parameter, estimates)


def _sentence(name: str, parameter: FreeParameter, estimates: list[ParameterEstimate]) -> Iterator[Sentence]:
    wide = [one.ends or ((1.0 - _UNKNOWN) * one.value, (1.0 + _UNKNOWN) * one.value) for one in estimates]
    low, high = min(ends[0] for ends in wide), max(ends[1] for ends in wide)
    if low <= parameter.upper and high >= parameter.lower:
        return
    end, bound = ("upper", parameter.upper) if low > parameter.upper else ("lower", parameter.lower)
    expected = f"{float(f'{low:.2g}'):g} to {with_unit(float(f'{high:.2g}'), estimates[0].unit)}"
    sources = "; ".join(dict.fromkeys(one.correlated.correlation.authors for one in estimates))
    path = f"parameters.{name}.{end}"
    yield (
        Key(path, path),
        f" = {with_unit(bound, estimates[0].unit)}: by the index properties {expected} is expected ({sources}); widen "
        "the bounds or check ",
        setting("index_properties"),
    )
