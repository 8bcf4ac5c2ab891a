"""What happens to a body, in phases, in a problem file."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.forward.continuum.geometry import Name
from geoswarm.solver.forward.continuum.quantity import Length, ValueRange

__all__ = ["Fixity", "LoadSection", "PhaseSection", "VectorSection"]

Fixity: TypeAlias = Literal["free", "horizontal", "vertical", "both"]
"""Which displacements of a boundary are zero."""

BoundaryName: TypeAlias = Annotated[
    str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z_][A-Za-z0-9_]*)?$", max_length=101)
]
"""Name of a boundary, such as ``right`` or ``right.cover``."""


class LoadSection(BaseModel):
    """A load on a boundary; it acts from its phase on, until a later phase gives another one for this boundary."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    boundary: BoundaryName = Field(description="Name of the boundary.")
    pressure: Annotated[Any, ValueRange("kPa")] = Field(0.0, description="Normal, kPa, positive onto the body.")
    pressure_increase: Annotated[Any, ValueRange("kN/m^3")] = Field(
        0.0, description="By how much the pressure grows with a metre of depth, kPa/m."
    )
    x: Annotated[Any, ValueRange("kPa")] = Field(0.0, description="Traction along x, kPa.")
    y: Annotated[Any, ValueRange("kPa")] = Field(0.0, description="Traction along y (upwards), kPa.")
    level: Length = Field(0.0, description="Height from which the depth counts, m.")
    follows: bool = Field(False, description="Whether the load turns with the boundary where the mesh is updated.")


class PhaseSection(BaseModel):
    """One phase. What is not mentioned stays as in the phase before."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    name: Name = Field(description="Name of the phase.")
    kind: Literal["gravity", "K0", "plastic", "creep"] = Field(
        description="gravity or K0: initial stresses; plastic: loads at once; creep: time passes."
    )
    materials: dict[Name, Name] = Field(
        default={}, description="Material by region and interface; the first phase gives one to each of them."
    )
    activate: list[Name] = Field(default=[], description="Regions that are active from this phase on.")
    deactivate: list[Name] = Field(default=[], description="Regions that are removed.")
    fixities: dict[BoundaryName, Fixity] = Field(default={}, description="Boundaries whose fixity changes.")
    loads: list[LoadSection] = Field(default=[], max_length=100, description="Loads from this phase on.")
    duration: Annotated[Any, ValueRange("day", 0.0, lower_open=True)] | None = Field(
        None, description="Duration, day; only for creep, and required there."
    )
    updated_mesh: bool = Field(
        False, description="Whether equilibrium holds in the deformed mesh (large deformations)."
    )
    reset_displacements: bool = Field(False, description="Whether displacements are reset to zero at its start.")

    @model_validator(mode="after")
    def _duration_of_creep(self) -> PhaseSection:
        if (self.kind == "creep") != (self.duration is not None):
            needed = "a duration in days is needed" if self.kind == "creep" else "only creep has a duration"
            raise ValueError(f"phase {self.name} of kind {self.kind}: {needed}")
        return self


class VectorSection(BaseModel):
    """Displacement vectors of several points over a period, such as those of repeated surveys."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    points: list[Name] = Field(min_length=1, max_length=200, description="Points; the first has the number 1.")
    start: float = Field(0.0, ge=0.0, description="Start of the period, day since the zero of time.")
    end: float = Field(gt=0.0, description="End of the period, day since the zero of time.")

    @model_validator(mode="after")
    def _ordered(self) -> VectorSection:
        if self.start >= self.end:
            raise ValueError(f"start must be below end = {self.end:g} day, got {self.start:g} day")
        return self
