"""What the sections of laws in libraries of the user's have in common, and the expressions in them."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, ValidationInfo, field_validator
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import CoreSchema, core_schema

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.declared_parameter import DeclaredParameter
from geoswarm.solver.errors import ExpressionError, InfeasibleError, Issue, ProblemError
from geoswarm.solver.expressions import Expression, parse_expression
from geoswarm.solver.external.runs.fingerprints import fingerprint
from geoswarm.solver.laws.base import mean_and_squared_q
from geoswarm.solver.section import Name, Section
from geoswarm.solver.units import UnitError, convert
from geoswarm.solver.words import did_you_mean

if TYPE_CHECKING:
    from geoswarm.solver.user_laws.law import UserLaw

__all__ = ["STRESS_NAMES", "Formula", "Moduli", "Place", "UserLawSection", "names_in", "stress_values", "value_of"]

STRESS_NAMES = ("p", "q", "sigma_xx", "sigma_yy", "sigma_zz", "sigma_xy", "sigma_yz", "sigma_zx")
"""The stress under which a soil is placed, kPa, compression positive, in expressions of its initial state."""


class _FormulaRule:
    """Annotation of a field whose value is a number, or an expression as text."""

    def parse(self, value: Any) -> float | Expression:
        """Return a number, or an expression that has names."""
        if isinstance(value, Expression):
            return value
        if isinstance(value, str):
            try:
                found = parse_expression(value)
            except ExpressionError as error:
                raise ValueError(str(error)) from error
            if found.is_comparison:
                raise ValueError(f"'{found.text}' is a comparison; give a number or an expression")
            if found.names:
                return found
            value = found.value({})
        if isinstance(value, bool) or not isinstance(value, int | float) or not np.isfinite(value):
            raise ValueError("must be a number, or an expression of parameters as text")
        return float(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> CoreSchema:
        del source, handler
        written = core_schema.plain_serializer_function_ser_schema(
            lambda value: value.text if isinstance(value, Expression) else value
        )
        return core_schema.no_info_plain_validator_function(self.parse, serialization=written)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: Any) -> dict[str, Any]:
        del schema, handler
        return {"anyOf": [{"type": "number"}, {"type": "string"}]}


Formula: TypeAlias = Annotated[Any, _FormulaRule()]
"""A float, or an :class:`Expression` of parameters."""


def names_in(formula: float | Expression | None) -> frozenset[str]:
    """Names in a formula."""
    return formula.names if isinstance(formula, Expression) else frozenset()


def value_of(formula: float | Expression, values: Mapping[str, float | FloatArray], what: str) -> Any:
    """Value of a formula, a number or an array.

    Raises
    ------
    InfeasibleError
        It is none.
    """
    found = formula.value(values) if isinstance(formula, Expression) else formula
    if not (math.isfinite(found) if isinstance(found, float) else np.all(np.isfinite(found))):
        text = formula.text if isinstance(formula, Expression) else formula
        raise InfeasibleError(f"{what}: '{text}' has no finite value for these parameters")
    return found


def stress_values(stress: FloatArray) -> dict[str, float | FloatArray]:
    """Values of :data:`STRESS_NAMES`, each of shape (...), for stresses (..., 4 or 6), compression positive."""
    if stress.ndim == 1:  # numbers, with which expressions are ten times as quick
        s = [*stress.tolist(), 0.0, 0.0][:6]
        p = (s[0] + s[1] + s[2]) / 3.0
        q = math.sqrt(1.5 * sum((one - p) ** 2 for one in s[:3]) + 3.0 * sum(one**2 for one in s[3:]))
        return dict(zip(STRESS_NAMES, (p, q, *s), strict=True))
    mean, squared = mean_and_squared_q(stress)
    components = [stress[..., i] if i < stress.shape[-1] else np.zeros_like(mean) for i in range(6)]
    return dict(zip(STRESS_NAMES, (mean, np.sqrt(squared), *components), strict=True))


class Moduli(Section):
    """Elastic moduli, kPa."""

    bulk: Formula = Field(description="Bulk modulus, kPa.")
    shear: Formula = Field(description="Shear modulus, kPa.")


Place: TypeAlias = tuple[str, "float | Expression | None", tuple[str, ...]]
"""Where a formula stands, the formula, and the names that it may have beside parameters."""


class UserLawSection(Section):
    """A soil law in a shared library beside the problem file; see docs/user-laws.md."""

    law: str
    library: str = Field(min_length=1, max_length=1000, description="Shared library, relative to the problem file.")
    parameters: dict[Name, DeclaredParameter] = Field({}, max_length=100, description="Parameters of the law by name.")
    K0: Formula | None = Field(None, description="Ratio of horizontal to vertical stress at rest.")
    moduli: Moduli | None = Field(
        None, description="Elastic moduli for estimates; those of the law's tangent at rest unless given."
    )
    time_scale: Formula | None = Field(
        None, description="Time in which creep slows down by half, day: the first time step of a hold."
    )
    limit: Name | None = Field(None, description="State variable that shows whether the point yields.")
    perfectly_plastic: bool = Field(
        False, description="The tangent may lose all stiffness: finite elements mix elastic stiffness into it."
    )
    tangent: Literal["routine", "differences"] = Field(
        "routine", description="That of the library, or by differences, which cost one more call per component."
    )
    stress_unit: str = Field("kPa", max_length=50, description="Unit of stress in the library.")
    time_unit: str = Field("day", max_length=50, description="Unit of time in the library.")
    least_time: float = Field(
        1.0e-9, gt=0.0, description="Smallest time increment passed to it, day: many routines divide by it."
    )
    temperature: float = Field(0.0, description="Temperature passed to it.")
    stateful: bool = Field(
        False, description="It keeps state between calls (SAVE, COMMON): each run gets its own process."
    )
    # Only in canonical problems; users do not write it.
    folder: SkipJsonSchema[str | None] = Field(None, description="where the library lies")
    version: SkipJsonSchema[str | None] = Field(None, description="SHA-256 of the library")

    @field_validator("stress_unit", "time_unit")
    @classmethod
    def _known_unit(cls, value: str, info: ValidationInfo) -> str:
        try:
            convert(1.0, value, "kPa" if info.field_name == "stress_unit" else "day")
        except UnitError as error:
            raise ValueError(str(error)) from error
        return value

    @property
    def file(self) -> str:
        """Name of the library's file."""
        return self.library

    @property
    def place(self) -> Path:
        """Where the library is."""
        return Path(self.folder or ".") / self.file

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names that formulas may have."""
        return tuple(self.parameters)

    @property
    @abstractmethod
    def made(self) -> UserLaw:
        """The law that the section describes."""

    def formulas(self) -> list[Place]:
        """All formulas of the section; a subclass adds its own."""
        found: list[Place] = [("K0", self.K0, ()), ("time_scale", self.time_scale, ("p",))]
        if self.moduli is not None:
            found += [("moduli.bulk", self.moduli.bulk, ("p",)), ("moduli.shear", self.moduli.shear, ("p",))]
        return found

    def wrong_names(self) -> str | None:
        """A name in the formulas that is not a parameter, or a parameter that is in none, in words."""
        reserved = sorted(self.parameters.keys() & set(STRESS_NAMES))
        if reserved:
            return f"parameters.{reserved[0]}: the name stands for the stress; choose another"
        used = set(self.parameter_names) - set(self.parameters)
        for place, formula, beyond in self.formulas():
            known = (*self.parameter_names, *beyond)
            for name in sorted(names_in(formula)):
                if name not in known:
                    return f"{place}: {name} is unknown{did_you_mean(name, known)}; known: {', '.join(known) or 'none'}"
                used.add(name)
        unused = [name for name in self.parameters if name not in used]
        if unused:
            return f"parameters.{unused[0]} is used nowhere; write it into props, state, K0 or moduli"
        return None

    def wrong_limit(self, known: Sequence[str], what: str = "state variable") -> str | None:
        """A limit that is none of the state variables known, in words."""
        if self.limit is None or self.limit in known:
            return None
        return (
            f"limit: {self.limit} is not a {what}{did_you_mean(self.limit, known)}; known: {', '.join(known) or 'none'}"
        )

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With the folder and the fingerprint of the library; nothing of it is executed in this process.

        Raises
        ------
        ProblemError
            It is missing, or no file may be named.
        """
        if self.folder is not None and self.version is not None:
            return self
        if folder is None and self.folder is None:
            text = f"law: {self.law} names a file; it is accepted from problem files only"
            raise ProblemError([Issue(f"{path}.library", text)])
        base = self.library_folder(folder, path) if self.folder is None else Path(self.folder)
        place = base / self.file
        if not place.is_file():
            what = "is not a file" if place.exists() else f"is not in {base}"
            raise ProblemError([Issue(f"{path}.library", f"{self.file} {what}")])
        return self.model_copy(update={"folder": str(base), "version": fingerprint(place)})

    def library_folder(self, folder: Path | None, path: str) -> Path:
        """The folder of the library; raises ProblemError."""
        del path
        return Path(folder or ".").resolve()

    def unavailable(self) -> str | None:
        """Why it cannot be used on this machine, in words."""
        if self.place.is_file():
            return None
        return f"the library {self.place} of law: {self.law} is not there"
