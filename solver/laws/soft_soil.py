"""The soft soil model as a law: soft soil creep without creep, with the same kernels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import Formulation, SoftSoilCreep, soft_soil
from geoswarm.solver.laws.soft_soil_creep import PARAMETERS, SOFT_SOIL_TERMS, SoftSoilCreepLaw
from geoswarm.solver.laws.terms import Term
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["SoftSoilLaw"]


class SoftSoilLaw(SoftSoilCreepLaw):
    """Soft soil (Brinkgreve 1994; Vermeer & Neher 1999 without creep); constants as of soft soil creep with mu* = 0."""

    kind: ClassVar[str] = "soft_soil"
    title: ClassVar[str] = "soft soil"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = tuple(info for info in PARAMETERS if info.name != "mu_star")
    terms: ClassVar[tuple[Term, ...]] = SOFT_SOIL_TERMS

    def kernel_constants(
        self, given: Mapping[str, float], formulation: Formulation, tension_cutoff: float | None
    ) -> SoftSoilCreep:
        """Constants of the kernels from parameters by name; raises as :meth:`constants`."""
        return soft_soil(
            given["lambda_star"],
            given["kappa_star"],
            given["c"],
            given["phi"],
            given.get("psi", 0.0),
            given.get("nu_ur", 0.15),
            given.get("K0nc") or None,
            given.get("M") or None,
            formulation=formulation,
            tension_cutoff=tension_cutoff,
        )

    @property
    def depends_on_time(self) -> bool:
        """Time has no effect."""
        return False

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> None:
        """Time has no effect."""
        del stress, state, constants
