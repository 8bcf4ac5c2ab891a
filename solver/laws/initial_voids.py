"""The void ratio before a test: once, from the section of the test or from the parameters of the law."""

from __future__ import annotations

from dataclasses import replace

from geoswarm.solver.laws.base import Law
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["knows_voids", "settled", "void_ratio_parameters", "voids_column"]

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


def settled(infos: tuple[ParameterInfo, ...]) -> list[ParameterInfo]:
    """Those whose value the section gives."""
    return [info for info in infos if info.set_by]
