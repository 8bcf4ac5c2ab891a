"""The state of a soil before a test: its void ratio, and its horizontal stress at rest."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import Any

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law, Soil
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits

__all__ = [
    "horizontal_limits",
    "horizontal_stress",
    "incomplete",
    "knows_voids",
    "settled",
    "soil_of",
    "void_ratio_parameters",
    "voids_column",
]

_KEY = "initial_void_ratio"


def voids_column(law: Law) -> int | None:
    """Which state variable of a law is the void ratio that its parameter e0 begins; None of laws that have none."""
    if "e0" not in {info.name for info in law.parameters}:
        return None
    return next((column for column, one in enumerate(law.state) if one.symbol == "e"), None)


def knows_voids(law: Law, given: float | None) -> bool:
    """Whether the void ratio before a test is known: from its section, None for not, or from the law."""
    return given is not None or voids_column(law) is not None


def void_ratio_parameters(law: Law, given: float | None) -> tuple[ParameterInfo, ...]:
    """Parameters of a law in a test with this void ratio in its section, None for none: e0 is that one."""
    if given is None or voids_column(law) is None:
        return law.parameters

    def known(info: ParameterInfo) -> ParameterInfo:
        value = given if info.name == "e0" else info.default
        if info.name != "e0" and info.name not in law.instead_of_e0:
            return info
        return replace(info, default=value, lower=value, upper=value, lower_open=False, upper_open=False, set_by=_KEY)

    return tuple(known(info) for info in law.parameters)


def incomplete(law: Law, infos: tuple[ParameterInfo, ...], declared: Collection[str]) -> str | None:
    """What a law lacks in a test whose section settles some of its parameters, in words, or None.

    Parameters
    ----------
    infos
        Parameters of the law, as :func:`void_ratio_parameters` returns them.
    declared
        Names of those that the problem gives.
    """
    given = frozenset(declared) | {info.name for info in settled(infos) if info.default}
    fault = law.incomplete(given)
    if fault is None:
        return None
    helps = voids_column(law) is not None and law.incomplete(given | {"e0"}) is None
    also = f", or {_KEY} of the test" if helps else ""
    return f"{fault}{also}; material {law.kind} needs it"


def settled(infos: tuple[ParameterInfo, ...]) -> list[ParameterInfo]:
    """Those whose value the section gives."""
    return [info for info in infos if info.set_by]


def soil_of(
    law: Law, infos: tuple[ParameterInfo, ...], parameters: Mapping[str, float], settings: Mapping[str, Any]
) -> Soil:
    """Return the soil of a law whose parameters, ``infos``, a section may settle.

    Raises
    ------
    InfeasibleError
        A value is outside what the law or the section admits.
    """
    known = settled(infos)
    if (fault := outside_limits(known, parameters)) is not None:
        raise InfeasibleError(fault)
    return law.soil({info.name: info.default for info in known} | dict(parameters) | dict(settings))


def horizontal_limits(vertical: float, soil: Soil) -> tuple[float, float]:
    """Smallest and largest horizontal stress, kPa, that the strength of a law admits, if it declares one."""
    if soil.law.strength is None:
        return -math.inf, math.inf
    cohesion, sin_phi, cos_phi, _, tension = soil.constants[list(soil.law.strength)].tolist()
    both = 2.0 * cohesion * cos_phi
    lower = ((1.0 - sin_phi) * vertical - both) / (1.0 + sin_phi)
    return max(lower, -tension), ((1.0 + sin_phi) * vertical + both) / (1.0 - sin_phi)


def horizontal_stress(vertical: float, ratio: float | None, soil: Soil) -> float:
    """``ratio`` times the vertical stress, kPa; None: K0 of the law.

    Raises
    ------
    InfeasibleError
        The law knows no K0, or the stress violates its strength.
    """
    K0 = soil.law.K0(soil.constants) if ratio is None else ratio
    if K0 is None:
        raise InfeasibleError(f"material {soil.law.kind} has no K0; give the ratio of horizontal to vertical stress")
    lower, upper = horizontal_limits(vertical, soil)
    if not lower <= K0 * vertical <= upper:
        raise InfeasibleError(
            f"initial horizontal stress = {K0 * vertical:g} kPa (K0 = {K0:g}) violates the strength; K0 must be from "
            f"{max(lower, 0.0) / vertical:g} to {upper / vertical:g}"
        )
    return K0 * vertical
