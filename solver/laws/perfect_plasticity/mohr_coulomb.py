"""Linear elasticity up to the Mohr-Coulomb limit, perfectly plastic, with dilatancy and tension cut-off, as a law."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.mohr_coulomb.step import general_mohr_coulomb, planar_mohr_coulomb
from geoswarm.solver.laws.base import Law, Setting, StrengthPlaces
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.elastic import MODULI, YOUNG, moduli_contradiction, moduli_incomplete, young_of
from geoswarm.solver.laws.sources import TERZAGHI
from geoswarm.solver.laws.terms import COHESION, DILATANCY_ANGLE, FRICTION, Term
from geoswarm.solver.laws.usual_parameters import DILATANCY, angle, cohesion, too_dilatant
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["TENSION_CUTOFF", "MohrCoulomb"]

TENSION_CUTOFF = Setting("tension_cutoff", "Largest admissible tension, kPa; null for no cut-off.", 0.0, unit="kPa")


@NumbaUpdate
def _update(components, _log_time, strain, stress, _state, constants, new_stress, _new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = carray(constants, 7)
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    if components == 4:
        return planar_mohr_coulomb(old, step, c[0], c[1], c[2], c[3], c[4], c[5], c[6], new, C)
    return general_mohr_coulomb(old, step, c[0], c[1], c[2], c[3], c[4], c[5], c[6], new, C)


class MohrCoulomb(Law):
    """Mohr-Coulomb; constants: bulk and shear modulus, c, sin(phi), cos(phi), sin(psi), tension cut-off."""

    kind: ClassVar[str] = "mohr_coulomb"
    title: ClassVar[str] = "elasticity with the strength of Mohr and Coulomb"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = (
        *MODULI,
        cohesion(50.0),
        angle("phi", "φ", "Effective friction angle.", (15.0, 35.0), f"{TERZAGHI}, article 19"),
        DILATANCY,
    )
    terms: ClassVar[tuple[Term, ...]] = (YOUNG, FRICTION, COHESION, DILATANCY_ANGLE)
    derived: ClassVar[frozenset[str]] = frozenset({"E", "G"})
    settings: ClassVar[tuple[Setting, ...]] = (TENSION_CUTOFF,)
    update: ClassVar[NumbaUpdate] = _update
    strength: ClassVar[StrengthPlaces | None] = StrengthPlaces(2, 3, 4, 5, 6)
    perfectly_plastic: ClassVar[bool] = True

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """Both moduli, or more dilatancy than friction."""
        return too_dilatant(values.get("phi"), values.get("psi", 0.0)) or moduli_contradiction(values)

    def incomplete(self, given: frozenset[str]) -> str | None:
        """The modulus."""
        return moduli_incomplete(given)

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        young, poisson = young_of(given), given["nu"]
        phi, psi = math.radians(given["phi"]), math.radians(given["psi"])
        tension = math.inf if given["tension_cutoff"] is None else given["tension_cutoff"]
        return np.array(
            [
                young / (3.0 * (1.0 - 2.0 * poisson)),
                young / (2.0 * (1.0 + poisson)),
                given["c"],
                math.sin(phi),
                math.cos(phi),
                math.sin(psi),
                tension,
            ]
        )

    def K0(self, constants: FloatArray) -> float:
        """Jaky: 1 - sin(phi)."""
        return float(1.0 - constants[3])

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """The same at any stress."""
        del p
        return float(constants[0]), float(constants[1])
