"""Sections of a law's parameters: free in their usual ranges, or fixed where such a file cannot tell them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.parameter_estimates.proposal import is_wide, usual_section, wanted

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law
    from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["middle", "parameter_sections", "rounded_up"]


def parameter_sections(law: Law, fixed: Mapping[str, float], material: str) -> dict[str, dict[str, Any]]:
    """Return the parameters of a problem: those without default, and one of each pair that the law wants one of.

    Parameters
    ----------
    fixed
        Those that are not searched for, with their values.
    material
        What the choice of a law is called, for messages.

    Raises
    ------
    AgsError
        A parameter has no usual range.
    """
    infos = {info.name: info for info in law.parameters}
    return {
        name: {"value": fixed[name]} if name in fixed else _free(law.kind, infos[name], material)
        for name in wanted(law, fixed)
    }


def middle(info: ParameterInfo) -> float:
    """Return the middle of the usual range, on a log scale where it is wide; two digits."""
    assert info.typical is not None
    low, high = info.typical
    value = math.sqrt(low * high) if is_wide(low, high) else 0.5 * (low + high)
    return float(f"{value:.2g}")


def rounded_up(value: float) -> float:
    """Return a number above 0 that is no smaller and has two digits.

    >>> rounded_up(1230.0), rounded_up(0.5)
    (1300.0, 0.5)
    """
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.ceil(value / power * (1.0 - 1e-12)) * power:.2g}")


def _free(kind: str, info: ParameterInfo, material: str) -> dict[str, Any]:
    section = usual_section(info)
    if section is None:
        raise AgsError(
            f"material {kind}: {info.name} has no usual range, so no problem can be made; choose another {material}"
        )
    return section
