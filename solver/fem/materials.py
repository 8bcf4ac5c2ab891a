"""Materials that phases assign to regions and interfaces, and their constants as the kernels read them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep import SoftSoilCreep
from geoswarm.solver.errors import InfeasibleError

__all__ = [
    "CONSTANTS",
    "ELASTIC",
    "INTERFACE_CONSTANTS",
    "INTERFACE_STRENGTH",
    "MOHR_COULOMB",
    "SOFT_SOIL_CREEP",
    "STRENGTH",
    "InterfaceMaterial",
    "LinearElastic",
    "Material",
    "MohrCoulomb",
    "SoftSoilCreepMaterial",
    "shear_modulus",
]

CONSTANTS: Final = 18
"""Numbers that describe a material of a region to the kernels: its kind, its unit weight, and up to 16 constants."""

INTERFACE_CONSTANTS: Final = 6

ELASTIC: Final = 0
MOHR_COULOMB: Final = 1
SOFT_SOIL_CREEP: Final = 2

STRENGTH: Final = {MOHR_COULOMB: (4, 5, 6, 7, 8), SOFT_SOIL_CREEP: (9, 10, 11, 12, 16)}
"""Where the constants of a soil hold cohesion, sine and cosine of friction, sine of dilatancy, and tension cut-off."""

INTERFACE_STRENGTH: Final = (2, 3, 4, 5)
"""Where those of an interface hold cohesion, tangents of friction and dilatancy, and tension cut-off."""


def _range(name: str, value: float, accepted: bool, words: str) -> None:
    if not accepted:
        raise InfeasibleError(f"{name} = {value:g}: {words} is accepted")


def _elastic(young: float, poisson: float, unit_weight: float) -> None:
    _range("young", young, 0.0 < young < math.inf, "a value above 0 kPa")
    _range("poisson", poisson, -1.0 < poisson < 0.5, "a value above -1 and below 0.5")
    _range("unit_weight", unit_weight, 0.0 <= unit_weight < math.inf, "0 kN/m3 or more")


def _strength(c: float, phi: float, psi: float, tension_cutoff: float | None) -> None:
    _range("c", c, 0.0 <= c < math.inf, "0 kPa or more")
    _range("phi", phi, 0.0 <= phi < 90.0, "a value from 0 to below 90 degree")
    _range("psi", psi, 0.0 <= psi <= phi, f"a value from 0 to phi = {phi:g} degree")
    if tension_cutoff is not None:
        _range("tension_cutoff", tension_cutoff, tension_cutoff >= 0.0, "0 kPa or more")


@dataclass(frozen=True)
class LinearElastic:
    """Linear isotropic elasticity: ``young`` kPa, ``poisson``, ``unit_weight`` kN/m3.

    Raises
    ------
    InfeasibleError
        A constant is outside its range.
    """

    young: float
    poisson: float
    unit_weight: float = 0.0
    K0: float | None = None
    """Ratio of horizontal to vertical stress in a K0 phase; poisson/(1 - poisson) unless given."""

    def __post_init__(self) -> None:
        _elastic(self.young, self.poisson, self.unit_weight)

    def constants(self) -> FloatArray:
        """Constants for the kernels, shape (CONSTANTS,)."""
        return _filled(ELASTIC, self.unit_weight, self.young, self.poisson)

    def lateral_ratio(self) -> float:
        """K0 of a K0 phase."""
        return self.poisson / (1.0 - self.poisson) if self.K0 is None else self.K0


@dataclass(frozen=True)
class MohrCoulomb:
    """Linear elasticity up to the Mohr-Coulomb limit, perfectly plastic, with dilatancy and tension cut-off.

    ``young`` kPa, ``poisson``, ``c`` kPa, ``phi`` and ``psi`` degree (psi from 0 to phi), ``tension_cutoff`` kPa (None:
    none, the apex remains), ``unit_weight`` kN/m3.

    Raises
    ------
    InfeasibleError
        A constant is outside its range.
    """

    young: float
    poisson: float
    c: float
    phi: float
    psi: float = 0.0
    tension_cutoff: float | None = 0.0
    unit_weight: float = 0.0
    K0: float | None = None
    """Ratio of horizontal to vertical stress in a K0 phase; 1 - sin(phi) unless given."""

    def __post_init__(self) -> None:
        _elastic(self.young, self.poisson, self.unit_weight)
        _strength(self.c, self.phi, self.psi, self.tension_cutoff)

    def constants(self) -> FloatArray:
        """Constants for the kernels, shape (CONSTANTS,)."""
        phi, psi = math.radians(self.phi), math.radians(self.psi)
        tension = math.inf if self.tension_cutoff is None else self.tension_cutoff
        return _filled(
            MOHR_COULOMB,
            self.unit_weight,
            self.young,
            self.poisson,
            self.c,
            math.sin(phi),
            math.cos(phi),
            math.sin(psi),
            tension,
        )

    def lateral_ratio(self) -> float:
        """K0 of a K0 phase."""
        return 1.0 - math.sin(math.radians(self.phi)) if self.K0 is None else self.K0


@dataclass(frozen=True)
class SoftSoilCreepMaterial:
    """Soft soil creep with its own weight and its state when it is placed.

    Parameters
    ----------
    soil
        Constants, from :func:`geoswarm.solver.constitutive.soft_soil_creep.soft_soil_creep`.
    unit_weight
        kN/m3.
    OCR, POP
        Where this material is placed (a region gets it in a phase), p_p = OCR p_eq of the stress there, or with POP
        (kPa), p_eq of the stress with the vertical stress raised by POP and the horizontal ones by K0nc POP.

    Raises
    ------
    InfeasibleError
        A constant is outside its range.
    """

    soil: SoftSoilCreep
    unit_weight: float = 0.0
    OCR: float = 1.0
    POP: float | None = None
    K0: float | None = None
    """Ratio of horizontal to vertical stress in a K0 phase; the soil's K0nc unless given."""

    def __post_init__(self) -> None:
        _range("unit_weight", self.unit_weight, 0.0 <= self.unit_weight < math.inf, "0 kN/m3 or more")
        _range("OCR", self.OCR, 1.0 <= self.OCR < math.inf, "1 or more")
        if self.POP is not None:
            _range("POP", self.POP, 0.0 <= self.POP < math.inf, "0 kPa or more")

    def constants(self) -> FloatArray:
        """Constants for the kernels, shape (CONSTANTS,)."""
        return _filled(SOFT_SOIL_CREEP, self.unit_weight, *self.soil)

    def lateral_ratio(self) -> float:
        """K0 of a K0 phase."""
        return self.soil.K0nc if self.K0 is None else self.K0


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

    @classmethod
    def from_soil(
        cls, shear_modulus: float, c: float, phi: float, reduction: float, thickness: float
    ) -> InterfaceMaterial:
        """Interface in a soil with strength and stiffness reduced by a factor R.

        Parameters
        ----------
        shear_modulus, c, phi
            Of the soil: kPa, kPa, degree.
        reduction
            R, above 0, at most 1: G_i = R^2 G, tan(phi_i) = R tan(phi), c_i = R c, nu_i = 0.45.
        thickness
            Virtual thickness t_i, m: k_s = G_i/t_i, k_n = E_oed,i/t_i.
        """
        _range("reduction", reduction, 0.0 < reduction <= 1.0, "a value above 0, at most 1")
        _range("thickness", thickness, 0.0 < thickness < math.inf, "a value above 0 m")
        shear = reduction**2 * shear_modulus
        oedometer = 2.0 * shear * (1.0 - 0.45) / (1.0 - 2.0 * 0.45)
        friction = math.degrees(math.atan(reduction * math.tan(math.radians(phi))))
        return cls(oedometer / thickness, shear / thickness, reduction * c, friction)

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


Material: TypeAlias = LinearElastic | MohrCoulomb | SoftSoilCreepMaterial


def shear_modulus(material: Material, p: float = 100.0) -> float:
    """Shear modulus, kPa; that of soft soil creep at the mean stress ``p`` (kPa, compression positive)."""
    if isinstance(material, SoftSoilCreepMaterial):
        soil = material.soil
        return soil.shear_ratio * max(p + soil.shift, soil.pressure_floor) / soil.kappa_star
    return material.young / (2.0 * (1.0 + material.poisson))


def _filled(kind: int, unit_weight: float, *values: float) -> FloatArray:
    constants = np.zeros(CONSTANTS)
    constants[0], constants[1] = kind, unit_weight
    constants[2 : 2 + len(values)] = values
    return constants
