"""Materials of a body in a problem file: constants that are numbers or expressions of parameters."""

from __future__ import annotations

import math
from functools import reduce
from operator import or_
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator

from geoswarm.solver.forward.continuum.quantity import ValueRange
from geoswarm.solver.laws.base import Law, Setting
from geoswarm.solver.laws.registry import installed_laws
from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["InterfaceSection", "LawSection", "MaterialSection", "law_section"]

_Cohesion: TypeAlias = Annotated[Any, ValueRange("kPa", 0.0)]
_Angle: TypeAlias = Annotated[Any, ValueRange("degree", 0.0, upper=90.0, upper_open=True)]


class LawSection(BaseModel):
    """A soil: what all laws have in common; each law adds its parameters and settings."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    of: ClassVar[Law]

    law: str
    unit_weight: Annotated[Any, ValueRange("kN/m^3", 0.0)] = Field(0.0, description="Unit weight, kN/m³.")

    @model_validator(mode="after")
    def _consistent(self) -> LawSection:
        given = frozenset(info.name for info in self.of.parameters if getattr(self, info.name) is not None)
        fault = self.of.incomplete(given)
        if fault is not None:
            raise ValueError(fault)
        return self


def _parameter_field(law: Law, info: ParameterInfo) -> Any:
    derived = info.name in law.derived
    limits = ValueRange(
        info.unit,
        -math.inf if info.lower is None else info.lower,
        info.lower_open or derived,  # what follows from others is left out, or None
        math.inf if info.upper is None else info.upper,
        info.upper_open,
    )
    kind: Any = Annotated[Any, limits]
    text = f"{info.description.rstrip('.')} [{info.unit}]." if info.unit else info.description
    if derived:
        return (kind | None, Field(None, description=text))
    return (kind, Field(... if info.default is None else info.default, description=text))


def _setting_field(one: Setting) -> Any:
    if one.choices:
        return (Literal[one.choices], Field(one.default, description=one.description))
    return (Annotated[Any, ValueRange(one.unit, one.lower)] | None, Field(one.default, description=one.description))


def law_section(law: Law) -> type[LawSection]:
    """Make the section of a law's soils from what the law declares."""
    fields: dict[str, Any] = {"law": (Literal[law.kind], law.kind)}
    fields |= {info.name: _parameter_field(law, info) for info in law.parameters}
    fields |= {one.name: _setting_field(one) for one in law.settings}
    made = create_model(f"{type(law).__name__}Section", __base__=LawSection, __doc__=f"{law.title}.", **fields)
    made.of = law
    return made


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


if TYPE_CHECKING:
    MaterialSection: TypeAlias = LawSection | InterfaceSection
else:
    MaterialSection = Annotated[
        reduce(or_, [*(law_section(law) for law in installed_laws()), InterfaceSection]), Field(discriminator="law")
    ]
    """A soil of any installed law, or an interface, told apart by its law."""
