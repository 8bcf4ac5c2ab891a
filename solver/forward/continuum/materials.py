"""Materials of a body in a problem file: constants that are numbers or expressions of parameters."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.forward.continuum.quantity import ValueRange

__all__ = [
    "ElasticSection",
    "InterfaceSection",
    "MaterialSection",
    "MohrCoulombSection",
    "SoftSoilCreepSection",
]

_Modulus: TypeAlias = Annotated[Any, ValueRange("kPa", 0.0, lower_open=True)]
_Poisson: TypeAlias = Annotated[Any, ValueRange("", 0.0, upper=0.4999)]
_Weight: TypeAlias = Annotated[Any, ValueRange("kN/m^3", 0.0)]
_Cohesion: TypeAlias = Annotated[Any, ValueRange("kPa", 0.0)]
_Angle: TypeAlias = Annotated[Any, ValueRange("degree", 0.0, upper=89.0)]
_Index: TypeAlias = Annotated[Any, ValueRange("", 0.0, lower_open=True)]


class _Material(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    unit_weight: _Weight = Field(0.0, description="Unit weight, kN/m³.")


class _ElasticMaterial(_Material):
    E: _Modulus | None = Field(None, description="Young's modulus, kPa; or give G.")
    G: _Modulus | None = Field(None, description="Shear modulus, kPa; or give E.")
    nu: _Poisson = Field(description="Poisson's ratio.")

    @model_validator(mode="after")
    def _one_modulus(self) -> _ElasticMaterial:
        if (self.E is None) == (self.G is None):
            raise ValueError("exactly one of E and G is accepted")
        return self


class ElasticSection(_ElasticMaterial):
    """Linear elastic."""

    law: Literal["elastic"] = "elastic"


class MohrCoulombSection(_ElasticMaterial):
    """Linear elastic, perfectly plastic with the strength of Mohr and Coulomb."""

    law: Literal["mohr_coulomb"] = "mohr_coulomb"
    c: _Cohesion = Field(description="Cohesion, kPa.")
    phi: _Angle = Field(description="Friction angle, degree.")
    psi: _Angle = Field(0.0, description="Dilatancy angle, degree, at most phi.")
    tension_cutoff: _Cohesion | None = Field(0.0, description="Largest admissible tension, kPa; null for no cut-off.")


class SoftSoilCreepSection(_Material):
    """Soft soil creep, as in the laboratory tests."""

    law: Literal["soft_soil_creep"] = "soft_soil_creep"
    lambda_star: _Index = Field(description="Modified compression index.")
    kappa_star: _Index = Field(description="Modified swelling index.")
    mu_star: _Index = Field(description="Modified creep index.")
    c: _Cohesion = Field(description="Cohesion, kPa.")
    phi: _Angle = Field(description="Friction angle, degree.")
    psi: _Angle = Field(0.0, description="Dilatancy angle, degree, at most phi.")
    nu_ur: _Poisson = Field(0.15, description="Poisson's ratio for unloading and reloading.")
    K0nc: Annotated[Any, ValueRange("", 0.0, lower_open=True, upper=0.999)] | None = Field(
        None, description="Stress ratio of normally consolidated compression; 1 - sin(phi) unless K0nc or M is given."
    )
    M: _Index | None = Field(None, description="Slope of the tops of the ellipses; from K0nc unless given.")
    OCR: Annotated[Any, ValueRange("", 1.0)] = Field(
        1.0,
        description="Initial overconsolidation ratio p_p/p_eq; both hold c cot(phi) if the formulation is translated.",
    )
    formulation: Literal["translated", "untranslated"] = Field(
        "translated", description="Whether stiffness and creep see the mean stress shifted by c cot(phi)."
    )
    tension_cutoff: _Cohesion | None = Field(0.0, description="Largest admissible tension, kPa; null for no cut-off.")


class InterfaceSection(BaseModel):
    """Friction between the two sides of an interface, which may open."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    law: Literal["interface"] = "interface"
    normal_stiffness: Annotated[Any, ValueRange("kPa/m", 0.0, lower_open=True)] = Field(
        description="Normal stiffness, kPa/m."
    )
    shear_stiffness: Annotated[Any, ValueRange("kPa/m", 0.0, lower_open=True)] = Field(
        description="Shear stiffness, kPa/m."
    )
    c: _Cohesion = Field(description="Cohesion, kPa.")
    phi: _Angle = Field(description="Friction angle, degree.")
    psi: _Angle = Field(0.0, description="Dilatancy angle, degree, at most phi.")
    tension_cutoff: _Cohesion = Field(0.0, description="Largest admissible tension, kPa.")


MaterialSection: TypeAlias = Annotated[
    ElasticSection | MohrCoulombSection | SoftSoilCreepSection | InterfaceSection, Field(discriminator="law")
]
"""Any material, told apart by its law."""
