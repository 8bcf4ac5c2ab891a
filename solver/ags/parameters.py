"""Sections of a law's parameters: free in their usual ranges, or fixed where such a file cannot tell them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from geoswarm.solver.ags.tables import AgsError

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law
    from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["middle", "ordered", "parameter_sections", "rounded_up"]

_DECADE = 10.0
_LARGER = (("lambda_star", "kappa_star"), ("lambda", "kappa"))
"""Pairs of which the first must be larger."""
_PAIRS = (("M", "phi_cs"), ("N", "e0"), ("nu", "G"), ("E", "G"))
"""Pairs of which laws want one; the first is left out where the second is there, and free otherwise."""


def parameter_sections(law: Law, fixed: Mapping[str, float]) -> dict[str, dict[str, Any]]:
    """Return the parameters of a problem: those without default, and one of each pair that the law wants one of.

    Parameters
    ----------
    fixed
        Those that are not searched for, with their values.

    Raises
    ------
    AgsError
        A parameter has no usual range.
    """
    infos = {info.name: info for info in law.parameters}
    names = [name for name, info in infos.items() if info.default is None or name in fixed]
    for first, second in _PAIRS:
        told = law.incomplete(frozenset(names))
        if told is not None and first in told and first in infos and second not in names:
            names.append(first)
    return {
        name: {"value": fixed[name]} if name in fixed else _free(law.kind, infos[name])
        for name in infos
        if name in names
    }


def ordered(sections: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Return the constraints between parameters."""
    return [f"{one} > {other}" for one, other in _LARGER if {one, other} <= sections.keys()]


def middle(info: ParameterInfo) -> float:
    """Return the middle of the usual range, on a log scale where it is wide; two digits."""
    assert info.typical is not None
    low, high = info.typical
    value = math.sqrt(low * high) if _wide(low, high) else 0.5 * (low + high)
    return float(f"{value:.2g}")


def rounded_up(value: float) -> float:
    """Return a number above 0 that is no smaller and has two digits.

    >>> rounded_up(1230.0), rounded_up(0.5)
    (1300.0, 0.5)
    """
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / power * (1.0 - 1e-12)) * power:.2g}")


def _free(kind: str, info: ParameterInfo) -> dict[str, Any]:
    if info.typical is None:
        raise AgsError(
            f"material {kind}: {info.name} has no usual range, so no problem can be made; choose another --material"
        )
    low, high = info.typical
    return {"lower": low, "upper": high} | ({"scale": "log"} if _wide(low, high) else {})


def _wide(low: float, high: float) -> bool:
    return low > 0.0 and high >= _DECADE * low
