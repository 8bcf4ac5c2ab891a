"""Sections of parameters in their usual ranges, and what laws want between parameters."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from geoswarm.solver.laws.base import Law
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["is_wide", "ordered", "usual_section", "wanted"]

_DECADE = 10.0
_LARGER = (("lambda_star", "kappa_star"), ("lambda", "kappa"))
"""Pairs of which the first must be larger."""
_PAIRS = (("M", "phi_cs"), ("N", "e0"), ("nu", "G"), ("E", "G"))
"""Pairs of which laws want one; the first is left out where the second is there, and free otherwise."""


def wanted(law: Law, given: Collection[str]) -> list[str]:
    """Names of a law's parameters that a problem has to give: those without default, and one of each pair.

    ``given``: names that are there anyway.
    """
    infos = {info.name: info for info in law.parameters}
    names = [name for name, info in infos.items() if info.default is None or name in given]
    for first, second in _PAIRS:
        told = law.incomplete(frozenset(names))
        if told is not None and first in told and first in infos and second not in names:
            names.append(first)
    return [name for name in infos if name in names]


def usual_section(info: ParameterInfo) -> dict[str, Any] | None:
    """A free parameter in its usual range, on a log scale where that spans a decade; None without such a range."""
    if info.typical is None:
        return None
    low, high = info.typical
    return {"lower": low, "upper": high} | ({"scale": "log"} if is_wide(low, high) else {})


def ordered(sections: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Constraints between parameters."""
    found = []
    for name in sections:
        start, _, own = name.rpartition(".")
        for one, other in _LARGER:
            beside = f"{start}.{other}" if start else other
            if own == one and beside in sections:
                found.append(f"{name} > {beside}")
    return found


def is_wide(low: float, high: float) -> bool:
    """Whether a range spans a decade."""
    return low > 0.0 and high >= _DECADE * low
