"""Linear isotropic elasticity as a law."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.sources import BOWLES, KULHAWY
from geoswarm.solver.laws.terms import Term, same
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["MODULI", "YOUNG", "Elastic", "moduli_contradiction", "moduli_incomplete", "young_of"]

MODULI = (
    ParameterInfo(
        "E", "E", "kPa", "Young's modulus; or give G.", default=0.0, lower=0.0, typical=(1.0e3, 1.0e6), source=BOWLES
    ),
    ParameterInfo(
        "G",
        "G",
        "kPa",
        "Shear modulus; or give E.",
        default=0.0,
        lower=0.0,
        typical=(4.0e2, 4.0e5),
        source=f"E/(2 (1 + nu)); {BOWLES}",
    ),
    ParameterInfo(
        "nu",
        "ν",
        "",
        "Poisson's ratio.",
        lower=-1.0,
        lower_open=True,
        upper=0.5,
        upper_open=True,
        typical=(0.15, 0.4),
        source=KULHAWY,
    ),
)
"""Parameters of an isotropic elastic law: one of E and G, and nu."""

YOUNG = same("E₅₀", "kPa", "secant modulus at half the strength, drained", "E")
"""Below the strength such a law is elastic, so the secant is Young's modulus."""


def moduli_contradiction(values: Mapping[str, float]) -> str | None:
    """What is wrong with the moduli, or None."""
    if values.get("E", 0.0) > 0.0 and values.get("G", 0.0) > 0.0:
        return f"E = {values['E']:g} and G = {values['G']:g} kPa are both given; give only one of them"
    return None


def moduli_incomplete(given: frozenset[str]) -> str | None:
    """What is wrong with the moduli that are given, or None."""
    return None if len(given & {"E", "G"}) == 1 else "give exactly one of E and G"


def young_of(given: Mapping[str, Any]) -> float:
    """Young's modulus, kPa, from the one modulus that is given.

    Raises
    ------
    InfeasibleError
        None is given.
    """
    if not given["E"] and not given["G"]:
        raise InfeasibleError("give exactly one of E and G, a value above 0 kPa")
    return float(given["E"] if given["E"] else 2.0 * (1.0 + given["nu"]) * given["G"])


@NumbaUpdate
def _update(components, _log_time, strain, stress, _state, constants, new_stress, _new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    shear, lame = constants[0], constants[1]
    volume = strain[0] + strain[1] + strain[2]
    C = carray(tangent, (components, components))
    for i in range(components):
        for j in range(components):
            C[i, j] = lame if i < 3 and j < 3 else 0.0
        C[i, i] += 2.0 * shear if i < 3 else shear
        new_stress[i] = stress[i] + C[i, i] * strain[i] - (lame * strain[i] if i < 3 else 0.0)
        if i < 3:
            new_stress[i] += lame * volume
    return 0


class Elastic(Law):
    """Linear isotropic elasticity; constants: G, Lame's constant, nu."""

    kind: ClassVar[str] = "elastic"
    title: ClassVar[str] = "linear elasticity"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = MODULI
    terms: ClassVar[tuple[Term, ...]] = (YOUNG,)
    derived: ClassVar[frozenset[str]] = frozenset({"E", "G"})
    update: ClassVar[NumbaUpdate] = _update

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Both moduli."""
        return moduli_contradiction(values)

    def incomplete(self, given: frozenset[str]) -> str | None:
        """The modulus."""
        return moduli_incomplete(given)

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """G, Lame's constant and nu."""
        young, poisson = young_of(given), given["nu"]
        shear = young / (2.0 * (1.0 + poisson))
        return np.array([shear, 2.0 * shear * poisson / (1.0 - 2.0 * poisson), poisson])

    def K0(self, constants: FloatArray) -> float:
        """That of a body that is held at its sides: nu/(1 - nu)."""
        return float(constants[2] / (1.0 - constants[2]))

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """The same at any stress."""
        del p
        return float(constants[1] + 2.0 / 3.0 * constants[0]), float(constants[0])
