"""The soft soil model as a law: soft soil creep without creep, with the same kernels."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep import Formulation, SoftSoilCreep, soft_soil
from geoswarm.solver.constitutive.soft_soil_step import soft_soil_step
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.soft_soil_creep import PARAMETERS, SoftSoilCreepLaw
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["SoftSoilLaw"]


@NumbaUpdate
def _update(components, _log_time, strain, stress, state, constants, new_stress, new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = carray(constants, 16)
    soil = SoftSoilCreep(
        c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11], c[12], c[13], c[14], c[15]
    )
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    new_state[0], active = soft_soil_step(old, step, 0.0, state[0], soil, new, C)
    if active < 0:
        return -1
    return 2 * active + (1 if new_state[0] > state[0] else 0)  # yield by compression is a limit of its own


class SoftSoilLaw(SoftSoilCreepLaw):
    """Soft soil (Brinkgreve 1994; Vermeer & Neher 1999 without creep); constants as of soft soil creep with mu* = 0."""

    kind: ClassVar[str] = "soft_soil"
    title: ClassVar[str] = "soft soil"
    parameters: ClassVar[tuple[ParameterInfo, ...]] = tuple(info for info in PARAMETERS if info.name != "mu_star")
    update: ClassVar[NumbaUpdate] = _update

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
