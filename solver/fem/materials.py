"""Materials that phases assign to regions and interfaces, and their constants as the kernels read them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil

__all__ = ["COMPONENTS", "INTERFACE_CONSTANTS", "INTERFACE_STRENGTH", "InterfaceMaterial", "Material"]

COMPONENTS: Final = 4
"""Stress components in a plane or an axisymmetric body."""

INTERFACE_CONSTANTS: Final = 6

INTERFACE_STRENGTH: Final = (2, 3, 4, 5)
"""Where the constants of an interface hold cohesion, tangents of friction and dilatancy, and tension cut-off."""


def _range(name: str, value: float, accepted: bool, words: str) -> None:
    if not accepted:
        raise InfeasibleError(f"{name} must be {words}, got {value:g}")


def _strength(c: float, phi: float, psi: float, tension_cutoff: float | None) -> None:
    _range("c", c, 0.0 <= c < math.inf, "0 kPa or more")
    _range("phi", phi, 0.0 <= phi < 90.0, "a value from 0 to below 90 degree")
    _range("psi", psi, 0.0 <= psi <= phi, f"a value from 0 to phi = {phi:g} degree")
    if tension_cutoff is not None:
        _range("tension_cutoff", tension_cutoff, tension_cutoff >= 0.0, "0 kPa or more")


@dataclass(frozen=True)
class Material:
    """A soil of any law with its weight.

    Parameters
    ----------
    soil
        The law with its constants; its state begins where a phase places it.
    unit_weight
        kN/m3.
    K0
        Ratio of horizontal to vertical stress in a K0 phase; that of the law unless given.

    Raises
    ------
    InfeasibleError
        The weight is negative, or the law is not one for planes.
    """

    soil: Soil
    unit_weight: float = 0.0
    K0: float | None = None

    def __post_init__(self) -> None:
        _range("unit_weight", self.unit_weight, 0.0 <= self.unit_weight < math.inf, "0 kN/m3 or more")
        law = self.soil.law
        if COMPONENTS not in law.components:
            raise InfeasibleError(f"{law.title} ({law.kind}) has no stress update for plane and axisymmetric bodies")

    def lateral_ratio(self) -> float:
        """K0 of a K0 phase.

        Raises
        ------
        InfeasibleError
            Neither the material nor its law has one.
        """
        ratio = self.soil.law.K0(self.soil.constants) if self.K0 is None else self.K0
        if ratio is None:
            law = self.soil.law
            raise InfeasibleError(f"{law.title} ({law.kind}) has no K0, which a phase of kind K0 needs")
        return ratio


@dataclass(frozen=True)
class InterfaceMaterial:
    """Friction between two sides: elastic below the Mohr-Coulomb limit of the traction, no tension above ``tension``.

    Parameters
    ----------
    normal_stiffness, shear_stiffness
        kPa/m, above 0.
    c, phi, psi
        kPa and degree.
    tension
        Largest admissible normal traction, kPa, at least 0; None: none but the apex of the friction law.

    Raises
    ------
    InfeasibleError
        A constant is outside its range.
    """

    normal_stiffness: float
    shear_stiffness: float
    c: float
    phi: float
    psi: float = 0.0
    tension: float | None = 0.0

    def __post_init__(self) -> None:
        for name in ("normal_stiffness", "shear_stiffness"):
            value = getattr(self, name)
            _range(name, value, 0.0 < value < math.inf, "a value above 0 kPa/m")
        _strength(self.c, self.phi, self.psi, self.tension)

    def constants(self) -> FloatArray:
        """Stiffnesses, c, tan(phi), tan(psi) and tension, shape (INTERFACE_CONSTANTS,)."""
        return np.array(
            [
                self.normal_stiffness,
                self.shear_stiffness,
                self.c,
                math.tan(math.radians(self.phi)),
                math.tan(math.radians(self.psi)),
                math.inf if self.tension is None else self.tension,
            ]
        )
