"""Linear elasticity up to the cones of Drucker and Prager, and of Matsuoka and Nakai, perfectly plastic, as laws."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.smooth_cone import (
    COMPRESSION,
    EXTENSION,
    MATSUOKA_NAKAI,
    PLANE_STRAIN,
    cone_excess,
    cone_of,
    cone_step,
)
from geoswarm.solver.constitutive.tensors import principal_axes
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Setting, StrengthPlaces
from geoswarm.solver.laws.binary import NumbaUpdate, carray
from geoswarm.solver.laws.perfect_plasticity.mohr_coulomb import TENSION_CUTOFF, MohrCoulomb

__all__ = ["DruckerPrager", "MatsuokaNakai", "SmoothCone"]

_SHAPES = {"compression": COMPRESSION, "extension": EXTENSION, "plane_strain": PLANE_STRAIN}
_NOTICED = 1.0e-9


@NumbaUpdate
def _update(components, _log_time, strain, stress, _state, constants, new_stress, _new_state, tangent):  # type: ignore[no-untyped-def]  # pointers
    c = carray(constants, 8)
    cone = np.empty(5)
    cone_of(int(c[7]), c[2], c[3], c[4], c[5], cone)
    old, step = carray(stress, components), carray(strain, components)
    new, C = carray(new_stress, components), carray(tangent, (components, components))
    return cone_step(old, step, c[0], c[1], cone, c[6], new, C)


class SmoothCone(MohrCoulomb):
    """What laws with a smooth cone have in common; constants: those of Mohr-Coulomb, and the kind of the cone."""

    update: ClassVar[NumbaUpdate] = _update

    @abstractmethod
    def cone_kind(self, given: Mapping[str, Any]) -> int:
        """One of the constants of :mod:`geoswarm.solver.constitutive.smooth_cone`."""

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Those that the class names."""
        return np.append(super().constants(given), float(self.cone_kind(given)))

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """No state variables.

        Raises
        ------
        InfeasibleError
            A stress is beyond the strength.
        """
        _, _, cohesion, sin_phi, cos_phi, sin_psi, tension, kind = constants.tolist()
        cone = np.empty(5)
        cone_of(int(kind), cohesion, sin_phi, cos_phi, sin_psi, cone)
        general = np.zeros((*stress.shape[:-1], 6))
        general[..., : stress.shape[-1]] = stress
        for one in general.reshape(-1, 6):
            values = principal_axes(one)[0]
            size = abs(values[0]) + abs(values[2]) + cone[1]
            if cone_excess(values, cone) > _NOTICED * size or -values[2] > tension + _NOTICED * size:
                found = ", ".join(f"{value:g}" for value in values.tolist())
                raise InfeasibleError(f"initial principal stresses {found} kPa violate the strength; give others")
        return super().initial_state(stress, constants)


class DruckerPrager(SmoothCone):
    """Drucker-Prager (Drucker & Prager 1952), with dilatancy and tension cut-off."""

    kind: ClassVar[str] = "drucker_prager"
    title: ClassVar[str] = "elasticity with the strength of Drucker and Prager"
    settings: ClassVar[tuple[Setting, ...]] = (
        Setting(
            "match",
            "Where strength and dilatancy are those of Mohr-Coulomb with the same c, phi and psi.",
            "compression",
            choices=tuple(_SHAPES),
        ),
        TENSION_CUTOFF,
    )
    strength: ClassVar[StrengthPlaces | None] = None

    def cone_kind(self, given: Mapping[str, Any]) -> int:
        """By the setting ``match``."""
        return _SHAPES[given["match"]]


class MatsuokaNakai(SmoothCone):
    """Matsuoka-Nakai (Matsuoka & Nakai 1974), with dilatancy and tension cut-off.

    It holds the limit of Mohr-Coulomb within, and meets it in triaxial compression and extension; so a strength that
    is enough for Mohr-Coulomb is enough here.
    """

    kind: ClassVar[str] = "matsuoka_nakai"
    title: ClassVar[str] = "elasticity with the strength of Matsuoka and Nakai"

    def cone_kind(self, given: Mapping[str, Any]) -> int:
        """That of Matsuoka and Nakai."""
        del given
        return MATSUOKA_NAKAI
