"""Models of a body: its mesh, what was measured on it, and how it moves."""

from __future__ import annotations

from pydantic import BaseModel, Field

from geoswarm.api.schemas.responses import Number

__all__ = ["MeshAnswer", "MeshFields"]


class Phase(BaseModel):
    """What happens to the body."""

    name: str
    kind: str
    end: float | None = Field(description="day since the zero of time; null long before it")


class Displacement(BaseModel):
    """Displacement of an observed point in a period, m."""

    name: str = Field(description="of the survey, or 'last readings' of series over time")
    point: str
    x: float
    y: float
    start: float = Field(description="day since the zero of time")
    end: float
    measured: tuple[Number, Number] = Field(description="ux, uy; null: not measured")
    calculated: tuple[Number, Number]


class MeshAnswer(BaseModel):
    """The mesh of an evaluation, undeformed, and the displacements of its observed points."""

    part: str = Field(description="of a combined model, else empty")
    parts: list[str] = Field(description="parts that have a mesh")
    generation: int | None = Field(
        description="of the evaluation; null: none yet, the mesh is that of the nominal geometry"
    )
    particle: int | None
    objective: Number
    objective_unit: str = Field(description="empty where series of different units add up")
    parameters: dict[str, float]
    nodes: list[tuple[float, float]] = Field(description="x, y [m]")
    triangles: list[list[int]] = Field(description="corners 0, 1, 2, then the mid-sides of 01, 12 and 20")
    regions: list[int] = Field(description="index into region_names of each triangle")
    region_names: list[str]
    interfaces: list[list[int]] = Field(description="start, end and mid of side A, then of side B")
    points: dict[str, int] = Field(description="nodes of named points")
    phases: list[Phase]
    start: str | None = Field(description="phase at whose end the usual period begins; null: before the first")
    end: str = Field(description="phase at whose end it ends")
    vectors: list[Displacement]


class MeshFields(BaseModel):
    """How a body moves between the ends of two phases."""

    start: str | None
    end: str
    generation: int | None
    particle: int | None
    displacement: list[tuple[float, float]] = Field(description="ux, uy of every node [m]")
    shear_strain: list[list[float]] = Field(
        description="largest shear strain in the plane at the six nodes of every triangle [-]"
    )
