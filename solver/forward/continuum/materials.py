"""Materials of a body in a problem file: constants that are numbers or expressions of parameters."""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator
from pydantic.json_schema import SkipJsonSchema

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.continuum.quantity import Amount, ValueRange
from geoswarm.solver.laws.base import Law, Setting
from geoswarm.solver.laws.registry import installed_laws
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.solver.section import Name
from geoswarm.solver.user_laws.mfront import MfrontSection
from geoswarm.solver.user_laws.section import UserLawSection
from geoswarm.solver.user_laws.umat import UmatSection
from geoswarm.solver.words import did_you_mean

__all__ = ["InterfaceSection", "LawSection", "MaterialSection", "SoilSection", "UmatSoil", "UserSoil", "law_section"]

_Cohesion: TypeAlias = Annotated[Any, ValueRange("kPa", 0.0)]
_Angle: TypeAlias = Annotated[Any, ValueRange("degree", 0.0, upper=90.0, upper_open=True)]


class SoilSection(BaseModel):
    """A soil: what all laws have in common."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    law: str
    unit_weight: Annotated[Any, ValueRange("kN/m^3", 0.0)] = Field(0.0, description="Unit weight, kN/m³.")

    @property
    @abstractmethod
    def soil_law(self) -> Law:
        """The law."""

    @abstractmethod
    def given(self, name: str) -> Any:
        """What is given for a parameter or setting of the law: a number, a quantity, a choice, or None."""


class LawSection(SoilSection):
    """A soil of an installed law; each law adds its parameters and settings."""

    of: ClassVar[Law]

    @property
    def soil_law(self) -> Law:
        """The law that the section was made for."""
        return self.of

    def given(self, name: str) -> Any:
        """The field of that name."""
        return getattr(self, name)

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


class UserSoil(SoilSection, UserLawSection):
    """A soil of a law in a library; its parameters get their values here."""

    values: dict[Name, Amount] = Field(
        {}, max_length=100, description="Values of the law's parameters: numbers or expressions."
    )

    @property
    def soil_law(self) -> Law:
        """The law of the library."""
        return self.made

    def given(self, name: str) -> Any:
        """The value of a parameter."""
        return self.values.get(name)

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With what is known of the library; raises ProblemError also for values that do not fit the parameters."""
        found = super().with_files(folder, path)
        known = {info.name: info for info in found.made.parameters}
        for name in found.values:
            if name not in known:
                text = f"is unknown{did_you_mean(name, known)}; known: {', '.join(known)}"
                raise ProblemError([Issue(f"{path}.values.{name}", text)])
        for name, info in known.items():
            if name not in found.values and info.default is None:
                text = "is missing; give a number or an expression"
                raise ProblemError([Issue(f"{path}.values.{name}", text)])
        return found


class UmatSoil(UserSoil, UmatSection):
    """A soil of a compiled Abaqus user routine."""

    law: Literal["umat"] = "umat"


class MfrontSoil(UserSoil, MfrontSection):
    """A soil of a behaviour of MFront."""

    law: Literal["mfront"] = "mfront"


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
    MaterialSection: TypeAlias = SoilSection | InterfaceSection
else:
    # Forms and services know the installed ones alone: a library is never named over the network.
    _SECTIONS = [*(law_section(law) for law in installed_laws()), InterfaceSection]
    _SECTIONS += [SkipJsonSchema[UmatSoil], SkipJsonSchema[MfrontSoil]]
    MaterialSection = Annotated[reduce(or_, _SECTIONS), Field(discriminator="law")]
    """A soil of any installed law, one of a library, or an interface, told apart by its law."""
